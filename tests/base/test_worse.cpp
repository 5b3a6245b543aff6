// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include <gtest/gtest.h>

#include "base/worse.h"

namespace seaway {
namespace {

TEST(Worse, of_two_errors_is_the_larger_one_and_no_bound_holds_what_is_no_number) {
    EXPECT_EQ(worse(1, 2), 2);
    EXPECT_EQ(worse(2, 1), 2);
    const double nothing = std::nan("");
    for (const double worst : {worse(1, nothing), worse(nothing, 1), worse(worse(1, nothing), 2)})
        EXPECT_EQ(worst, HUGE_VAL);
}

} // namespace
} // namespace seaway
