// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <span>

#include <gtest/gtest.h>

#include "base/worse.h"

namespace seaway::tests {

/// Of two arrays of one length, value by value; infinite where one of them holds no number.
inline double largest_difference(std::span<const float> a, std::span<const float> b) {
    EXPECT_EQ(a.size(), b.size());
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        largest = worse(largest, std::abs(double{a[i]} - double{b[i]}));
    return largest;
}

} // namespace seaway::tests
