// SPDX-License-Identifier: Apache-2.0
// The texels around a point, for point_kernel_impl.h: how they are fetched and mixed in time. Of internal linkage, as all
// of it is.
#pragma once

#include "sea/surface/maps/spline_channels.h"
#include "sea/surface/point_kernel.h"

#define SEAWAY_INLINE [[gnu::always_inline]] inline

namespace seaway::sea {
namespace {

typedef float F4 __attribute__((vector_size(16)));
typedef float F8 __attribute__((vector_size(32)));
typedef float F16 __attribute__((vector_size(64)));
typedef float F4Unaligned __attribute__((vector_size(16), aligned(4), may_alias));
typedef float F8Unaligned __attribute__((vector_size(32), aligned(4), may_alias));
typedef float F16Unaligned __attribute__((vector_size(64), aligned(4), may_alias));

constexpr int channels = spline_channel::count;

/// One cascade around one point, mixed at its time.
struct alignas(64) Patch {
    static constexpr int pitch = 16;
    float texels[16][4];
};

/// Floats of a mixed map for each of a keyframe's.
constexpr int mixed_share = channels / spline_channel::mixed;
static_assert(spline_channel::mixed == 4 && mixed_share == 2);

SEAWAY_INLINE void fetch_mixed(const PointTile& tile, int first) {
    const float* row = tile.mixed + first / mixed_share;
    for (int j = 0; j < 4; ++j, row += tile.pitch / mixed_share) {
        __builtin_prefetch(row);
        __builtin_prefetch(row + 4 * spline_channel::mixed - 1);
    }
}

SEAWAY_INLINE void fetch(const PointTile& tile, int first) {
    for (const float* map : {tile.before, tile.after})
        for (int j = 0; j < 4; ++j) {
            const float* row = map + first + j * tile.pitch;
            __builtin_prefetch(row);
            __builtin_prefetch(row + 2 * channels);
            __builtin_prefetch(row + 4 * channels - 1);
        }
}

/// (before's value + after's value) + (before's rate + after's rate), each times its weight, of which the four from
/// `vb` on are taken.
template <int W, int vb>
SEAWAY_INLINE F4 mixed(const float* before, const float* after, const F8& w) {
    constexpr int rb = vb + 1, va = vb + 2, ra = vb + 3;
    if constexpr (W >= 8) {
        const F8 wb = __builtin_shufflevector(w, w, vb, vb, vb, vb, rb, rb, rb, rb);
        const F8 wa = __builtin_shufflevector(w, w, va, va, va, va, ra, ra, ra, ra);
        const F8 both = wb * *reinterpret_cast<const F8Unaligned*>(before) +
                        wa * *reinterpret_cast<const F8Unaligned*>(after);
        return __builtin_shufflevector(both, both, 0, 1, 2, 3) +
               __builtin_shufflevector(both, both, 4, 5, 6, 7);
    } else {
        const auto part = [](const float* at) {
            return static_cast<F4>(*reinterpret_cast<const F4Unaligned*>(at));
        };
        return (w[vb] * part(before) + w[va] * part(after)) +
               (w[rb] * part(before + 4) + w[ra] * part(after + 4));
    }
}

/// Weights of two texels before and two after, of which the four from `vb` on are taken.
struct RowWeights {
    F16 before;
    F16 after;
};
template <int vb>
SEAWAY_INLINE RowWeights row_weights(const PointWeights& weights) {
    constexpr int rb = vb + 1, va = vb + 2, ra = vb + 3;
    const F16 w = *reinterpret_cast<const F16*>(weights.value);
    return {__builtin_shufflevector(w, w, vb, vb, vb, vb, rb, rb, rb, rb, vb, vb, vb, vb, rb, rb,
                                    rb, rb),
            __builtin_shufflevector(w, w, va, va, va, va, ra, ra, ra, ra, va, va, va, va, ra, ra,
                                    ra, ra)};
}

/// The same of four texels in a row.
SEAWAY_INLINE F16 mixed_row(const float* before, const float* after, const RowWeights& w) {
    const auto two = [&](int i) {
        return w.before * *reinterpret_cast<const F16Unaligned*>(before + i) +
               w.after * *reinterpret_cast<const F16Unaligned*>(after + i);
    };
    const F16 west = two(0), east = two(2 * channels);
    return __builtin_shufflevector(west, east, 0, 1, 2, 3, 8, 9, 10, 11, 16, 17, 18, 19, 24, 25, 26,
                                   27) +
           __builtin_shufflevector(west, east, 4, 5, 6, 7, 12, 13, 14, 15, 20, 21, 22, 23, 28, 29,
                                   30, 31);
}

/// The patch's values at the time of the weights, or their time rates.
template <int W, bool rates = false>
SEAWAY_INLINE void mix(const PointTile& tile, const PointWeights& weights, int first,
                       Patch& patch) {
    constexpr int vb = rates ? 4 : 0;
    const float* before = tile.before + first;
    const float* after = tile.after + first;
    if constexpr (W == 16) {
        const RowWeights w = row_weights<vb>(weights);
        for (int j = 0; j < 4; ++j, before += tile.pitch, after += tile.pitch)
            *reinterpret_cast<F16*>(patch.texels[4 * j]) = mixed_row(before, after, w);
    } else {
        const F8 w = *reinterpret_cast<const F8*>(weights.value);
        for (int j = 0; j < 4; ++j, before += tile.pitch, after += tile.pitch)
            for (int i = 0; i < 4; ++i)
                *reinterpret_cast<F4*>(patch.texels[4 * j + i]) =
                    mixed<W, vb>(before + i * channels, after + i * channels, w);
    }
}

/// PointKernel::mix.
template <int W>
void mix_all(const PointTile& tile, const PointWeights& weights, std::size_t texels, float* to) {
    std::size_t i = 0;
    if constexpr (W == 16)
        for (const RowWeights w = row_weights<0>(weights); i + 4 <= texels; i += 4)
            *reinterpret_cast<F16Unaligned*>(to + spline_channel::mixed * i) =
                mixed_row(tile.before + channels * i, tile.after + channels * i, w);
    const F8 w = *reinterpret_cast<const F8*>(weights.value);
    for (; i < texels; ++i)
        *reinterpret_cast<F4Unaligned*>(to + spline_channel::mixed * i) =
            mixed<W, 0>(tile.before + channels * i, tile.after + channels * i, w);
}

} // namespace
} // namespace seaway::sea
