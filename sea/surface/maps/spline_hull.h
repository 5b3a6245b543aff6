// SPDX-License-Identifier: Apache-2.0
// Bounds of a cubic B-spline and its derivatives from its coefficients: the n-th derivative is a
// weighted mean of n-th differences, so it lies between the smallest and the largest of them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "sea/surface/maps/roughness.h"

namespace seaway::sea {

/// Smallest and largest of what was seen, channel by channel.
template <int channels>
struct Extent {
    float low[channels];
    float high[channels];
    Extent() {
        std::fill_n(low, channels, 3e38f);
        std::fill_n(high, channels, -3e38f);
    }
    void add(int c, float value) {
        low[c] = value < low[c] ? value : low[c];
        high[c] = value > high[c] ? value : high[c];
    }
    float size(int c) const { return std::max(std::abs(low[c]), std::abs(high[c])); }
    double range(int c) const { return static_cast<double>(high[c] - low[c]); }
};

/// Coefficients of a region, `channels` floats a grid point, and their differences up to `order`, 0
/// to 2.
template <int channels, int order>
struct SplineHull {
    Extent<channels> value, x, y, xx, xy, yy;

    /// The point `at` points to and its neighbours; `pitch` floats a row.
    void add(const float* at, std::size_t pitch) {
        const float* east = at + channels;
        const float* west = at - channels;
        const float* north = at + pitch;
        const float* south = at - pitch;
        const float* north_east = north + channels;
        for (int c = 0; c < channels; ++c) {
            value.add(c, at[c]);
            if constexpr (order >= 1) {
                x.add(c, east[c] - at[c]);
                y.add(c, north[c] - at[c]);
            }
            if constexpr (order == 2) {
                xx.add(c, east[c] - 2.0f * at[c] + west[c]);
                yy.add(c, north[c] - 2.0f * at[c] + south[c]);
                xy.add(c, north_east[c] - east[c] - north[c] + at[c]);
            }
        }
    }
    /// Of the displacement whose components are channels a (x) and b (y).
    Roughness roughness(int a, int b, double per_m) const {
        const auto square = [](float size) {
            return static_cast<double>(size) * static_cast<double>(size);
        };
        const double cross = std::max(y.range(a), x.range(b));
        const double half = 0.5 * (x.range(a) - y.range(b));
        // Frobenius norm of the third derivatives of a potential.
        const double bend =
            std::sqrt(square(xx.size(a)) + 2 * square(xy.size(a)) + square(yy.size(a)) +
                      square(xx.size(b)) + 2 * square(xy.size(b)) + square(yy.size(b)));
        return {std::hypot(value.range(a), value.range(b)),
                per_m * (0.5 * (x.range(a) + y.range(b)) + std::hypot(half, cross)),
                per_m * per_m * bend};
    }
    /// Of the height that is channel c.
    Rise rise(int c, double per_m) const {
        return {value.range(c),
                per_m * std::hypot(static_cast<double>(x.size(c)), static_cast<double>(y.size(c)))};
    }
};

} // namespace seaway::sea
