// SPDX-License-Identifier: Apache-2.0
#include <numeric>

#include <gtest/gtest.h>

#include "base/quantile.h"

namespace seaway {
namespace {

double of(std::vector<double> values, double share) {
    return quantile(values, share);
}

TEST(Quantile, is_the_smallest_value_that_so_large_a_share_does_not_exceed) {
    std::vector<double> hundred(100);
    std::iota(hundred.rbegin(), hundred.rend(), 1.0);
    EXPECT_EQ(of(hundred, 0.99), 99);
    EXPECT_EQ(of(hundred, 0.07), 7) << "0.07 * 100 is a little more than 7";
    EXPECT_EQ(of(hundred, 0.5), 50);
    EXPECT_EQ(of(hundred, 0), 1);
    EXPECT_EQ(of(hundred, 1), 100);
}

// Naive: of two the 99th percentile is the faster one.
TEST(Quantile, of_few_the_99th_percentile_is_the_largest) {
    EXPECT_EQ(of({2, 1}, 0.99), 2);
    EXPECT_EQ(of({3, 1, 2}, 0.99), 3);
    EXPECT_EQ(of({3, 1, 2}, 0.5), 2);
    EXPECT_EQ(of({7}, 0.01), 7);
    EXPECT_EQ(of({}, 0.5), 0);
}

} // namespace
} // namespace seaway
