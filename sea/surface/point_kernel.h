// SPDX-License-Identifier: Apache-2.0
// The inner loop of Surface::answer(): some scattered points at a time, several instruction sets.
//
// What a point costs is memory first: 4 x 4 coefficients of both keyframes of each cascade, some 60 lines of a
// cache. So the lines of all points of a block are asked for before the first is used, and cascades are taken one after
// the other, the first alone, then the second where the first has moved the point to, so that the patches of the fine ones
// are fetched about where they are needed. Patches are mixed in time once and kept while a point stays within its cell.
//
// Points of a block go on together: places, weights and steps of all of them are worked out at once, as vectors, and what is
// looked up for one does not wait for another. Two blocks go on in turns: while one is summed up, the other's lines come. Of who
// is warm, all cascades are looked up at once.
//
// Every lane does the same products and sums in the same order whatever the width of the vectors, and nothing is
// fused: all instruction sets give the same bits, a point alone the same as in a block. Single precision, about 1e-6 of
// what is summed; places in double. Solves where the surface is gentle, and says where it has not; nothing is allocated.
#pragma once

#include <cstddef>

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
    /// Values of both at the time of all points, spline_channel::mixed floats a texel; null: they are mixed as needed.
    const float* mixed = nullptr;
};

/// Hermite's weights of one cascade at one time: of (value, rate) before and after.
struct alignas(64) PointWeights {
    float value[4];
    float rate[4];
    float unused[8]; ///< a kernel loads all sixteen at once
};

/// Some points, what is alike of them side by side.
struct alignas(64) PointBlock {
    static constexpr int size = 8;
    static constexpr int tiles_max = 16;

    // Asked
    double x_m[size]; ///< in the world, finite
    double y_m[size];
    const PointWeights* weights[size]; ///< one a tile
    int count = 0;                     ///< of points; what is beyond has no meaning
    bool warm[size];                   ///< looked for at x + shift first, which is given
    // Answered; the shift is asked, too, of who is warm
    alignas(64) double shift_x_m[size]; ///< X - x
    alignas(64) double shift_y_m[size];
    alignas(64) double residual_m[size];
    bool solved[size]; ///< what follows is set, and holds at x + shift
    /// Channels as in spline_channels.h, beside one that has no meaning.
    alignas(64) float value[size][4];
    alignas(64) float d_dx[size][4];
    alignas(64) float d_dy[size][4];
    alignas(64) float rate[size][4];
    /// The place on each tile: its cell, and how far it is into it.
    alignas(32) int cell_x[tiles_max][size];
    alignas(32) int cell_y[tiles_max][size];
    alignas(32) float fraction_x[tiles_max][size];
    alignas(32) float fraction_y[tiles_max][size];
};

struct PointTask {
    const PointTile* tiles;
    int tile_count; ///< 1 to PointBlock::tiles_max
    double choppiness_x;
    double choppiness_y;
    double tolerance_m;
    double reach_m; ///< points that would move further are left
    bool rates;     ///< time rates are asked for
};

struct PointKernel {
    /// Of one block or two, which is faster than one after the other. 0074 has what it takes of a stack.
    void (*solve)(const PointTask& task, PointBlock& first, PointBlock* second);
    /// All of a tile at one time: PointTile::mixed.
    void (*mix)(const PointTile& tile, const PointWeights& weights, std::size_t texels, float* to);
};

const PointKernel& point_kernel(Instructions instructions);

// One a translation unit that is compiled for them.
const PointKernel& point_kernel_portable();
const PointKernel& point_kernel_avx2();
const PointKernel& point_kernel_avx512();

} // namespace seaway::sea
