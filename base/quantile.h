// SPDX-License-Identifier: Apache-2.0
// Percentiles of what was measured, by nearest rank: the smallest value that at least so large a share of all does not exceed. Of
// few values the 99th is the largest, not one between.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace seaway {

/// `share` 0 .. 1. The values are put into another order. Of none: 0.
template <class Value>
Value quantile(std::vector<Value>& values, double share) {
    if (values.empty())
        return Value{};
    // A little less, so that 0.07 of 100 is the seventh, whatever 0.07 * 100 is rounded to.
    const double rank = std::ceil(share * static_cast<double>(values.size()) * (1 - 1e-12));
    const auto place = values.begin() + static_cast<std::ptrdiff_t>(std::max(rank, 1.0)) - 1;
    std::nth_element(values.begin(), place, values.end());
    return *place;
}

/// Of none: 0. Of two the smaller.
template <class Value>
Value median(std::vector<Value> values) {
    return quantile(values, 0.5);
}

} // namespace seaway
