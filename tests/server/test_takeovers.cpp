// SPDX-License-Identifier: Apache-2.0
// Changes that take over from others before these have ended, and from timetables.
#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/elapsed.h"
#include "server/simulation/sea_course.h"
#include "tests/server/change_bench.h"

namespace seaway::changes {
namespace {

using server::takeovers_max;

// Naive: a sea that glides is a mixture of all that it glided from, without end, each to be made when a client asks about it.
TEST(Changes, that_take_over_from_one_another_are_refused_where_too_many_hang_together) {
    tests::ServerProcess server(arguments(tests::folder().file("row")));
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    const auto set = [&](int at_s) {
        return ctl(url, {"set", fmt::format("systems.0.from_deg={}", at_s % 360), "--over", "600s",
                         "--at", std::to_string(at_s)});
    };
    for (int i = 0; i <= takeovers_max; ++i) {
        const Said said = set(1000 + 10 * i);
        ASSERT_EQ(said.code, 0) << i << said.words;
    }
    const Said said = set(1000 + 10 * takeovers_max + 10);
    EXPECT_EQ(said.code, 6) << said.words;
    EXPECT_NE(said.words.find("in a row have taken over"), std::string::npos) << said.words;
    EXPECT_EQ(set(5000).code, 0) << "they have ended by then";
}

// A forecast that comes anew says another sea for the same time.
TEST(Changes, that_are_planned_are_corrected_as_often_as_one_likes) {
    tests::ServerProcess server(arguments(tests::folder().file("plan")));
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    for (int i = 0; i < takeovers_max + 4; ++i) {
        const Said said = ctl(url, {"set", fmt::format("systems.0.from_deg={}", 10 * i), "--over",
                                    "600s", "--at", "5000"});
        ASSERT_EQ(said.code, 0) << i << said.words;
        EXPECT_GE(number(said.words, "start_s"), 5000);
    }
}

// Naive: who comes then has the waves of some of them, with which no height can be made, until all have ended.
TEST(Changes, who_joins_behind_as_many_takeovers_as_there_may_be_has_the_waves) {
    tests::ServerProcess server(arguments(tests::folder().file("behind")));
    const std::string url = server.wait_until_ready();
    const auto client = connect(url);
    ASSERT_TRUE(client) << server.log();
    // Later than what counts as promised, also where each request takes a second, as on a busy machine.
    const auto start = std::chrono::steady_clock::now();
    EXPECT_EQ(ctl(url, {"status"}).code, 0);
    const double asking_s = 2 * (takeovers_max + 1) * seconds_since(start);
    const double first_s = std::floor(sea::seconds_from_us(client->now_us()) + asking_s) + 14;
    double last_s = 0;
    for (int i = 0; i <= takeovers_max; ++i) {
        const Said said = ctl(url, {"set", fmt::format("systems.0.from_deg={}", 20 * i), "--over",
                                    "600s", "--at", fmt::format("{}", first_s + 0.5 * i)});
        ASSERT_EQ(said.code, 0) << i << said.words;
        last_s = number(said.words, "start_s");
    }
    wait_until(*client, last_s + 1);
    const auto late = connect(url);
    ASSERT_TRUE(late);
    const auto granted = late->subscribe_spectrum({}, 60);
    ASSERT_TRUE(granted) << granted.error().message;
    EXPECT_EQ(granted->spectra, takeovers_max + 2u) << "of each, and of the sea that they left";
    EXPECT_TRUE(late->status().holds_waves);
    std::vector<sea::QueryPoint> points;
    for (const double at_s : {last_s + 0.001, last_s + 3, last_s + 100, last_s + 599})
        for (int place = 0; place < 5; ++place)
            points.push_back({37.0 * place, -91.0 * place, sea::us_from_seconds(at_s)});
    expect_right(*late, points, 0.03);
}

// Naive: to the scene as its timetable has it by now, of which rows have begun by the time that was asked for.
TEST(Changes, the_way_back_at_a_time_is_to_where_the_timetable_is_by_then) {
    const std::string scene =
        small_sea_text() + "[[weather]]\nat_s = 200\nover_s = 20\nset.systems.0.from_deg = 300\n"
                           "[[weather]]\nat_s = 900\nover_s = 20\nset.systems.0.from_deg = 310\n";
    std::vector<std::string> all = natively("led_to.toml", scene);
    all.insert(all.end(),
               {"--data-dir", tests::folder().file("led_to"), "--admin-token-file", token_file()});
    tests::ServerProcess server(all);
    const std::string url = server.wait_until_ready();
    const auto client = connect(url);
    ASSERT_TRUE(client) << server.log();
    ASSERT_EQ(ctl(url, {"set", "systems.0.from_deg=20"}).code, 0);
    const Said back = ctl(url, {"rewind", "1", "--over", "10s", "--at", "300"});
    ASSERT_EQ(back.code, 0) << back.words;
    const auto from_deg = [&](double at_s) {
        const sea::QueryPoint point{0, 0, sea::us_from_seconds(at_s)};
        EXPECT_TRUE(client->fetch_and_sample({&point, 1}, 20));
        const std::string& told = client->sea_state(point.time_us)->scene;
        return told.substr(told.find("from_deg = "), 14);
    };
    EXPECT_EQ(from_deg(500), "from_deg = 300");
    EXPECT_EQ(from_deg(1000), "from_deg = 310") << "rows to come follow at their own times";
    EXPECT_NE(ctl(url, {"rewind", "1", "--over", "10s", "--at", "895"}).code, 0)
        << "one that begins before the glide ends";
}

} // namespace
} // namespace seaway::changes
