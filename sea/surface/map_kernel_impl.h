// SPDX-License-Identifier: Apache-2.0
// map_kernel.h for W floats a vector. Included once per instruction set: all is of internal
// linkage, and nothing of the standard library is instantiated here.
#pragma once

#include <cstdint>
#include <utility>

#include "sea/surface/fold_suspicion.h"
#include "sea/surface/map_kernel.h"
#include "sea/surface/maps/spline_channels.h"
#include "sea/surface/maps/spline_weights.h"

namespace seaway::sea {
namespace {

#define SEAWAY_INLINE [[gnu::always_inline]] inline

typedef float F4 __attribute__((vector_size(16)));

template <int W>
struct Vector {
    typedef float F __attribute__((vector_size(W * 4)));
    typedef float Unaligned __attribute__((vector_size(W * 4), aligned(4), may_alias));
};

/// Lane i of part v: w[(v W + i) / 4]. Four texels side by side, four channels each.
template <int W, int v, int... i>
SEAWAY_INLINE typename Vector<W>::F spread(F4 w, std::integer_sequence<int, i...>) {
    return __builtin_shufflevector(w, w, ((v * W + i) / 4)...);
}

SEAWAY_INLINE F4 fold(F4 v) {
    return v;
}
template <class V, int... i>
SEAWAY_INLINE auto halves_sum(V v, std::integer_sequence<int, i...>) {
    constexpr int half = sizeof...(i);
    return __builtin_shufflevector(v, v, i...) + __builtin_shufflevector(v, v, (i + half)...);
}
SEAWAY_INLINE F4 fold(Vector<8>::F v) {
    return halves_sum(v, std::make_integer_sequence<int, 4>{});
}

struct Point {
    F4 value;
    F4 d_dx;
    F4 d_dy;
};

/// Weighted sums over the four rows of texels around a point, by W floats: parts [v].
template <int W, int... v>
SEAWAY_INLINE void add_tile(const MapTile& tile, double x_m, double y_m,
                            typename Vector<W>::F& value, typename Vector<W>::F& d_dx,
                            typename Vector<W>::F& d_dy, std::integer_sequence<int, v...>) {
    using F = typename Vector<W>::F;
    using Unaligned = typename Vector<W>::Unaligned;
    constexpr auto lanes = std::make_integer_sequence<int, W>{};
    const double ux = x_m * tile.texels_per_m + tile.base_x;
    const double uy = y_m * tile.texels_per_m + tile.base_y;
    // A map a million metres wide has more texels of a tile of centimetres than an int counts.
    const auto ix = static_cast<std::int64_t>(ux), iy = static_cast<std::int64_t>(uy);
    F4 wx, dx, wy, dy;
    spline_weights(static_cast<float>(ux - static_cast<double>(ix)), wx, dx);
    spline_weights(static_cast<float>(uy - static_cast<double>(iy)), wy, dy);
    const auto per_m = static_cast<float>(tile.texels_per_m);
    dx *= per_m;
    dy *= per_m;
    const std::int64_t mask = tile.size - 1;
    const std::size_t pitch = static_cast<std::size_t>(tile.pitch) * 4;
    const float* row = tile.texels + static_cast<std::size_t>(iy & mask) * pitch +
                       static_cast<std::size_t>(ix & mask) * 4;
    F column[sizeof...(v)] = {}, slope[sizeof...(v)] = {};
    for (int j = 0; j < 4; ++j, row += pitch)
        (..., [&] {
            const F texels = *reinterpret_cast<const Unaligned*>(row + v * W);
            column[v] += wy[j] * texels;
            slope[v] += dy[j] * texels;
        }());
    (..., [&] {
        const F weights = spread<W, v>(wx, lanes);
        value += column[v] * weights;
        d_dx += column[v] * spread<W, v>(dx, lanes);
        d_dy += slope[v] * weights;
    }());
}

template <int W>
SEAWAY_INLINE Point evaluate(const MapTile* tiles, int tile_count, double x_m, double y_m) {
    typename Vector<W>::F value{}, d_dx{}, d_dy{};
    for (int t = 0; t < tile_count; ++t)
        add_tile<W>(tiles[t], x_m, y_m, value, d_dx, d_dy,
                    std::make_integer_sequence<int, 16 / W>{});
    return {fold(value), fold(d_dx), fold(d_dy)};
}

using spline_channel::height, spline_channel::displacement_x, spline_channel::displacement_y;

constexpr int steps_max = 8;
constexpr auto careful_below = static_cast<float>(fold_suspected_below);

/// I + lambda grad D and the step that solves for the residual.
struct Newton {
    float a, b, c, d;
    float determinant;
    float step_x, step_y;

