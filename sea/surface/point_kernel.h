// SPDX-License-Identifier: Apache-2.0
// The inner loop of Surface::answer(): some scattered points at a time, several instruction sets.
//
// What a point costs is memory first: 4 x 4 coefficients of both keyframes of each cascade, some 60 lines of a
// cache. So the lines of all points of a block are asked for before the first is used, and cascades are taken one after
// the other, the first alone, then the second where the first has moved the point to, so that the patches of the fine ones
// are fetched about where they are needed. Patches are mixed in time once and kept while a point stays within its cell.
//
// Every lane does the same products and sums in the same order whatever the width of the vectors, and nothing is
// fused: all instruction sets give the same bits, a point alone the same as in a block. Single precision, about 1e-6 of
// what is summed; places in double. Solves where the surface is gentle, and says where it has not; nothing is allocated.
#pragma once

#include "base/instructions.h"

namespace seaway::sea {

/// Two keyframes of one cascade.
struct PointTile {
    const float* before; ///< coefficients of a SplineMap, its border included
    const float* after;
    double length_m;
    double size;
    double texels_per_m;
    int pitch; ///< floats a row
};

/// Hermite's weights of one cascade at one time: of (value, rate) before and after.
struct PointWeights {
    float value[4];
    float rate[4];
};

struct PointPlace {
    // Asked
    double x_m, y_m;             ///< in the world, finite
    const PointWeights* weights; ///< one a tile
    // Answered
    double shift_x_m, shift_y_m; ///< X - x
    double residual_m;
    bool solved; ///< the rest is set, and holds at x + shift
    float value[3];
    float d_dx[3];
    float d_dy[3];
    float rate[3]; ///< channels as in spline_channels.h
};

struct PointTask {
    const PointTile* tiles;
    int tile_count; ///< 1 to tiles_max
    double choppiness_x;
    double choppiness_y;
    double tolerance_m;
    double reach_m; ///< points that would move further are left
    bool rates;     ///< time rates are asked for
};

struct PointKernel {
    static constexpr int block = 8; ///< points at a time
    static constexpr int tiles_max = 16;

    void (*solve)(const PointTask& task, PointPlace* places, int count);
};

const PointKernel& point_kernel(Instructions instructions);

// One a translation unit that is compiled for them.
const PointKernel& point_kernel_portable();
const PointKernel& point_kernel_avx2();
const PointKernel& point_kernel_avx512();

} // namespace seaway::sea
