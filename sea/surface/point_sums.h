// SPDX-License-Identifier: Apache-2.0
// What the texels around a point say of it, for point_kernel_impl.h: weights of all points at once, and sums over cascades of
// which only the last one is brought together. Of internal linkage, as all of it is.
#pragma once

#include "sea/surface/maps/spline_weights.h"
#include "sea/surface/point_texels.h"

namespace seaway::sea {
namespace {

/// The spline's weights around all points of a block on one tile, and their derivatives by place, 1/m.
struct alignas(64) LaneWeights {
    float along_y[2][4][PointBlock::size]; ///< [weight, derivative][coefficient][point]
    float along_x[PointBlock::size][2][4]; ///< [point][weight, derivative][coefficient]
};

/// [i][j] and [j][i].
SEAWAY_INLINE void transpose(F8 (&m)[8]) {
    F8 two[8], four[8];
    for (int i = 0; i < 8; i += 2) {
        two[i] = __builtin_shufflevector(m[i], m[i + 1], 0, 8, 2, 10, 4, 12, 6, 14);
        two[i + 1] = __builtin_shufflevector(m[i], m[i + 1], 1, 9, 3, 11, 5, 13, 7, 15);
    }
    for (const int i : {0, 1, 4, 5}) {
        four[i] = __builtin_shufflevector(two[i], two[i + 2], 0, 1, 8, 9, 4, 5, 12, 13);
        four[i + 2] = __builtin_shufflevector(two[i], two[i + 2], 2, 3, 10, 11, 6, 7, 14, 15);
    }
    for (int i = 0; i < 4; ++i) {
        m[i] = __builtin_shufflevector(four[i], four[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
        m[i + 4] = __builtin_shufflevector(four[i], four[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
    }
}

SEAWAY_INLINE void weigh(const F8& fraction_x, const F8& fraction_y, float texels_per_m,
                         LaneWeights& weights) {
    F8 x[8];
    for (int i = 0; i < 4; ++i) {
        const auto piece = [i](int n) { return F8{} + spline_pieces[n][i]; };
        F8 y, dy;
        spline_weights(fraction_y, piece, y, dy);
        *reinterpret_cast<F8*>(weights.along_y[0][i]) = y;
        *reinterpret_cast<F8*>(weights.along_y[1][i]) = dy * texels_per_m;
        spline_weights(fraction_x, piece, x[i], x[4 + i]);
        x[4 + i] *= texels_per_m;
    }
    transpose(x);
    for (int p = 0; p < PointBlock::size; ++p)
        *reinterpret_cast<F8*>(weights.along_x[p]) = x[p];
}

/// The same of the first point alone.
SEAWAY_INLINE void weigh_first(float fraction_x, float fraction_y, float texels_per_m,
                               LaneWeights& weights) {
    F4 x, dx, y, dy;
    spline_weights(fraction_x, x, dx);
    spline_weights(fraction_y, y, dy);
    dx *= texels_per_m;
    dy *= texels_per_m;
    *reinterpret_cast<F8*>(weights.along_x[0]) =
        __builtin_shufflevector(x, dx, 0, 1, 2, 3, 4, 5, 6, 7);
    for (int i = 0; i < 4; ++i) {
        weights.along_y[0][i][0] = y[i];
        weights.along_y[1][i][0] = dy[i];
    }
}

SEAWAY_INLINE F4 halves_of(const F8& two) {
    return __builtin_shufflevector(two, two, 0, 1, 2, 3) +
           __builtin_shufflevector(two, two, 4, 5, 6, 7);
}

/// Four texels in a row, in vectors of W floats.
template <int W>
struct Row;
template <>
struct Row<16> {
    typedef F16 Part;
    typedef F16Unaligned Texels;
    Part part[1];

    /// Each of four weights as often as a texel has channels.
    SEAWAY_INLINE static Row spread(const F8& weights, int first) {
        const F16 twice = __builtin_shufflevector(weights, weights, 0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2,
                                                  3, 4, 5, 6, 7);
        if (first == 0)
            return {{__builtin_shufflevector(twice, twice, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3,
                                             3, 3)}};
        return {{__builtin_shufflevector(twice, twice, 4, 4, 4, 4, 5, 5, 5, 5, 6, 6, 6, 6, 7, 7, 7,
                                         7)}};
    }
    /// All four added up, as (0 + 2) + (1 + 3), by channel.
    SEAWAY_INLINE F4 together() const {
        return halves_of(__builtin_shufflevector(part[0], part[0], 0, 1, 2, 3, 4, 5, 6, 7) +
                         __builtin_shufflevector(part[0], part[0], 8, 9, 10, 11, 12, 13, 14, 15));
    }
};
template <>
struct Row<8> {
    typedef F8 Part;
    typedef F8Unaligned Texels;
    Part part[2];

    SEAWAY_INLINE static Row spread(const F8& w, int first) {
        if (first == 0)
            return {{__builtin_shufflevector(w, w, 0, 0, 0, 0, 1, 1, 1, 1),
                     __builtin_shufflevector(w, w, 2, 2, 2, 2, 3, 3, 3, 3)}};
        return {{__builtin_shufflevector(w, w, 4, 4, 4, 4, 5, 5, 5, 5),
                 __builtin_shufflevector(w, w, 6, 6, 6, 6, 7, 7, 7, 7)}};
    }
    SEAWAY_INLINE F4 together() const { return halves_of(part[0] + part[1]); }
};
template <>
struct Row<4> {
    typedef F4 Part;
    typedef F4Unaligned Texels;
    Part part[4];

    SEAWAY_INLINE static Row spread(const F8& w, int first) {
        Row all;
        for (int i = 0; i < 4; ++i)
            all.part[i] = F4{} + w[first + i];
        return all;
    }
    SEAWAY_INLINE F4 together() const { return (part[0] + part[2]) + (part[1] + part[3]); }
};

/// At one point, by texel of a row and channel.
template <int W>
struct Sums {
    Row<W> value{};
    Row<W> d_dx{};
    Row<W> d_dy{};
};

/// What 4 x 4 texels, `pitch` floats a row, say of the point p.
template <int W>
SEAWAY_INLINE void add(const LaneWeights& weights, int p, const float* texels, int pitch,
                       Sums<W>& sums) {
    typedef typename Row<W>::Part Part;
    const F8 x = *reinterpret_cast<const F8*>(weights.along_x[p]);
    const Row<W> wx = Row<W>::spread(x, 0), dx = Row<W>::spread(x, 4);
    const auto& wy = weights.along_y[0];
    const auto& dy = weights.along_y[1];
    for (int v = 0; v < 16 / W; ++v) {
        const auto row = [&](int j) -> Part {
            return *reinterpret_cast<const typename Row<W>::Texels*>(texels + j * pitch + W * v);
        };
        Part column = wy[0][p] * row(0), slope = dy[0][p] * row(0);
        for (int j = 1; j < 4; ++j) {
            column += wy[j][p] * row(j);
            slope += dy[j][p] * row(j);
        }
        sums.value.part[v] += column * wx.part[v];
        sums.d_dx.part[v] += column * dx.part[v];
        sums.d_dy.part[v] += slope * wx.part[v];
    }
}

} // namespace
} // namespace seaway::sea