    SEAWAY_INLINE Newton(const MapRow& row, const Point& p, float residual_x, float residual_y)
        : a(1.0f + row.choppiness_x * p.d_dx[displacement_x]),
          b(row.choppiness_x * p.d_dy[displacement_x]),
          c(row.choppiness_y * p.d_dx[displacement_y]),
          d(1.0f + row.choppiness_y * p.d_dy[displacement_y]), determinant(a * d - b * c) {
        const float inverse = 1.0f / determinant;
        step_x = (b * residual_y - d * residual_x) * inverse;
        step_y = (c * residual_x - a * residual_y) * inverse;
    }
};

SEAWAY_INLINE void put_normal(const Newton& n, const Point& p, float* out) {
    const float x = n.c * p.d_dy[height] - n.d * p.d_dx[height];
    const float y = n.b * p.d_dx[height] - n.a * p.d_dy[height];
    const float scale = 1.0f / __builtin_sqrtf(x * x + y * y + n.determinant * n.determinant);
    out[0] = x * scale;
    out[1] = y * scale;
    out[2] = n.determinant * scale;
}

/// Solves X + lambda D(X) = x from the guess in shift_x, shift_y; false for the careful solver.
template <int W, MapKind kind>
SEAWAY_INLINE bool solve(const MapRow& row, int column) {
    const float last = kind == MapKind::normal ? row.last.normal_m : row.last.height_m;
    const double x_m = row.x0_m + column * row.step_m;
    float shift_x = row.shift_x[column], shift_y = row.shift_y[column];
    float residual_before = 1e30f;
    for (int step = 0; step < steps_max; ++step) {
        const Point p = evaluate<W>(row.tiles, row.tile_count, x_m - static_cast<double>(shift_x),
                                    row.y_m - static_cast<double>(shift_y));
        const float residual_x = row.choppiness_x * p.value[displacement_x] - shift_x;
        const float residual_y = row.choppiness_y * p.value[displacement_y] - shift_y;
        const float residual = residual_x * residual_x + residual_y * residual_y;
        const Newton n(row, p, residual_x, residual_y);
        // A full step that does not help is halved by the careful solver.
        if (!(n.determinant > careful_below && residual < residual_before))
            return false;
        residual_before = residual;
        shift_x -= n.step_x;
        shift_y -= n.step_y;
        if (n.step_x * n.step_x + n.step_y * n.step_y > last * last)
            continue;
        row.shift_x[column] = shift_x;
        row.shift_y[column] = shift_y;
        if constexpr (kind == MapKind::height)
            row.out[column] =
                p.value[height] + p.d_dx[height] * n.step_x + p.d_dy[height] * n.step_y;
        else
            put_normal(n, p, row.out + 3 * column);
        return true;
    }
    return false;
}

template <int W, MapKind kind>
int solve_row(const MapRow& row) {
    int unsolved = 0;
    for (int column = 0; column < row.columns; ++column)
        if (!solve<W, kind>(row, column))
            row.unsolved[unsolved++] = column;
    return unsolved;
}

template <int W>
int displacement_row(const MapRow& row) {
    for (int column = 0; column < row.columns; ++column) {
        const Point p =
            evaluate<W>(row.tiles, row.tile_count, row.x0_m + column * row.step_m, row.y_m);
        row.out[3 * column] = row.choppiness_x * p.value[displacement_x];
        row.out[3 * column + 1] = row.choppiness_y * p.value[displacement_y];
        row.out[3 * column + 2] = p.value[height];
    }
    return 0;
}

template <int W>
int map_row(const MapRow& row) {
    switch (row.kind) {
    case MapKind::height:
        return solve_row<W, MapKind::height>(row);
    case MapKind::normal:
        return solve_row<W, MapKind::normal>(row);
    case MapKind::displacement:
        return displacement_row<W>(row);
    }
    return 0;
}

template <int W>
const MapKernel& kernel_of() {
    static constexpr MapKernel kernel{map_row<W>};
    return kernel;
}

} // namespace
} // namespace seaway::sea
