// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <string>

#include <gmock/gmock.h>

#include "tests/tools/program.h"

namespace seaway {
namespace {

using ::testing::HasSubstr;
using testing::Output;

const std::string scene_text = R"(
[sea]
[[sea.system]]
type = "wind"
wind_speed_10m_mps = 12.0
from_deg = 200
fetch_m = 80e3
[[cascade]]
length_m = 401.0
size = 64
[[cascade]]
length_m = 61.0
size = 64
)";

TEST(Bench, compare_prints_one_line_that_two_devices_make_the_same_sea) {
    const std::string scene = testing::folder().write("compare.toml", scene_text);
    const Output ran = testing::run_program("seaway-bench", "compare --scene " + scene);
    ASSERT_EQ(ran.status, 0) << ran.err;
    EXPECT_EQ(std::count(ran.out.begin(), ran.out.end(), '\n'), 1) << ran.out;
    EXPECT_THAT(ran.out, HasSubstr("llvmpipe"));
    EXPECT_THAT(ran.out, HasSubstr("native ("));
    const std::string label = "largest difference of a map ";
    const std::size_t at = ran.out.find(label);
    ASSERT_NE(at, std::string::npos);
    const double difference = std::stod(ran.out.substr(at + label.size()));
    EXPECT_GT(difference, 0.0);  // two implementations: not the same bits
    EXPECT_LT(difference, 1e-5); // float transforms of 64: 1e-7, as tests of each device hold
}

TEST(Bench, compare_names_a_device_that_is_not_there) {
    const Output ran = testing::run_program("seaway-bench", "compare --first no-such-device");
    EXPECT_NE(ran.status, 0);
    EXPECT_EQ(ran.error_lines(), 1) << ran.err;
}

} // namespace
} // namespace seaway
