// SPDX-License-Identifier: Apache-2.0
// Points in the order of their times: what stands at one time is made once for all of them. Pure; thread-safe.
#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <span>
#include <vector>

#include "sea/surface/answer.h"

namespace seaway::sea {

/// One past the last of the points from `first` on, one after the other, that are asked about at its time.
inline std::size_t same_time_end(std::span<const QueryPoint> points, std::size_t first) {
    std::size_t end = first + 1;
    while (end < points.size() && points[end].time_us == points[first].time_us)
        ++end;
    return end;
}

/// Which point comes when; those of one time stay as they are.
inline std::vector<std::size_t> order_by_time(std::span<const QueryPoint> points) {
    std::vector<std::size_t> order(points.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return points[a].time_us < points[b].time_us;
    });
    return order;
}

} // namespace seaway::sea
