// SPDX-License-Identifier: Apache-2.0
// Modes that no spectrum made: random amplitudes on a disc of the lattice, deep-water frequencies.
#pragma once

#include <cmath>
#include <complex>
#include <cstdint>

#include "sea/waves/realization.h"

namespace seaway::sea {

/// splitmix64, mapped to [-1, 1).
inline double next_number(std::uint64_t& state) {
    state += 0x9e3779b97f4a7c15u;
    std::uint64_t z = state;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    z ^= z >> 31;
    return static_cast<double>(static_cast<std::int64_t>(z)) * 0x1p-63;
}

/// Lattice index of an array index.
inline int lattice(std::size_t i, int size) {
    return signed_index(static_cast<int>(i), size);
}

/// Amplitudes fall like k^-2; `reach` is the radius of the disc in lattice steps (size: all modes
/// but the Nyquist row and column).
inline CascadeModes random_modes(int size, double reach, std::uint64_t seed,
                                 double length_m = 100.0) {
    const auto n = static_cast<std::size_t>(size);
    CascadeModes modes;
    modes.spec = {length_m, size};
    modes.band = {0, 1e9};
    modes.depth_m = 8.0; // of a tile of 100 m: coth(kd) runs from 2.1 to 1
    modes.h0.resize(n * n);
    modes.rate.resize(n * n);
    for (std::size_t iy = 0; iy < n; ++iy) {
        for (std::size_t ix = 0; ix < n; ++ix) {
            const int nx = lattice(ix, size), ny = lattice(iy, size);
            const double radius = std::hypot(nx, ny);
            if (nx == -size / 2 || ny == -size / 2 || radius == 0 || radius > reach)
                continue;
            const double k = radius * modes.spec.wavenumber_step_radpm();
            const double re = next_number(seed), im = next_number(seed);
            modes.h0[iy * n + ix] = std::complex(re, im) / (radius * radius);
            modes.rate[iy * n + ix] = rate_from_omega(std::sqrt(9.81 * k));
        }
    }
    return modes;
}

} // namespace seaway::sea
