// SPDX-License-Identifier: Apache-2.0
// A sea that changes while real programs serve it, watch it and end.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>
#include <regex>
#include <thread>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/child_process.h"
#include "client/client.h"
#include "sea/scene/scene.h"
#include "server/journal/sea_clock.h"
#include "server/journal/sqlite_journal.h"
#include "tests/server/change_bench.h"
#include "tests/support/eventually.h"
#include "tests/support/read_file.h"

namespace seaway::changes {
namespace {

using client::Client;
using sea::TimeUs;

// Waves are sent once for both, by and by until the end of the glide: until then less is known, and said.
TEST(Changes, who_has_the_waves_glides_by_itself_and_so_does_who_joins_on_the_way) {
    tests::ServerProcess server(arguments(tests::folder().file("waves")));
    const std::string url = server.wait_until_ready();
    const auto client = connect(url);
    ASSERT_TRUE(client) << server.log();
    ASSERT_TRUE(client->subscribe_spectrum({}, 30));
    const Said said =
        ctl(url, {"set", "systems.0.wind_speed_10m_mps=12", "sea.depth_m=25", "--over", "12s"});
    ASSERT_EQ(said.code, 0) << said.words;
    const double start_s = number(said.words, "start_s"), end_s = number(said.words, "end_s");
    std::vector<sea::QueryPoint> points;
    for (const double at_s :
         {start_s - 500, start_s - 0.001, start_s + 0.5, start_s + 3, start_s + 6, start_s + 9,
          end_s - 0.001, end_s + 0.001, end_s + 40, end_s + 1e5})
        for (int place = 0; place < 5; ++place)
            points.push_back({37.0 * place, -91.0 * place, sea::us_from_seconds(at_s)});
    // The state of the sea at the end comes within the ten seconds before it begins.
    wait_until(*client, start_s + 5);
    expect_right(*client, points, 0.1);
    const auto late = connect(url);
    ASSERT_TRUE(late);
    const auto granted = late->subscribe_spectrum({}, 30);
    ASSERT_TRUE(granted) << granted.error().message;
    EXPECT_EQ(granted->spectra, 2u) << "of both ends, and no third for the sea behind";
    expect_right(*late, points);
    // So many of a time that maps are made of the waves, with what they grow by: the bound is of those.
    std::vector<sea::QueryPoint> dense;
    for (const double at_s : {start_s + 2.5, start_s + 7, end_s - 0.01})
        for (int place = 0; place < 300; ++place)
            dense.push_back({13.0 * place, -7.0 * place, sea::us_from_seconds(at_s)});
    expect_right(*late, dense, 0.05);
    wait_until(*client, end_s + 3); // two pings later
    for (const auto& one : {client.get(), late.get()}) {
        expect_right(*one, points);
        EXPECT_TRUE(one->status().holds_waves) << "those that the glide led to";
    }
    const auto afterwards = connect(url);
    ASSERT_TRUE(afterwards);
    ASSERT_TRUE(afterwards->subscribe_spectrum({}, 30)) << "and its probes agree";
    expect_right(*afterwards, std::span(points).last(15));
}

// Naive: of the glides that end where a steady sea begins the first is taken, which another had taken over from.
TEST(Changes, of_two_that_are_to_end_at_the_same_moment_the_later_ones_waves_stay) {
    tests::ServerProcess server(arguments(tests::folder().file("same_end")));
    const std::string url = server.wait_until_ready();
    const auto client = connect(url);
    ASSERT_TRUE(client) << server.log();
    ASSERT_TRUE(client->subscribe_spectrum({}, 30));
    const int start_s = static_cast<int>(sea::seconds_from_us(client->now_us())) + 4;
    const auto set = [&](const char* value, int at_s) {
        return ctl(url, {"set", value, "--at", std::to_string(at_s), "--over",
                         fmt::format("{}s", start_s + 16 - at_s)});
    };
    ASSERT_EQ(set("systems.0.from_deg=40", start_s).code, 0);
    ASSERT_EQ(set("systems.0.from_deg=160", start_s + 6).code, 0);
    wait_until(*client, start_s + 19); // two pings behind the end
    std::vector<sea::QueryPoint> points;
    for (const double after_s : {-0.001, 0.001, 2.5, 40.0, 1e5})
        for (int place = 0; place < 5; ++place)
            points.push_back(
                {37.0 * place, -91.0 * place, sea::us_from_seconds(start_s + 16 + after_s)});
    expect_right(*client, points);
}

TEST(Changes, survive_twenty_kills_bit_for_bit_and_none_that_was_acknowledged_is_lost) {
    const std::string folder = tests::folder().file("killed");
    std::mt19937 random(12);
    std::vector<sea::QueryPoint> points;
    const auto look_at = [&](double begin_s, double end_s) {
        for (int i = 0; i < 20; ++i)
            points.push_back(
                {31.0 * i, -17.0 * i, sea::us_from_seconds(begin_s + (end_s - begin_s) * i / 19)});
    };
    look_at(-10, 0);
    std::vector<sea::Answer> before;
    constexpr int kills = 20;
    for (int round = 0; round <= kills; ++round) {
        tests::ServerProcess server(arguments(folder));
        const std::string url = server.wait_until_ready();
        const auto client = connect(url);
        ASSERT_TRUE(client) << server.log();
        if (round > 0) {
            const auto after = client->ask(points, {.exact = true, .timeout_s = 60});
            ASSERT_TRUE(after) << after.error().message;
            for (std::size_t i = 0; i < points.size(); ++i)
                EXPECT_EQ((*after)[i].height_m, before[i].height_m) << round << ' ' << i;
        }
        // Three kills within each glide, of which eight in a row at most may cut each other.
        if (round % 3 == 0) {
            const Said said = ctl(
                url, {"set", fmt::format("systems.0.wind_speed_10m_mps={}", 6 + 3 * (round % 5)),
                      fmt::format("sea.depth_m={}", 20 + 10 * (round % 4)), "--over", "10s"});
            ASSERT_EQ(said.code, 0) << said.words;
            // By its own times, so that however long the rounds before took it is looked at: before it, in it and behind it.
            look_at(number(said.words, "start_s") - 3, number(said.words, "end_s") + 5);
            // Without a change it is what has just been asked for, to the bit.
            const auto asked = client->ask(points, {.exact = true, .timeout_s = 60});
            ASSERT_TRUE(asked) << asked.error().message;
            before = *asked;
        }
        // Before the glide, which begins some seconds later, at its beginning, and well within it.
        const auto most_ms = round % 5 == 0 ? 3000 : 1000;
        std::this_thread::sleep_for(std::chrono::milliseconds(random() % most_ms));
        server.send(SIGKILL);
        EXPECT_TRUE(server.wait_for_exit(std::chrono::seconds(10)));
    }
}

// Naive: values are set in the sea of this moment, and the change before, promised and not yet begun, is lost.
TEST(Changes, one_that_follows_another_at_once_keeps_what_that_one_set) {
    tests::ServerProcess server(arguments(tests::folder().file("quick")));
    const std::string url = server.wait_until_ready();
    const auto client = connect(url);
    ASSERT_TRUE(client) << server.log();
    Said said{};
    for (const char* value :
         {"systems.0.wind_speed_10m_mps=12", "sea.depth_m=30", "foam.bias=0.1"}) {
        said = ctl(url, {"set", value, "--over", "10s"});
        ASSERT_EQ(said.code, 0) << said.words;
    }
    // One begins before all others, and has nothing of one that is to come.
    ASSERT_EQ(ctl(url, {"set", "sea.depth_m=44", "--at", "1000"}).code, 0);
    const auto told = [&](double time_s) {
        const sea::QueryPoint point{0, 0, static_cast<TimeUs>(time_s * 1e6)};
        EXPECT_TRUE(client->fetch_and_sample({&point, 1}, 20));
        return client->sea_state(point.time_us)->scene;
    };
    const std::string scene = told(number(said.words, "end_s") + 1);
    for (const char* line : {"wind_speed_10m_mps = 12", "depth_m = 30", "bias = 0.1"})
        EXPECT_NE(scene.find(line), std::string::npos) << line << " in\n" << scene;
}

// Naive: the start is set before the rows of the timetable are looked through, and is over when they are. That takes long where
// a sea has many waves.
TEST(Changes, a_scene_with_a_long_timetable_begins_after_it_was_announced) {
    const std::string calm = "scenes/calm.toml";
    std::vector<std::string> words = arguments(tests::folder().file("long"));
    words[0] = calm;
    tests::ServerProcess server(words);
    const std::string url = server.wait_until_ready();
    const auto client = connect(url);
    ASSERT_TRUE(client) << server.log();
    std::string scene = tests::read_file(SEAWAY_SOURCE_DIR "/" + calm);
    for (int i = 0; i < 60; ++i)
        scene += fmt::format("[[weather]]\nat_s = {}\nover_s = 20\nset.systems.0.from_deg = {}\n",
                             1000 + 100 * i, 200 + i);
    const Said said =
        ctl(url, {"--timeout", "60", "load", tests::folder().write("long.toml", scene)});
    ASSERT_EQ(said.code, 0) << said.words;
    EXPECT_GT(number(said.words, "start_s"), sea::seconds_from_us(client->now_us()));
}

// Naive: each is promised, and the seas of those to come throw out the one that runs: nothing comes for seconds.
TEST(Changes, more_than_a_few_that_have_not_begun_are_refused_until_one_has) {
    tests::ServerProcess server(arguments(tests::folder().file("many")));
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    const auto set = [&](int from_deg) {
        return ctl(url, {"set", fmt::format("systems.0.from_deg={}", from_deg), "--over", "10s"});
    };
    Said said{0, ""};
    int taken = 0;
    const auto start = std::chrono::steady_clock::now();
    while (said.code == 0 && taken < 40)
        taken += (said = set(10 * taken)).code == 0;
    const auto each = (std::chrono::steady_clock::now() - start) / std::max(1, taken);
    EXPECT_EQ(said.code, 6) << said.words;
    // Where a machine takes a fifth of a second for each, they begin meanwhile, and are one too many that take over.
    if (each < std::chrono::milliseconds(200)) {
        EXPECT_NE(said.words.find("have not begun"), std::string::npos) << said.words;
    }
    EXPECT_GE(taken, 2);
    for (int i = 0; i < 100 && said.code != 0; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(200));
        said = set(5);
    }
    EXPECT_EQ(said.code, 0) << said.words;
    // One that is far off keeps no place.
    EXPECT_EQ(ctl(url, {"set", "sea.depth_m=30", "--at", "5000"}).code, 0);
}

TEST(Changes, strangers_change_nothing_and_end_nobodys_session) {
    tests::ServerProcess server(arguments(tests::folder().file("strangers")));
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    const auto client = connect(url);
    ASSERT_TRUE(client);
    const std::string number = std::to_string(client->welcome().session);
    for (const std::vector<std::string>& words :
         std::vector<std::vector<std::string>>{{"set", "sea.depth_m=20"},
                                               {"load", SEAWAY_SOURCE_DIR "/scenes/calm.toml"},
                                               {"pause"},
                                               {"rate", "2"},
                                               {"rewind", "1"},
                                               {"history"},
                                               {"sessions"},
                                               {"drop", number}}) {
        const Said said = ctl(url, words, "");
        EXPECT_EQ(said.code, 6) << words[0];
        EXPECT_NE(said.words.find("for administrators"), std::string::npos) << said.words;
    }
    const sea::QueryPoint somewhere{1, 2, 0};
    EXPECT_TRUE(client->ask({&somewhere, 1}, {})) << "it goes on";
    EXPECT_EQ(server.log().find("event=change_asked"), std::string::npos) << server.log();
    EXPECT_EQ(ctl(url, {"rate", "2"}).code, 0);
    EXPECT_TRUE(tests::eventually([&] {
        return server.log().find("event=change_asked session=") != std::string::npos;
    })) << server.log();
}

TEST(Changes, are_for_administrators_and_refused_with_what_is_wrong) {
    tests::ServerProcess server(arguments(tests::folder().file("admin")));
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    const auto refused = [&](std::vector<std::string> words, const std::string& why) {
        const Said said = ctl(url, words);
        EXPECT_EQ(said.code, 6) << said.words;
        EXPECT_NE(said.words.find(why), std::string::npos) << said.words;
    };
    refused({"set", "sea.depth_m=-1"}, "sea.depth_m: -1");
    // Lines are written by a thread of their own.
    const std::regex asked("event=change_asked session=[0-9]+ .*what=\"sea.depth_m=-1\"");
    EXPECT_TRUE(tests::eventually([&] { return std::regex_search(server.log(), asked); }))
        << server.log();
    refused({"set", "sea.choppiness=0.5", "sea.depth_m=-2"}, "sea.depth_m: -2");
    EXPECT_TRUE(tests::eventually([&] {
        return server.log().find("what=\"sea.choppiness=0.5 sea.depth_m=-2\"") != std::string::npos;
    })) << "an innocent value hides none that follow: "
        << server.log();
    refused({"set", "sea.dept_m=20"}, "depth_m");
    refused({"set", "systems.7.from_deg=20"}, "there is no sea.system.7");
    refused({"set", "accuracy.height_error_m=0.5"}, "accuracy cannot change");
    refused({"load", SEAWAY_SOURCE_DIR "/scenes/hurricane.toml"},
            "cannot change while the sea runs");
    const std::regex scene("what=\"a scene of [0-9]+ bytes, fnv1a [0-9a-f]{16}\"");
    EXPECT_TRUE(tests::eventually([&] { return std::regex_search(server.log(), scene); }))
        << server.log();
    EXPECT_NE(server.log().find("event=change_refused session="), std::string::npos)
        << "who runs the server sees it too: " << server.log();
    EXPECT_NE(server.log().find("sea.depth_m: -1 is not allowed"), std::string::npos)
        << server.log();
    refused({"drop", "999"}, "session is 999");
    EXPECT_EQ(ctl(url, {"set", "sea.depth_m=20", "--over", "1s"}).code, 2);
    EXPECT_EQ(ctl(url, {"set"}).code, 2);
    for (const auto& [words, why] :
         {std::pair(std::vector<std::string>{"rate", "0.0001"}, "rate 0.0001: 0.001 and more"),
          {{"history", "--from", "-3"}, "--from -3: a number is expected"},
          {{"rewind", "-1"}, "rewind -1: a number is expected"},
          {{"drop", "-1"}, "drop -1: a number is expected"},
          {{"set", "system.0.from_deg=20"}, "systems.0... with an s"}}) {
        const Said said = ctl(url, words);
        EXPECT_EQ(said.code, 2) << said.words;
        EXPECT_NE(said.words.find(why), std::string::npos) << said.words;
    }
    EXPECT_EQ(ctl("ws://127.0.0.1:1", {"state"}).code, 5);
    const Said state = ctl(url, {"state"});
    EXPECT_EQ(state.code, 0);
    EXPECT_NE(state.words.find("\"hs_m\""), std::string::npos);
    EXPECT_NE(ctl(url, {"plan"}).words.find("\"cascades\""), std::string::npos);
    // A session that an administrator ends.
    const auto client = connect(url);
    ASSERT_TRUE(client);
    const std::string number = std::to_string(client->welcome().session);
    EXPECT_NE(ctl(url, {"sessions"}).words.find("\"session\": " + number), std::string::npos);
    EXPECT_EQ(ctl(url, {"drop", number}).code, 0);
    EXPECT_TRUE(tests::eventually([&] { return !client->closed_reason().empty(); }));
    EXPECT_NE(client->closed_reason().find("dropped"), std::string::npos)
        << client->closed_reason();
}

// The journal was begun by a clock that was an hour ahead and has been set right since: sea time is negative for an hour.
TEST(Changes, before_time_0_a_sea_changes_as_at_any_other_time) {
    const std::string folder = tests::folder().file("before");
    const auto scene = sea::read_scene(std::string(SEAWAY_SOURCE_DIR "/") + small_sea);
    ASSERT_TRUE(scene);
    constexpr std::int64_t hour_us = 3'600'000'000;
    ASSERT_TRUE(server::SqliteJournal::open(
        folder, {server::SeaClock::utc_now_us() + hour_us, sea::to_toml(*scene)}, "--journal"));
    tests::ServerProcess server(arguments(folder));
    const std::string url = server.wait_until_ready();
    const auto there = connect(url);
    ASSERT_TRUE(there) << server.log();
    EXPECT_LT(there->now_us(), 0);
    ASSERT_TRUE(there->subscribe({.fields = sea::surface_fields}, 8, 60));
    const Said said = ctl(url, {"set", "systems.0.wind_speed_10m_mps=12", "--over", "10s"});
    ASSERT_EQ(said.code, 0) << said.words;
    const double start_s = number(said.words, "start_s"), end_s = number(said.words, "end_s");
    EXPECT_LT(end_s, 0);
    // Who was there before the change, and who comes while it runs, sample what the server says.
    wait_until(*there, start_s + 1);
    const auto came = connect(url);
    ASSERT_TRUE(came) << "locked out while it glides: " << server.log();
    const std::vector<sea::QueryPoint> points{{3, 4, sea::us_from_seconds(start_s - 2)},
                                              {3, 4, sea::us_from_seconds(start_s + 5)},
                                              {3, 4, sea::us_from_seconds(end_s + 2)}};
    for (Client* client : {there.get(), came.get()}) {
        const auto sampled = client->fetch_and_sample(points, 30);
        const auto exact = client->ask(points, {.exact = true, .timeout_s = 30});
        ASSERT_TRUE(sampled && exact);
        for (std::size_t i = 0; i < points.size(); ++i)
            EXPECT_NEAR((*sampled)[i].height_m, (*exact)[i].height_m,
                        (*sampled)[i].error_m + (*exact)[i].error_m)
                << i;
    }
}

} // namespace
} // namespace seaway::changes
