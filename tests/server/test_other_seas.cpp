// SPDX-License-Identifier: Apache-2.0
// Times at which another sea runs than now: what seaway-query says of them, and what a client knows.
#include <cmath>
#include <cstdio>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "base/child_process.h"
#include "tests/server/change_bench.h"

namespace seaway::changes {
namespace {

/// Four seas, one of which runs; those before were never told to whoever comes now.
constexpr const char* four_seas = R"([sea]
depth_m = 40.0
[[sea.system]]
type = "wind"
spectrum = "jonswap"
wind_speed_10m_mps = 8.0
fetch_m = 100000.0
from_deg = 250.0
[[cascade]]
length_m = 256.0
size = 64
[accuracy]
height_error_m = 0.05
[[weather]]
at_s = -300.0
over_s = 20.0
set.sea.system.0.wind_speed_10m_mps = 12.0
[[weather]]
at_s = -200.0
over_s = 20.0
set.sea.system.0.wind_speed_10m_mps = 6.0
[[weather]]
at_s = -100.0
over_s = 20.0
set.sea.system.0.wind_speed_10m_mps = 10.0
)";

class OtherSeas : public testing::Test {
  protected:
    tests::ServerProcess server{{tests::folder().write("four_seas.toml", four_seas), "--listen",
                                 "127.0.0.1:0", "--device", "native"}};
    std::string url;

    void SetUp() override {
        url = server.wait_until_ready();
        ASSERT_FALSE(url.empty()) << server.log();
    }
};

// Naive: a program that has connected a moment ago takes the sea of now for that of any time, and its waves have their bound there;
// or it asks for one other sea, and takes that for all between.
TEST_F(OtherSeas, who_asks_from_waves_is_answered_from_the_sea_of_each_time) {
    const std::string places =
        tests::folder().write("times.csv", "3,4,-350\n3,4,-250\n3,4,-150\n3,4,-50\n3,4,60\n5,6\n");
    const auto asked = [&](const std::string& how) {
        std::FILE* pipe =
            popen((SEAWAY_BIN_DIR "/seaway-query " + url + " --format json " + how).c_str(), "r");
        std::string text;
        char buffer[4096];
        for (std::size_t got; (got = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;)
            text.append(buffer, got);
        EXPECT_EQ(pclose(pipe), 0) << how;
        return nlohmann::json::parse(text, nullptr, false);
    };
    const nlohmann::json exact = asked("--exact --points " + places);
    ASSERT_EQ(exact.size(), 6u);
    for (const char* how : {"", "--from spectrum", "--from scene"}) {
        const nlohmann::json answers = asked("--points " + places + " --local " + how);
        ASSERT_EQ(answers.size(), exact.size()) << how;
        for (std::size_t i = 0; i + 1 < exact.size(); ++i) { // the last one is of another now
            EXPECT_LE(
                std::abs(answers[i]["height_m"].get<double>() - exact[i]["height_m"].get<double>()),
                answers[i]["error_m"].get<double>() + 1e-8)
                << how << ' ' << i;
            EXPECT_EQ(answers[i]["flags"], 0) << how << ' ' << i;
        }
    }
    const nlohmann::json below = asked("--at 3,4 --time -250 --z -1 --local --from scene");
    EXPECT_NEAR(below.at(0)["surface_m"].get<double>(), exact[1]["height_m"].get<double>(), 1e-5);
    EXPECT_EQ(below.at(0)["flags"], 0);
}

// Naive: from the first sea that it was ever told of, a client knows them all.
TEST_F(OtherSeas, what_ran_between_two_that_a_client_was_told_of_it_does_not_know) {
    const auto client = connect(url);
    ASSERT_TRUE(client);
    constexpr sea::TimeUs old_us = -350'000'000, between_us = -250'000'000;
    ASSERT_TRUE(client->hold({&old_us, 1}, 30));
    ASSERT_TRUE(client->rebuild(old_us));
    ASSERT_TRUE(client->rebuild(client->now_us()));
    const auto flags_at = [&](sea::TimeUs time_us) {
        const sea::QueryPoint point{3, 4, time_us};
        return client->sample({&point, 1}).value()[0].flags;
    };
    constexpr std::uint32_t unknown = sea::answer_extrapolated;
    EXPECT_EQ(flags_at(old_us), 0u) << "its keyframes say which sea it was";
    EXPECT_EQ(flags_at(between_us), unknown);
    EXPECT_EQ(flags_at(old_us - 100'000'000), unknown);
    EXPECT_EQ(flags_at(client->now_us()), 0u);
    EXPECT_FALSE(client->knows_sea_of(old_us));
    EXPECT_TRUE(client->knows_sea_of(client->now_us()));
    EXPECT_FALSE(client->knows_sea_of(client->now_us() + 60'000'000));
}

} // namespace
} // namespace seaway::changes
