// SPDX-License-Identifier: Apache-2.0
// SplineHull (sea/surface/maps/spline_hull.h) of the part of a patch that the splines in a box are made
// of, four floats at a time: a search works bounds out again and again.
#pragma once

#include <algorithm>
#include <cstring>

#include "sea/surface/maps/spline_hull.h"
#include "sea/surface/sheets.h"
#include "sea/waves/sheet_patch.h"

namespace seaway::sea {

/// Extent of four channels side by side.
class Extent4 {
  public:
    typedef float F4 __attribute__((vector_size(16)));

    void add(F4 value) {
        low_ = value < low_ ? value : low_;
        high_ = value > high_ ? value : high_;
    }
    /// Lanes that are `channels` apart are of one channel.
    template <int channels>
    void into(Extent<channels>& extent) const {
        for (int lane = 0; lane < 4; ++lane) {
            extent.add(lane % channels, low_[lane]);
            extent.add(lane % channels, high_[lane]);
        }
    }

  private:
    F4 low_ = F4{} + 3e38f;
    F4 high_ = F4{} - 3e38f;
};

/// The same as SplineHull, of rows of coefficients.
template <int channels, int order>
class RowsHull {
    using F4 = Extent4::F4;
    static constexpr int points = 4 / channels; ///< at a time

  public:
    /// `count` points and their neighbours, at least one. A few points more may be looked at: what
    /// follows must exist, and only widens bounds.
    void add(const float* at, std::size_t pitch, int count) {
        for (int i = 0; i < count; i += points) {
            const int off = channels * std::min(i, std::max(count - points, 0));
            const auto part = [&](std::ptrdiff_t by) {
                F4 four;
                std::memcpy(&four, at + off + by, sizeof four);
                return four;
            };
            const auto row = static_cast<std::ptrdiff_t>(pitch);
            const F4 here = part(0);
            value_.add(here);
            if constexpr (order >= 1) {
                const F4 east = part(channels) - here, north = part(row) - here;
                x_.add(east);
                y_.add(north);
                if constexpr (order == 2) {
                    xx_.add(east - here + part(-channels));
                    yy_.add(north - here + part(-row));
                    xy_.add(part(row + channels) - part(row) - east);
                }
            }
        }
    }
    SplineHull<channels, order> hull() const {
        SplineHull<channels, order> all;
        value_.into(all.value);
        if constexpr (order >= 1) {
            x_.into(all.x);
            y_.into(all.y);
        }
        if constexpr (order == 2) {
            xx_.into(all.xx);
            xy_.into(all.xy);
            yy_.into(all.yy);
        }
        return all;
    }

  private:
    Extent4 value_, x_, y_, xx_, xy_, yy_;
};

/// Of coefficients laid out as `patch` says, `channels` each.
template <int channels, int order>
SplineHull<channels, order> hull_of(const SheetPatch& patch,
                                    const RecycledVector<float>& coefficients, const Box& box) {
    const PatchLines::Range x = patch.x.range(box.low.x, box.high.x, patch.spacing_m);
    const PatchLines::Range y = patch.y.range(box.low.y, box.high.y, patch.spacing_m);
    const std::size_t pitch = channels * static_cast<std::size_t>(patch.x.count);
    RowsHull<channels, order> hull;
    for (long j = y.begin; j < y.end; ++j)
        for (long i = x.begin; i < x.end;) {
            const int column = patch.x.turned(i);
            // Up to where the lines come round.
            const long round = patch.x.round() ? patch.x.period + 1 - column : x.end - i;
            const long count = std::min(x.end - i, round);
            hull.add(coefficients.data() + channels * patch.at(column, patch.y.turned(j)), pitch,
                     static_cast<int>(count));
            i += count;
        }
    return hull.hull();
}

} // namespace seaway::sea
