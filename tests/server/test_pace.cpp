// SPDX-License-Identifier: Apache-2.0
// How fast the sea runs: real programs, a pause, a faster sea, restarts in both.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/server/change_bench.h"

namespace seaway::changes {
namespace {

using sea::TimeUs;

double now_s(client::Client& client) {
    return sea::seconds_from_us(client.now_us());
}

void sleep_s(double seconds) {
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

struct Look {
    std::chrono::steady_clock::time_point at;
    double sea_s;
};

/// At both clocks; again if another process had its turn in between.
Look look_at(client::Client& client) {
    for (int i = 0; i < 1000; ++i) {
        const auto at = std::chrono::steady_clock::now();
        const double sea_s = now_s(client);
        if (std::chrono::steady_clock::now() - at < std::chrono::milliseconds(2))
            return {at, sea_s};
    }
    ADD_FAILURE() << "no quiet moment";
    return {};
}

/// Sea seconds a second, over two of them.
double measured_pace(client::Client& client) {
    const Look before = look_at(client);
    sleep_s(2);
    const Look after = look_at(client);
    return (after.sea_s - before.sea_s) /
           std::chrono::duration<double>(after.at - before.at).count();
}

/// The pace holds after a second; clocks that have just met slew by half a per cent.
void expect_pace(client::Client& client, double pace) {
    double measured = measured_pace(client);
    // A busy machine tells it late.
    for (int i = 0; i < 2 && std::abs(measured - pace) > 0.02 + 0.02 * pace; ++i)
        measured = measured_pace(client);
    EXPECT_NEAR(measured, pace, 0.02 + 0.02 * pace);
}

/// To 10 ms, what is shown included, which comes near what is known as it is looked at.
bool knows_the_time(client::Client& client) {
    static_cast<void>(client.now_us());
    const auto clock = client.clock();
    return clock.error_us + std::abs(clock.slew_us) < 10'000;
}

// Naive: the server waits for its next keyframe in sea time, or publishes a quarter of a second of a sea ahead that runs ten
// times as fast: clients have nothing to sample.
TEST(
    Pace,
    of_a_sea_that_is_paused_slowed_down_and_hurried_is_that_of_every_client_and_samples_stay_right) {
    tests::ServerProcess server(arguments(tests::folder().file("pace")));
    const std::string url = server.wait_until_ready();
    const auto client = connect(url);
    ASSERT_TRUE(client) << server.log();
    ASSERT_TRUE(client->subscribe({.fields = sea::surface_fields}, 8, 60));
    for (const char* rate : {"0", "0.5", "8", "1"}) {
        const Said said = std::string(rate) == "0" ? ctl(url, {"pause"}) : ctl(url, {"rate", rate});
        ASSERT_EQ(said.code, 0) << said.words;
        sleep_s(2);
        const double pace = std::stod(rate);
        expect_pace(*client, pace);
        const auto late = connect(url), later = connect(url); // who comes later is told
        ASSERT_TRUE(late && later);
        // A clock that has just begun is off by up to half of its first trip.
        for (client::Client* one : {client.get(), late.get(), later.get()})
            EXPECT_TRUE(tests::eventually([&] { return knows_the_time(*one); })) << rate;
        double apart_s =
            1e9; // at some moment at which this thread was not kept from looking at all three
        for (int i = 0; i < 100; ++i) {
            const double before_s = now_s(*client), late_s = now_s(*late), later_s = now_s(*later),
                         after_s = now_s(*client);
            apart_s = std::min(apart_s, std::max(before_s - std::min(late_s, later_s),
                                                 std::max(late_s, later_s) - after_s));
        }
        // 50 ms of clocks, in which the sea goes on by as much times its pace, and as much of sea time.
        EXPECT_LE(apart_s, 0.05 * (1 + pace)) << rate;
        EXPECT_NE(ctl(url, {"state"}).words.find(fmt::format("\"pace\": {:.1f}", pace)),
                  std::string::npos);
        std::vector<sea::QueryPoint> points;
        std::vector<sea::Answer> sampled;
        // A second's; on a busy machine there are some between for which the keyframe has not come yet, and which say so.
        for (int tries = 0; tries < 1500 && points.size() < 50; ++tries, sleep_s(0.02)) {
            const sea::QueryPoint point{3.0 + tries, 4.0, client->now_us()};
            const auto answer = client->sample({&point, 1});
            ASSERT_TRUE(answer) << answer.error().message;
            if (answer->front().flags & sea::answer_extrapolated)
                continue;
            points.push_back(point);
            sampled.push_back(answer->front());
        }
        EXPECT_EQ(points.size(), 50u) << rate;
        const auto exact = client->ask(points, {.exact = true, .timeout_s = 60});
        ASSERT_TRUE(exact) << exact.error().message;
        for (std::size_t i = 0; i < points.size(); ++i)
            EXPECT_LE(std::abs(sampled[i].height_m - (*exact)[i].height_m),
                      sampled[i].error_m + (*exact)[i].error_m)
                << rate << ' ' << i;
    }
}

// Naive: the clock of a server that starts again is UTC less the epoch, whatever the sea did meanwhile.
TEST(Pace, outlives_the_process) {
    const std::string folder = tests::folder().file("paced");
    double paused_s = 0;
    {
        tests::ServerProcess server(arguments(folder));
        const std::string url = server.wait_until_ready();
        const Said said = ctl(url, {"pause"});
        ASSERT_EQ(said.code, 0) << said.words;
        paused_s = number(said.words, "from_s");
        server.send(SIGKILL); // before it holds
        EXPECT_TRUE(server.wait_for_exit(std::chrono::seconds(10)));
    }
    sleep_s(1.5);
    {
        tests::ServerProcess server(arguments(folder));
        const std::string url = server.wait_until_ready();
        const auto client = connect(url);
        ASSERT_TRUE(client) << server.log();
        EXPECT_DOUBLE_EQ(now_s(*client), paused_s);
        ASSERT_EQ(ctl(url, {"set", "systems.0.wind_speed_10m_mps=12", "--over", "10s"}).code, 0)
            << "it will begin when the sea goes on";
        ASSERT_EQ(ctl(url, {"rate", "4"}).code, 0);
        sleep_s(3);
        EXPECT_GT(now_s(*client), paused_s + 4);
        server.send(SIGKILL);
        EXPECT_TRUE(server.wait_for_exit(std::chrono::seconds(10)));
    }
    const auto gone = std::chrono::steady_clock::now();
    tests::ServerProcess server(arguments(folder));
    const auto client = connect(server.wait_until_ready());
    ASSERT_TRUE(client) << server.log();
    const double away_s =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - gone).count();
    EXPECT_GT(now_s(*client), paused_s + 4 + 4 * away_s);
    expect_pace(*client, 4);
}

TEST(Pace, is_refused_by_name_where_it_is_none) {
    tests::ServerProcess server(arguments(tests::folder().file("no_pace")));
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    for (const char* rate : {"-1", "11", "nan", "fast"}) {
        const Said said = ctl(url, {"rate", rate});
        EXPECT_EQ(said.code, 2) << said.words;
        EXPECT_NE(said.words.find("rate"), std::string::npos) << said.words;
    }
    // Each is told to every session: no more than a few that do not hold yet.
    int taken = 0;
    Said said{0, ""};
    while (said.code == 0 && taken < 200)
        taken += (said = ctl(url, {"rate", "2"})).code == 0;
    if (said.code != 0) { // else each took so long that those before held
        EXPECT_EQ(said.code, 6) << said.words;
        EXPECT_NE(said.words.find("do not hold yet"), std::string::npos) << said.words;
    }
    const Said stranger = ctl(url, {"pause"}, "");
    EXPECT_EQ(stranger.code, 6);
    EXPECT_NE(stranger.words.find("administrators"), std::string::npos) << stranger.words;
}

} // namespace
} // namespace seaway::changes
