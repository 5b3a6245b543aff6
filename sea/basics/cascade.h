// SPDX-License-Identifier: Apache-2.0
// Cascades: periodic square tiles of different length that share the wavenumber plane.
//
// Every wave belongs to exactly one cascade: cascade c owns k_lo <= |k| < k_hi, the bands join
// without gap or overlap, and |k| >= k_hi of the last one is cut off (and reported as lost).
// Lattice of a cascade: k = 2 pi (nx, ny) / length, with nx, ny in [-size/2 + 1, size/2 - 1]; row
// and column -size/2 have no partner at +size/2 and stay zero (traps T29).
//
// Pure functions; thread-safe.
#pragma once

#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

#include "base/result.h"

namespace seaway::sea {

/// One tile as a scene names it.
struct CascadeSpec {
    double length_m; ///< side of the tile, m, 0.1 .. 1e6
    int size;        ///< grid points a side: 16 .. 2048, a power of two (GPU kernels: 64 .. 2048)

    double wavenumber_step_radpm() const { return 2.0 * std::numbers::pi / length_m; }
    double nyquist_radpm() const { return std::numbers::pi * size / length_m; }
    double spacing_m() const { return length_m / size; }
};

/// Of a sea, a bit each.
inline constexpr std::uint32_t all_cascades = 0xffffffffu;

/// Half-open range of |k|, rad/m.
struct Band {
    double k_lo_radpm;
    double k_hi_radpm;

    bool contains(double k_radpm) const { return k_lo_radpm <= k_radpm && k_radpm < k_hi_radpm; }
};

/// A band starts this many lattice steps out, so that its first ring holds enough directions
/// (traps T25); the longest-wave cascade starts at its first mode. Just outside the modes at |n| = 6,
/// so that rounding cannot put them on either side.
inline constexpr double band_start_steps = 6.001;

/// A band ends at this share of Nyquist at the latest: 3.3 points a wave, which a cubic spline
/// still samples well (traps T25).
inline constexpr double band_end_share_of_nyquist = 0.6;

/// One band a cascade. `cascades` must be ordered from the longest tile to the shortest; an error
/// names the two that leave a gap or stand in the wrong order, or says that there are none.
Result<std::vector<Band>> assign_bands(std::span<const CascadeSpec> cascades);

/// Signed lattice index of array index i: 0 .. size/2-1, then -size/2 .. -1.
inline constexpr int signed_index(int i, int size) {
    return i < size / 2 ? i : i - size;
}

} // namespace seaway::sea
