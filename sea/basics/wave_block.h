// SPDX-License-Identifier: Apache-2.0
// WaveBlock: one layer of 8 x 8 neighbouring waves of one cascade, as whole multiples of their steps: what a
// spectrum is cut into where it travels (sea/waves/quantised_spectrum.h makes them, protocol/spectrum_codec.h their
// bytes). The layers of a block add up.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace seaway::sea {

struct WaveBlock {
    static constexpr int side = 8;
    /// Of a lattice of 2048: blocks -128 .. 127.
    static constexpr int index_max = 127;
    static constexpr int shift_max = 15;

    int cascade = 0;
    int bx = 0; ///< its waves are nx = 8 bx .. 8 bx + 7, -128 .. 127
    int by = 0;
    int shift = 0;      ///< 0 .. shift_max
    bool given = false; ///< holds waves whose phases a scene gives
    /// [j][i][real, imaginary]: what is added to h0(8 bx + i, 8 by + j), in steps of its layer.
    std::array<std::int32_t, std::size_t{2} * side * side> codes{};

    bool operator==(const WaveBlock&) const = default;
};

/// What one step of a wave is, m. In the last layer, of shift 0: wide for long waves, narrow for short ones, which are
/// steep for their height. A coarse layer is about heights alone.
struct SpectrumSteps {
    double step_m = 0;
    double length_m = 0;
    double of(double k_radpm, int shift) const {
        return shift > 0 ? std::ldexp(step_m, shift)
                         : step_m / std::sqrt(1.0 + (k_radpm * length_m) * (k_radpm * length_m));
    }
    bool operator==(const SpectrumSteps&) const = default;
};

/// Standard deviations of what a spectrum misses, at any place and time, of which bound_sigmas (sea/basics/deviations.h) are a bound: it is
/// the sum of what thousands of waves of random phases are off by. Of waves whose phases were given they are a fifth of what those miss
/// where all add up.
struct SpectrumLeft {
    double height_m = 0;
    double displacement_m = 0; ///< along the line where it is most
    double slope = 0;          ///< likewise of the slope
};

} // namespace seaway::sea
