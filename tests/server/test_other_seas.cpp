// SPDX-License-Identifier: Apache-2.0
// Times at which another sea runs than now: what seaway-query says of them, and what a client knows.
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>
#include <thread>

#include <signal.h>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "base/child_process.h"
#include "tests/server/change_bench.h"
#include "tests/support/eventually.h"
#include "tests/support/fault_proxy.h"
#include "tests/support/program.h"

namespace seaway::changes {
namespace {

/// Four seas, one of which runs; those before were never told to whoever comes now. And a tide, far ahead.
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
[[weather]]
at_s = 1000.0
over_s = 600.0
set.sea.depth_m = 8.0
)";

/// What seaway-query says, which must end well.
nlohmann::json answers_of(const std::string& url, const std::string& how) {
    const tests::Output ran = tests::run_program("seaway-query", url + " --format json " + how);
    EXPECT_EQ(ran.status, 0) << how << ran.err;
    return nlohmann::json::parse(ran.out, nullptr, false);
}

class OtherSeas : public testing::Test {
  protected:
    tests::ServerProcess server{natively("four_seas.toml", four_seas)};
    std::string url;

    void SetUp() override {
        url = server.wait_until_ready();
        ASSERT_FALSE(url.empty()) << server.log();
    }

    nlohmann::json answers(const std::string& how) const { return answers_of(url, how); }
};

// Naive: of two times between the same keyframes the later one is asked about, as the sea that runs then has run before. It has begun
// in between, and what is held of the earlier time is of a sea that did not run.
TEST_F(OtherSeas, a_change_between_keyframes_parts_the_times_around_it) {
    std::string seas = four_seas;
    seas.replace(seas.find("-200.0"), 6, "-200.37"); // its glide ends as far from any keyframe
    tests::ServerProcess other{natively("parted_seas.toml", seas)};
    const std::string there = other.wait_until_ready();
    ASSERT_FALSE(there.empty()) << other.log();
    for (const double change_s : {-200.37, -180.37}) {
        const sea::TimeUs change_us = sea::us_from_seconds(change_s);
        const sea::QueryPoint points[] = {{3, 4, change_us - 7000}, {3, 4, change_us + 7000}};
        const sea::TimeUs times_us[] = {points[0].time_us, points[1].time_us};
        const auto sampling = connect(there), holding = connect(there);
        ASSERT_TRUE(sampling && holding);
        const auto exact = sampling->ask(points, {.exact = true, .timeout_s = 60});
        ASSERT_TRUE(exact) << exact.error().message;
        const auto sampled = sampling->fetch_and_sample(points, 60);
        ASSERT_TRUE(sampled) << change_s << sampled.error().message;
        ASSERT_TRUE(holding->hold(times_us, 60));
        const auto held = holding->sample(points);
        ASSERT_TRUE(held) << held.error().message;
        for (const auto* answers : {&*sampled, &*held})
            for (std::size_t i = 0; i < 2; ++i) {
                EXPECT_EQ((*answers)[i].flags, 0u) << change_s << " " << i;
                EXPECT_LE(std::abs((*answers)[i].height_m - (*exact)[i].height_m),
                          (*answers)[i].error_m + (*exact)[i].error_m);
            }
    }
}

// Naive: a program that has connected a moment ago takes the sea of now for that of any time, and its waves have their bound there;
// or it asks for one other sea, and takes that for all between. Or displacements follow from heights in the sea of now, and are
// left out of one in which they do not.
TEST_F(OtherSeas, who_asks_from_waves_is_answered_from_the_sea_of_each_time) {
    const std::string places = tests::folder().write(
        "times.csv",
        "3,4,-350\n3,4,-250\n3,4,-150\n3,4,-50\n3,4,-80.01\n3,4,-79.99\n3,4,60\n3,4,1300\n5,6\n");
    const nlohmann::json exact = answers("--exact --points " + places);
    ASSERT_EQ(exact.size(), 9u);
    for (const char* how : {"", "--from spectrum", "--from scene"}) {
        const nlohmann::json here = answers("--points " + places + " --local " + how);
        ASSERT_EQ(here.size(), exact.size()) << how;
        for (std::size_t i = 0; i + 1 < exact.size(); ++i) { // the last one is of another now
            EXPECT_LE(
                std::abs(here[i]["height_m"].get<double>() - exact[i]["height_m"].get<double>()),
                here[i]["error_m"].get<double>() + 1e-8)
                << how << ' ' << i;
            EXPECT_EQ(here[i]["flags"], 0) << how << ' ' << i;
        }
    }
    const nlohmann::json below = answers("--at 3,4 --time -250 --z -1 --local --from scene");
    EXPECT_NEAR(below.at(0)["surface_m"].get<double>(), exact[1]["height_m"].get<double>(), 1e-5);
    EXPECT_EQ(below.at(0)["flags"], 0);
}

// Naive: keyframes on both sides are of one sea, so that sea ran between them. The last ones of a sea reach beyond its end.
TEST_F(OtherSeas, keyframes_of_a_sea_behind_its_end_do_not_prove_it) {
    const auto client = connect(url);
    ASSERT_TRUE(client);
    constexpr sea::TimeUs end_us = -300'000'000, within_us = end_us - 1000;
    ASSERT_TRUE(client->hold({&within_us, 1}, 30));
    ASSERT_TRUE(client->rebuild(within_us));
    const auto answer_at = [&](sea::TimeUs time_us) {
        const sea::QueryPoint point{3, 4, time_us};
        return client->sample({&point, 1}).value()[0];
    };
    const sea::TimeUs behind_us = end_us + 500'000;
    EXPECT_EQ(answer_at(within_us).flags, 0u);
    EXPECT_EQ(answer_at(behind_us).flags & sea::answer_extrapolated, sea::answer_extrapolated);
    const std::uint32_t first = client->sea_state(behind_us)->epoch;
    ASSERT_TRUE(client->hold({&behind_us, 1}, 30));
    EXPECT_NE(client->sea_state(behind_us)->epoch, first) << "the server was asked";
    EXPECT_EQ(answer_at(behind_us).flags & sea::answer_extrapolated, 0u);
}

// Naive: one row in a change, whose scene is where it leads, and none is answered; or more times than a client holds keyframes of.
TEST_F(OtherSeas, rows_in_a_change_and_of_many_times_are_answered_from_waves) {
    const auto asked = [&](const std::string& how, const std::string& places) {
        return answers("--points " + tests::folder().write("rows.csv", places) + ' ' + how);
    };
    const nlohmann::json mixed = asked("--local --from scene", "5,6\n3,4,-290\n3,4,-350\n");
    const nlohmann::json exact = asked("--exact", "3,4,-290\n3,4,-350\n");
    ASSERT_EQ(mixed.size(), 3u);
    for (std::size_t i = 0; i < 2; ++i)
        EXPECT_LE(
            std::abs(mixed[i + 1]["height_m"].get<double>() - exact[i]["height_m"].get<double>()),
            mixed[i + 1]["error_m"].get<double>());
    std::string many;
    for (int i = 0; i < 60; ++i)
        many += fmt::format("3,4,{}\n", -700 + 5 * i);
    const nlohmann::json below = asked("--local --from scene --z -1", many);
    EXPECT_EQ(below.size(), 60u);
    for (const nlohmann::json& row : below)
        EXPECT_EQ(row["flags"], 0);
}

// Naive: whoever watches a time that was given asks the server about it at every beat, and has nothing to say once that is gone.
TEST_F(OtherSeas, who_watches_a_given_time_from_waves_goes_on_without_its_server) {
    std::FILE* pipe = popen(("timeout 120 " SEAWAY_BIN_DIR "/seaway-query " + url +
                             " --at 3,4 --time 500 --local --from scene --watch 10 --format json "
                             "| awk '{print; fflush()} /\"flags\": ?128/ {exit}'")
                                .c_str(),
                            "r");
    std::string last;
    char line[1024];
    for (int rows = 0; std::fgets(line, sizeof line, pipe) != nullptr; last = line)
        if (++rows == 3)
            kill(server.pid(), SIGKILL);
    pclose(pipe);
    const nlohmann::json row = nlohmann::json::parse(last, nullptr, false);
    EXPECT_EQ(row.is_array() ? row.at(0)["flags"] : row["flags"], unsigned{sea::answer_stale})
        << last;
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
    EXPECT_EQ(flags_at(old_us - 100'000'000), 0u) << "a sea that runs has run since it began";
    EXPECT_EQ(flags_at(old_us + 1'000'000), unknown) << "it may have ended meanwhile";
    EXPECT_TRUE(tests::eventually([&] { return flags_at(client->now_us()) == 0; }));
    EXPECT_TRUE(client->knows_sea_of(old_us));
    EXPECT_FALSE(client->knows_sea_of(between_us));
    EXPECT_TRUE(tests::eventually([&] { return client->knows_sea_of(client->now_us()); }));
    EXPECT_FALSE(client->knows_sea_of(client->now_us() + 60'000'000));
}

// Naive: a glide comes from where the one before came from, and so on: waves of a weather without pauses are never all there. Where one
// has ended as the next begins, what it led to is all that counts.
TEST(RowsWithoutPauses, leave_who_has_waves_with_waves_and_newcomers_too) {
    std::string scene(four_seas, std::strstr(four_seas, "[[weather]]"));
    for (int row = 0; row < 8;
         ++row) // one sea of them runs: ten seconds each, from long ago to far ahead
        scene += fmt::format("[[weather]]\nat_s = {}.0\nover_s = 10.0\n"
                             "set.sea.system.0.wind_speed_10m_mps = {}.0\n",
                             -65 + 10 * row, 7 + row % 2);
    tests::ServerProcess server(natively("rows.toml", scene));
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    const auto client = connect(url);
    ASSERT_TRUE(client);
    ASSERT_TRUE(client->subscribe_spectrum({}, 60));
    for (int look = 0; look < 8; ++look) {
        const sea::QueryPoint now{3, 4, client->now_us()};
        const Result<std::vector<sea::Answer>> own = client->sample({&now, 1});
        ASSERT_TRUE(own) << look << ": " << own.error().message;
        const Result<std::vector<sea::Answer>> exact = client->ask({&now, 1}, {true, 60, {}});
        ASSERT_TRUE(exact);
        EXPECT_LE(std::abs(own->at(0).height_m - exact->at(0).height_m), own->at(0).error_m);
        EXPECT_TRUE(client->status().holds_waves);
        std::this_thread::sleep_for(std::chrono::milliseconds(700));
    }
}

// Naive: what cannot be made of the scene of now ends the program, though its tiles answer.
TEST(GlidingNow, who_asks_from_the_scene_is_answered_from_tiles) {
    std::string scene = four_seas;
    scene.replace(scene.find("at_s = -100.0\nover_s = 20.0"), 27, "at_s = -100.0\nover_s = 900.0");
    tests::ServerProcess server(natively("gliding_now.toml", scene));
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    const nlohmann::json now = answers_of(url, "--local --from scene --at 3,4");
    ASSERT_EQ(now.size(), 1u);
    EXPECT_EQ(now[0]["flags"], 0);
}

// Naive: what was missed stays doubtful, whatever the server says of it when it is asked.
TEST(MissedSeas, are_known_again_once_the_server_has_been_asked) {
    tests::ServerProcess server(arguments(tests::folder().file("missed")));
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    const int port = tests::port_of(url);
    tests::FaultProxy line(port);
    const auto client = connect("ws://127.0.0.1:" + std::to_string(line.port()));
    ASSERT_TRUE(client);
    line.lead_to(1); // where nobody listens
    line.cut();
    const Said said = ctl(url, {"set", "sea.seed=5", "--over", "10s"});
    ASSERT_EQ(said.code, 0) << said.words;
    const auto start_us = sea::us_from_seconds(number(said.words, "start_s"));
    ASSERT_TRUE(tests::eventually([&] { return client->now_us() > start_us + 2'000'000; }));
    line.lead_to(port);
    ASSERT_TRUE(tests::eventually([&] { return client->status().connections == 2; }));
    const sea::QueryPoint missed{
        3, 4, start_us - 1000}; // before the sea that it was told of on its return
    EXPECT_FALSE(client->knows_sea_of(missed.time_us));
    ASSERT_TRUE(tests::eventually([&] { // once the server was heard to be behind that
        return client->hold({&missed.time_us, 1}, 30) && client->knows_sea_of(missed.time_us);
    }));
    EXPECT_EQ(client->sample({&missed, 1}).value()[0].flags, 0u);
}

} // namespace
} // namespace seaway::changes
