// SPDX-License-Identifier: Apache-2.0
// The inner loop of whole-grid maps (height_map.h): one row of points, several instruction sets.
//
// All cascades are cubic B-splines at one instant; a point costs 16 texels of 4 floats a cascade
// and evaluation. Coordinates are relative to the request's base, so that a point needs no
// reduction modulo a tile: an index is masked.
#pragma once

#include <cstddef>

#include "base/instructions.h"

namespace seaway::sea {

/// Spline coefficients of one cascade at one time: [y + 1][x + 1][height, D_x, D_y, 0], with the
/// border of SplineMap.
struct MapTile {
    const float* texels;
    int size;  ///< a power of two
    int pitch; ///< texels a row
    double texels_per_m;
    double base_x; ///< of coordinate 0, texels, 0 .. size
    double base_y;
};

enum class MapKind { height, displacement, normal };

/// A Newton step this short ends the search for a height: what its derivative misses there is half the curvature times the
/// square. Waves of steepness 0.3, as short as 3.5 texels, bend by 0.6 / spacing: 6e-5 m are left at most.
/// A normal is not corrected, and needs a shorter one: 6e-4 are left. No step is shorter than what a shift of some metres is
/// rounded to.
struct LastSteps {
    float height_m, normal_m;
};
constexpr LastSteps last_steps_of(double spacing_m) {
    const double fine_m = spacing_m < 0.125 ? spacing_m : 0.125;
    const auto at_least = [](double step_m) {
        return static_cast<float>(step_m > 2e-6 ? step_m : 2e-6);
    };
    const double normal_m = 1e-3 * fine_m;
    return {at_least(0.04 * fine_m), at_least(normal_m < 1e-4 ? normal_m : 1e-4)};
}

/// One row of a map.
struct MapRow {
    const MapTile* tiles;
    int tile_count;
    MapKind kind;
    int columns;
    double x0_m; ///< relative to the base, as y_m
    double step_m;
    double y_m;
    float choppiness_x;
    float choppiness_y;
    LastSteps last;
    float* shift_x; ///< [columns] lambda D at the point: a guess on entry, solved on return
    float* shift_y;
    float* out;    ///< [columns][components]
    int* unsolved; ///< [columns] columns that need the careful solver: folds, no convergence
};

struct MapKernel {
    /// Returns how many columns are unsolved.
    int (*row)(const MapRow& row);
};

/// The kernel for instructions that this machine has. With 16 floats a vector the work a point is
/// too small to gain from it: AVX-512 machines run the AVX2 kernel.
const MapKernel& map_kernel(Instructions instructions);

// One a translation unit that is compiled for them.
const MapKernel& map_kernel_portable();
const MapKernel& map_kernel_avx2();

} // namespace seaway::sea
