// SPDX-License-Identifier: Apache-2.0
// When two servers have the same sea, by their answers.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "client/apps/ctl_diff.h"
#include "client/exit_code.h"

namespace seaway::client {
namespace {

sea::Answer answer(double height_m, double error_m, std::uint32_t flags = 0) {
    sea::Answer answer{};
    answer.height_m = height_m;
    answer.error_m = error_m;
    answer.flags = flags;
    return answer;
}

TEST(CtlDiff, heights_within_the_sum_of_both_bounds_are_of_one_sea) {
    const std::vector<sea::Answer> one{answer(1, 0.25), answer(2, 0.25), answer(7, 0.25, 1)},
        other{answer(1.5, 0.25), answer(2, 0.25), answer(0, 0.25)};
    const Result<std::string> said = difference_of(one, other, 0.5);
    ASSERT_TRUE(said) << said.error().message;
    const auto json = nlohmann::json::parse(*said);
    EXPECT_EQ(json["points"], 2) << "a fold is not compared";
    EXPECT_EQ(json["beyond_bounds"], 0);
    EXPECT_EQ(json["most_m"], 0.5);
    EXPECT_EQ(json["clock_s"], 0.5);
}

TEST(CtlDiff, one_beyond_it_is_of_another_sea) {
    const std::vector<sea::Answer> one{answer(1, 0.25)}, other{answer(1.51, 0.25)};
    const Result<std::string> said = difference_of(one, other, 0);
    ASSERT_FALSE(said);
    EXPECT_NE(said.error().message.find("different seas"), std::string::npos);
    EXPECT_EQ(exit_code(said.error()), exit_refused);
    const std::vector<sea::Answer> none{answer(std::nan(""), 0.25)};
    EXPECT_FALSE(difference_of(one, none, 0)) << "what is no number is no height of either";
}

// Whoever scripts `diff` takes 0 for "the same sea".
TEST(CtlDiff, where_nothing_was_compared_that_is_no_agreement) {
    for (const auto flag : {sea::answer_folded, sea::answer_extrapolated, sea::answer_stale}) {
        const std::vector<sea::Answer> one{answer(1, 0.25, flag)}, other{answer(1, 0.25)};
        for (const Result<std::string>& said :
             {difference_of(one, other, 0), difference_of(other, one, 0)}) {
            ASSERT_FALSE(said) << flag;
            EXPECT_NE(said.error().message.find("nothing was compared: of 1 points"),
                      std::string::npos)
                << said.error().message;
            EXPECT_EQ(exit_code(said.error()), exit_refused);
        }
    }
    EXPECT_FALSE(difference_of({}, {}, 0));
}

} // namespace
} // namespace seaway::client
