// SPDX-License-Identifier: Apache-2.0
// What a client that was sent the waves of a folded sea says of sheets that rounding may have moved.
#include <cmath>

#include <gtest/gtest.h>

#include "tests/server/change_bench.h"

namespace seaway::changes {
namespace {

constexpr const char* shallows = R"([sea]
seed = 97
depth_m = 0.5
choppiness = [0.8, 0.3]
[[sea.system]]
type = "wind"
wind_speed_10m_mps = 12
from_deg = 74
fetch_m = 50e3
[[sea.system]]
type = "swell"
significant_height_m = 0.90
peak_period_s = 6.88
from_deg = 191
[[cascade]]
length_m = 400
size = 64
[[cascade]]
length_m = 60
size = 64
[accuracy]
height_error_m = 0.03
)";

// Naive: Newton decides which sheets there are, of a sum that is itself off by centimetres: where a sheet is about to appear the wrong
// one was answered, 0.4 m off with a bound of 5 cm and no flag. Two of the points are such places.
TEST(FoldedSpectrum, says_where_rounding_may_hide_a_sheet) {
    tests::ServerProcess server(natively("shallows.toml", shallows));
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    const auto client = connect(url);
    ASSERT_TRUE(client);
    ASSERT_TRUE(client->subscribe_spectrum({}, 60));
    std::vector<sea::QueryPoint> points{{-1476.9719514414428, -813.6118927477255, 51'925'172},
                                        {-82.33688786804487, -2587.934698777387, 54'096'204}};
    for (int i = 0; i < 400; ++i)
        points.push_back({37.1 * i - 7000, 3000 - 23.7 * i, 51'925'172});
    const Result<std::vector<sea::Answer>> own = client->sample(points);
    const Result<std::vector<sea::Answer>> exact = client->ask(points, {true, 60, {}});
    ASSERT_TRUE(own && exact);
    int open = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const sea::Answer &a = (*own)[i], &b = (*exact)[i];
        open += (a.flags & sea::answer_open) != 0;
        if (!(a.flags & sea::answer_open)) {
            EXPECT_LE(std::abs(a.height_m - b.height_m), a.error_m + b.error_m) << i;
        }
    }
    for (std::size_t i = 0; i < 2; ++i)
        EXPECT_TRUE((*own)[i].flags & sea::answer_open) << i;
    EXPECT_LE(open, 20) << "and hardly anywhere else";
}

} // namespace
} // namespace seaway::changes
