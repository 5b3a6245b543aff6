// SPDX-License-Identifier: Apache-2.0
// A client that makes the sea of the server's scene, while that sea changes.
#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "client/client.h"
#include "client/link/failure.h"
#include "tests/server/change_bench.h"
#include "tests/support/eventually.h"

namespace seaway::changes {
namespace {

using client::Client;

bool makes(const Client& client, double at_s) {
    return client.source(sea::us_from_seconds(at_s)).source == client::AnswersFrom::parameters;
}

std::vector<sea::QueryPoint> points_at(std::initializer_list<double> times_s) {
    std::vector<sea::QueryPoint> points;
    for (const double at_s : times_s)
        for (int place = 0; place < 5; ++place)
            points.push_back({37.0 * place, -91.0 * place, sea::us_from_seconds(at_s)});
    return points;
}

/// Waves in double precision of a server that has the same.
constexpr double made_error_m = 1e-5;

// Naive: the scene that comes with a change is where it leads, so until it is there nothing is to be had; and of a sea whose
// depth has changed it does not tell the phases.
TEST(Changes, who_made_the_sea_of_its_scene_follows_by_itself_and_so_can_who_comes_on_the_way) {
    tests::ServerProcess server(arguments(tests::folder().file("scene_followed")));
    const std::string url = server.wait_until_ready();
    const auto client = connect(url);
    ASSERT_TRUE(client) << server.log();
    ASSERT_TRUE(client->rebuild(client->now_us()));
    const auto set = [&](const std::string& depth, const char* over) {
        const Said said =
            ctl(url, {"set", "systems.0.wind_speed_10m_mps=12", depth, "--over", over});
        EXPECT_EQ(said.code, 0) << said.words;
        return std::pair(number(said.words, "start_s"), number(said.words, "end_s"));
    };
    const auto [start_s, end_s] = set("sea.depth_m=25", "2m");
    ASSERT_TRUE(tests::eventually([&] { return makes(*client, start_s + 1); }));
    const auto points =
        points_at({start_s - 500, start_s - 0.001, start_s + 0.5, start_s + 20, end_s - 0.001});
    wait_until(*client, start_s + 3);
    expect_right(*client, points, made_error_m);

    const auto late = connect(url);
    ASSERT_TRUE(late);
    const Result<void> unknown = late->rebuild(late->now_us());
    ASSERT_FALSE(unknown);
    EXPECT_EQ(client::failure_of(unknown.error()), client::Failure::not_held);
    EXPECT_NE(unknown.error().message.find("hold a time before"), std::string::npos)
        << unknown.error().message;
    const sea::TimeUs before_us = sea::us_from_seconds(start_s) - 1;
    ASSERT_TRUE(late->hold({&before_us, 1}, 60));
    const Result<void> made = late->rebuild(late->now_us());
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_TRUE(makes(*late, start_s + 1));
    expect_right(*late, points, made_error_m);

    // One that takes over from it, back to where the depth was.
    const auto [again_s, over_s] = set("sea.depth_m=60", "10s");
    ASSERT_LT(again_s, end_s);
    const auto behind = points_at({again_s - 0.001, again_s + 0.5, again_s + 4, over_s - 0.001,
                                   over_s + 0.001, over_s + 1e5});
    wait_until(*client, over_s + 3); // two pings later
    for (const auto& one : {client.get(), late.get()}) {
        EXPECT_TRUE(makes(*one, again_s + 1) && makes(*one, over_s + 1));
        expect_right(*one, behind, made_error_m);
        EXPECT_TRUE(one->status().holds_waves);
    }
    // Of this sea its scene is not all, and the server's probes say so.
    const auto afterwards = connect(url);
    ASSERT_TRUE(afterwards);
    EXPECT_FALSE(afterwards->rebuild(afterwards->now_us()));
}

// Naive: who has been told of a change waits to be told of one, and makes the sea that it begins on meanwhile.
TEST(Changes, a_change_that_was_announced_before_the_sea_was_made_is_followed_too) {
    tests::ServerProcess server(arguments(tests::folder().file("announced_before")));
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    const Said said =
        ctl(url, {"set", "systems.0.wind_speed_10m_mps=12", "--over", "30s", "--at", "15"});
    ASSERT_EQ(said.code, 0) << said.words;
    const double start_s = number(said.words, "start_s");
    const auto client = connect(url);
    ASSERT_TRUE(client);
    ASSERT_TRUE(tests::eventually(
        [&] { return client->sea_state(sea::us_from_seconds(start_s + 1))->glide.has_value(); }));
    ASSERT_TRUE(client->rebuild(client->now_us()));
    EXPECT_TRUE(tests::eventually([&] { return makes(*client, start_s + 1); }));
}

// Naive: what is shown before a change, on its way and behind it comes of three seas. So it does, and none of them is seen to begin.
TEST(Changes, a_watch_of_the_scene_goes_through_one_without_tiles) {
    tests::ServerProcess server(arguments(tests::folder().file("scene_watched")));
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    // The watch is to be there before it begins.
    const Said said =
        ctl(url, {"set", "systems.0.wind_speed_10m_mps=14", "--over", "10s", "--at", "10"});
    ASSERT_EQ(said.code, 0) << said.words;
    const double start_s = number(said.words, "start_s"), end_s = number(said.words, "end_s");
    const tests::Output ran = tests::run_command(fmt::format(
        "timeout 60 {}/seaway-query {} --at 3,4 --local --from scene --watch 5 --format csv "
        "| awk -F, '{{print; fflush()}} $3 + 0 > {} {{exit}}'",
        SEAWAY_BIN_DIR, url, end_s + 2));
    EXPECT_EQ(ran.err, "");
    int on_the_way = 0, behind = 0;
    std::istringstream rows(ran.out);
    for (std::string row; std::getline(rows, row);) {
        std::vector<double> values;
        std::istringstream columns(row);
        for (std::string one; std::getline(columns, one, ',');)
            values.push_back(std::strtod(one.c_str(), nullptr));
        if (row.starts_with("x_m"))
            continue;
        ASSERT_EQ(values.size(), 12u) << row;
        if (!(static_cast<unsigned>(values[11]) & sea::answer_stale)) {
            EXPECT_LT(values[10], made_error_m) << "of waves: " << row;
        }
        on_the_way += values[2] > start_s && values[2] < end_s;
        behind += values[2] > end_s;
    }
    EXPECT_GE(on_the_way, 3) << "fifty, where nothing else runs";
    EXPECT_GE(behind, 1);
}

} // namespace
} // namespace seaway::changes
