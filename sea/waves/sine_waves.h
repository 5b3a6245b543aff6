// SPDX-License-Identifier: Apache-2.0
// Stylised seas: sums of a few sine, Gerstner or exponential-sine waves whose amplitude,
// wavenumber, speed and direction run along ramps (fractal sums), optionally with each wave dragged
// along by the ones before it.
//
// All wave vectors are snapped to the lattice of one tile, so the sea stays periodic. Sine and
// Gerstner waves are linear: they become modes (Gerstner's horizontal motion is the scene's
// choppiness). Exponential-sine waves are not: height(X,t) is evaluated point by point, with exact
// derivatives through the drag's chain rule and with mean level zero (traps T52-T54).
//
// Pure functions; thread-safe.
#pragma once

#include <cstdint>
#include <vector>

#include "sea/basics/dispersion.h"
#include "sea/basics/lagrangian_point.h"
#include "sea/basics/time.h"

namespace seaway::sea {

enum class SineKind : std::uint8_t { sine, gerstner, exponential };

/// The ramps as a scene gives them. Wave i = 0 .. count-1 has
///   amplitude  amplitude_m * amplitude_ratio^i      (all scaled to add up to amplitude_m if
///                                                    `normalise`)
///   wavenumber 2 pi / wavelength_m * wavenumber_ratio^i, snapped to the tile
///   speed      that of its wavenumber * speed_ratio^i (exponential only)
///   direction  towards_rad + up to direction_spread_rad either way, drawn for each wave
struct SineRamps {
    SineKind kind = SineKind::gerstner;
    double length_m = 256.0;        ///< the tile, 0.1 .. 1e6
    int count = 12;                 ///< 1 .. 64
    double amplitude_m = 1.0;       ///< 0 .. 100
    double wavelength_m = 64.0;     ///< of the longest wave
    double amplitude_ratio = 0.82;  ///< 0.01 .. 1
    double wavenumber_ratio = 1.18; ///< 1 .. 4
    double speed_ratio = 1.0;       ///< 0.1 .. 10
    double towards_rad = 0.0;
    double direction_spread_rad = 0.5; ///< 0 .. pi
    bool normalise = true;
    double sharpness = 1.0; ///< p of exp(p (sin - 1)), exponential only, 0.1 .. 10
    double drag = 0.0;      ///< share of a wave's slope that moves the next ones, 0 .. 2
};

/// Lattice steps that a ramp may reach: tiles stay affordable.
inline constexpr int sine_steps_max = 200;

/// Largest lattice index of the ramp's waves; above sine_steps_max the reader refuses it.
double sine_steps(const SineRamps& ramps);

struct SineWave {
    int nx;
    int ny;
    double amplitude_m;
    double phase_rad;
    double omega_radps;
};

/// The ramp's waves: directions and phases drawn from (seed, system, i).
std::vector<SineWave> sine_waves(const SineRamps& ramps, std::uint64_t seed, std::uint32_t system,
                                 const Dispersion& dispersion);

/// A non-linear stylised sea on its tile.
struct SineField {
    struct Wave {
        double kx_radpm;
        double ky_radpm;
        double amplitude_m;
        double phase_rad;
        Rate rate;
        double omega_radps; ///< what `rate` stands for
    };
    double length_m = 0.0;
    double sharpness = 1.0;
    double drag = 0.0;
    std::vector<Wave> waves;
};

SineField sine_field(const SineRamps& ramps, const std::vector<SineWave>& waves,
                     double height_scale, TimeUs loop_period_us);

/// Height, its slopes and its rate at a point; the displacement is zero. `phase_time` as
/// Realization::phase_time gives it. About 0.1 us a wave.
LagrangianPoint sines_at(const SineField& field, double x_m, double y_m, TimeUs phase_time);

/// Mean of exp(p (sin q - 1)) over q, and its variance.
struct ExponentialSine {
    double mean;
    double variance;
};
ExponentialSine exponential_sine(double sharpness);

} // namespace seaway::sea
