// SPDX-License-Identifier: Apache-2.0
// Octaves of value noise that drift over a periodic tile: random numbers at the corners of square
// cells, joined by quintic smoothsteps (Perlin 2002), so that height, slope and curvature are
// continuous; derivatives in closed form. Two cells to a wavelength.
//
// Statistics, for corners of variance 1/3 (even in -1 .. 1), u the smoothstep:
//   variance     I^2 / 3,            I = integral of u^2 + (1-u)^2 = 181/231
//   mean square slope along an axis  (20/7) I / 3 / cell^2
//
// Pure functions; thread-safe.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "sea/basics/lagrangian_point.h"
#include "sea/basics/time.h"

namespace seaway::sea {

/// Variance of an octave of amplitude 1 over all seeds.
inline constexpr double noise_variance = (181.0 / 231.0) * (181.0 / 231.0) / 3.0;
/// rms slope over rms height, times the length of a cell: k of an octave, both axes together.
inline constexpr double noise_slope_cells = 2.700521742100591; // sqrt(2 (20/7) (231/181))

struct NoiseOctave {
    int cells = 0; ///< a side of the tile
    double amplitude_m = 0.0;
    /// At the corners of the cells, [iy][ix]; their mean is zero, so the sea level is.
    std::shared_ptr<const std::vector<double>> corners;
    double variance = 0.0;    ///< of these corners, at amplitude 1
    double speed_x_mps = 0.0; ///< drift; what the rates stand for
    double speed_y_mps = 0.0;
    Rate rate_x = 0; ///< tiles a microsecond, 0.64 fixed point, modulo 1
    Rate rate_y = 0;
    std::uint64_t offset_x = 0; ///< tiles, 0.64 fixed point: where the pattern stands at time 0
    std::uint64_t offset_y = 0;
};

/// Corners drawn from (seed, system, octave), and their drift. With a loop the drift is a whole
/// number of tiles a period along each axis, at least one along the larger.
NoiseOctave noise_octave(int cells, double amplitude_m, double length_m, double speed_mps,
                         double towards_rad, std::uint64_t seed, std::uint32_t system,
                         std::uint32_t octave, TimeUs loop_period_us);

/// Adds the octave's height, slopes and rate.
void add_noise(const NoiseOctave& octave, double length_m, double x_m, double y_m,
               TimeUs phase_time, LagrangianPoint& point);

} // namespace seaway::sea
