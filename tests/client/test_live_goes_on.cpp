// SPDX-License-Identifier: Apache-2.0
// A client that comes back by itself, over a line that breaks: what the C interface tells of it, what it leaves behind, and what
// staleness costs.
#include <cmath>
#include <filesystem>
#include <future>
#include <mutex>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/client.h"
#include "client/link/failure.h"
#include "client/link/message_stream.h"
#include "client/seaway.h"
#include "client/seaway_engine.h"
#include "client/staleness.h"
#include "sea/basics/glide.h"
#include "tests/client/announced_scene.h"
#include "tests/client/wave_server.h"
#include "tests/support/fault_proxy.h"

namespace seaway::client {
namespace {

using tests::eventually;
using tests::FaultProxy;

class LiveGoesOn : public tests::WaveServer {
  protected:
    std::unique_ptr<FaultProxy> line;
    std::string url;

    void SetUp() override {
        WaveServer::SetUp();
        line = std::make_unique<FaultProxy>(net->port());
        url = "ws://127.0.0.1:" + std::to_string(line->port());
    }
};

std::ptrdiff_t entries(const char* folder) {
    return std::distance(std::filesystem::directory_iterator(folder), {});
}

// Threads and descriptors, 200 times: each end has a stream with a thread of its own.
TEST_F(LiveGoesOn, leaves_nothing_behind_when_it_comes_back) {
    constexpr int clients_count = 20, rounds = 10;
    std::vector<std::unique_ptr<Client>> clients;
    for (int i = 0; i < clients_count; ++i) {
        auto client = Client::connect({.url = url, .timeout_s = 60});
        ASSERT_TRUE(client) << client.error().message;
        ASSERT_TRUE((*client)->subscribe({.fields = sea::surface_fields}, 2, 30));
        clients.push_back(std::move(*client));
    }
    const auto all_have = [&](int connections) {
        return std::ranges::all_of(clients, [&](const auto& client) {
            const ClientStatus status = client->status();
            return status.connections == connections && status.state == LinkState::connected;
        });
    };
    const auto settled = [&] { return line->connections() == clients_count; };
    ASSERT_TRUE(eventually(settled));
    const auto threads = entries("/proc/self/task"), files = entries("/proc/self/fd");
    for (int round = 1; round <= rounds; ++round) {
        line->cut();
        ASSERT_TRUE(eventually([&] { return all_have(round + 1); })) << "round " << round;
        ASSERT_TRUE(eventually(settled));
    }
    EXPECT_TRUE(eventually([&] { return entries("/proc/self/task") == threads; }));
    EXPECT_TRUE(eventually([&] { return entries("/proc/self/fd") == files; }))
        << entries("/proc/self/fd") << " files, before " << files;
    EXPECT_EQ(clients.front()->status().seas, 1);
}

// A host that takes the connection and says nothing is waited for, but not by who leaves.
TEST_F(LiveGoesOn, leaves_at_once_in_the_middle_of_an_attempt) {
    auto client = Client::connect({.url = url, .timeout_s = 3600});
    ASSERT_TRUE(client) << client.error().message;
    line->stall(true);
    line->cut();
    ASSERT_TRUE(eventually([&] { return (*client)->status().state == LinkState::connecting; }));
    client->reset(); // or this test does not end within an hour
}

// Naive: until the handshake's patience is over, which is that of connecting.
TEST_F(LiveGoesOn, a_peer_that_answers_no_goodbye_is_left_all_the_same) {
    const auto opened = open_websocket(*parse_url(url), {.connect_timeout_s = 3600});
    ASSERT_TRUE(opened) << opened.error().message;
    std::promise<std::string> closed;
    (*opened)->start({[](std::span<const std::uint8_t>) {}, [] {},
                      [&](const std::string& why) { closed.set_value(why); }});
    line->stall(true);
    (*opened)->close("enough");
    auto why = closed.get_future();
    ASSERT_EQ(why.wait_for(std::chrono::seconds(60)), std::future_status::ready);
    EXPECT_EQ(why.get(), "enough");
}

struct Told {
    std::mutex mutex;
    std::vector<seaway_status> all;

    std::size_t calls() {
        const std::scoped_lock lock(mutex);
        return all.size();
    }
    static void take(void* told, const seaway_status* status) {
        auto* to = static_cast<Told*>(told);
        const std::scoped_lock lock(to->mutex);
        to->all.push_back(*status);
    }
    bool of(uint32_t state) {
        const std::scoped_lock lock(mutex);
        return !all.empty() && all.back().state == state;
    }
    bool of_no_silence() {
        const std::scoped_lock lock(mutex);
        return all.back().stale_s == 0;
    }
    /// The first of each stretch of calls that say the same state.
    std::vector<seaway_status> states() {
        const std::scoped_lock lock(mutex);
        std::vector<seaway_status> others;
        for (const seaway_status& one : all)
            if (others.empty() || others.back().state != one.state)
                others.push_back(one);
        return others;
    }
};

TEST_F(LiveGoesOn, is_told_to_a_c_program_by_a_call_and_when_asked) {
    seaway_client* client = nullptr;
    seaway_connect_options options{};
    options.timeout_s = 60; // one attempt, however long it takes
    ASSERT_EQ(seaway_connect(url.c_str(), &options, &client), SEAWAY_OK) << seaway_last_error();
    Told told;
    ASSERT_EQ(seaway_watch_status(client, Told::take, &told), SEAWAY_OK);
    ASSERT_EQ(seaway_subscribe(client, nullptr), SEAWAY_OK) << seaway_last_error();
    // Naive: told of what the connection does alone.
    ASSERT_TRUE(eventually([&] { return told.calls() == 1; }));
    EXPECT_EQ(told.all[0].holds, static_cast<uint32_t>(SEAWAY_HOLDS_TILES));
    seaway_status status{};
    status.size = sizeof(status);
    ASSERT_EQ(seaway_get_status(client, &status), SEAWAY_OK);
    EXPECT_EQ(status.state, static_cast<uint32_t>(SEAWAY_CONNECTED));
    EXPECT_EQ(status.holds, static_cast<uint32_t>(SEAWAY_HOLDS_TILES));
    EXPECT_LT(status.held_from_us, status.held_until_us);
    EXPECT_STREQ(status.reason, "");
    // Later than changes are told ahead, which what streams may not be on a busy machine.
    const std::int64_t later_us = seaway_now_us(client) + 60'000'000;
    ASSERT_EQ(seaway_hold(client, &later_us, 1, 60), SEAWAY_OK) << seaway_last_error();
    // On a line that lets nobody back it stays as it is, however long this thread waits for its turn.
    line->stall(true);
    line->cut();
    ASSERT_TRUE(eventually([&] { return told.of(SEAWAY_CONNECTING); }));
    EXPECT_EQ(seaway_is_connected(client), 0);
    status.size = sizeof(status);
    ASSERT_EQ(seaway_get_status(client, &status), SEAWAY_OK);
    EXPECT_EQ(status.state, static_cast<uint32_t>(SEAWAY_CONNECTING));
    EXPECT_EQ(status.attempts, 1u);
    const seaway_point point{0, 0, later_us};
    seaway_answer answer{};
    EXPECT_EQ(seaway_sample(client, &point, 1, &answer), SEAWAY_OK) << seaway_last_error();
    EXPECT_EQ(answer.flags, static_cast<uint32_t>(SEAWAY_STALE));
    line->stall(false);
    ASSERT_TRUE(eventually([&] { return told.of(SEAWAY_CONNECTED); }));
    ASSERT_EQ(seaway_get_status(client, &status), SEAWAY_OK);
    EXPECT_EQ(status.connections, 2u);
    const std::vector<seaway_status> states = told.states();
    ASSERT_EQ(states.size(), 4u);
    const seaway_status& lost = states[1];
    EXPECT_EQ(lost.state, static_cast<uint32_t>(SEAWAY_WAITING));
    EXPECT_GT(std::string(lost.reason).size(), 0u);
    EXPECT_GT(lost.next_attempt_s, 0);
    EXPECT_LE(lost.next_attempt_s, 0.75) << "the first wait and half of it again";
    EXPECT_GT(lost.stale_s, 0);
    EXPECT_EQ(states[2].state, static_cast<uint32_t>(SEAWAY_CONNECTING));
    EXPECT_EQ(states[2].attempts, 1u);
    EXPECT_TRUE(eventually([&] { return told.of_no_silence(); }));
    ASSERT_EQ(seaway_watch_status(client, nullptr, nullptr), SEAWAY_OK);
    const std::size_t calls = told.calls();
    line->cut();
    EXPECT_TRUE(eventually([&] {
        return seaway_get_status(client, &status) == SEAWAY_OK && status.connections == 3 &&
               status.state == SEAWAY_CONNECTED;
    }));
    EXPECT_EQ(told.calls(), calls) << "nobody is told any more";
    seaway_disconnect(client);
}

/// Sends the scene that it is made of.
class WindySea : public tests::WaveSea {
    std::vector<server::SharedBytes> sea_state_messages() const override {
        return {std::make_shared<const protocol::Bytes>(protocol::sea_state(tests::announced()))};
    }
};

// Of a client that has stopped nothing watches any more.
TEST(LiveStopped, a_sea_that_is_rebuilt_is_there_when_that_returns) {
    WindySea sea;
    const auto net = tests::serve(sea);
    seaway_connect_options options{};
    options.stays_lost = 1;
    seaway_client* client = nullptr;
    ASSERT_EQ(seaway_connect(net->url().c_str(), &options, &client), SEAWAY_OK)
        << seaway_last_error();
    Told told;
    ASSERT_EQ(seaway_watch_status(client, Told::take, &told), SEAWAY_OK);
    net->stop();
    ASSERT_TRUE(eventually([&] { return told.of(SEAWAY_STOPPED); }));
    ASSERT_EQ(seaway_rebuild(client, seaway_now_us(client)), SEAWAY_OK) << seaway_last_error();
    seaway_status status{};
    status.size = sizeof status;
    ASSERT_EQ(seaway_get_status(client, &status), SEAWAY_OK);
    EXPECT_EQ(status.holds, static_cast<uint32_t>(SEAWAY_HOLDS_WAVES));
    seaway_disconnect(client);
}

// An older program's struct is shorter: nothing is written behind it.
TEST_F(LiveGoesOn, a_status_is_filled_in_as_far_as_the_program_knows_it) {
    seaway_client* client = nullptr;
    ASSERT_EQ(seaway_connect(url.c_str(), nullptr, &client), SEAWAY_OK) << seaway_last_error();
    seaway_status status{};
    status.size = offsetof(seaway_status, seas);
    status.seas = 77;
    ASSERT_EQ(seaway_get_status(client, &status), SEAWAY_OK);
    EXPECT_EQ(status.size, offsetof(seaway_status, seas));
    EXPECT_EQ(status.connections, 1u);
    EXPECT_EQ(status.seas, 77u);
    status.size = 0;
    EXPECT_EQ(seaway_get_status(client, &status), SEAWAY_BAD_ARGUMENT);
    seaway_disconnect(client);
    seaway_connect_options options{};
    options.stays_lost = 2;
    EXPECT_EQ(seaway_connect(url.c_str(), &options, &client), SEAWAY_BAD_ARGUMENT);
    options = {};
    for (const double back_s : {-0.1, 60.1, std::nan("")}) {
        options.look_back_s = back_s;
        EXPECT_EQ(seaway_connect(url.c_str(), &options, &client), SEAWAY_BAD_ARGUMENT) << back_s;
        EXPECT_THAT(seaway_last_error(), testing::HasSubstr("look_back_s is "));
    }
}

// Subscribed while the line was down: refused as lost, and not subscribed to behind its back.
TEST_F(LiveGoesOn, what_was_unsubscribed_from_stays_so) {
    auto client = Client::connect({.url = url, .timeout_s = 60});
    ASSERT_TRUE(client) << client.error().message;
    ASSERT_TRUE((*client)->subscribe({.fields = sea::surface_fields}, 2, 30));
    (*client)->unsubscribe();
    const int fetches = sea.fetches;
    line->stall(true);
    line->cut();
    ASSERT_TRUE(eventually([&] { return !(*client)->is_open(); }));
    const auto refused = (*client)->subscribe({.fields = sea::surface_fields}, 2, 30);
    ASSERT_FALSE(refused);
    EXPECT_EQ(failure_of(refused.error()), Failure::lost);
    line->stall(false);
    ASSERT_TRUE(eventually([&] { return (*client)->status().connections == 2; }));
    EXPECT_FALSE((*client)->grant()) << "nothing is subscribed to";
    const sea::QueryPoint point{0, 0, 0};
    ASSERT_TRUE((*client)->ask({&point, 1}, {}));
    EXPECT_EQ(sea.fetches, fetches) << "a subscription begins with the keyframes around now";
}

// The end may come before connect() has handed the client over: it is told once all the same.
TEST_F(LiveGoesOn, a_line_that_breaks_behind_the_first_sea_is_told_once) {
    for (int i = 0; i < 200; ++i) {
        const bool early = i % 2 == 0;
        std::atomic<int> told = 0;
        const auto cut_early = [&](const SeaStatePtr&) {
            if (early)
                line->cut();
        };
        const auto client = Client::connect(
            {.url = url, .timeout_s = 60, .stays_lost = true},
            {.on_sea_state = cut_early, .on_status = [&](const ClientStatus&) { ++told; }});
        if (!client && early)
            continue;
        ASSERT_TRUE(client) << client.error().message;
        if (!early)
            line->cut();
        ASSERT_TRUE(eventually([&] { return told == 1; }));
        EXPECT_EQ((*client)->status().state, LinkState::stopped);
    }
}

SeaState stale_state() {
    SeaState state;
    state.cascades = {{.length_m = 10, .size = 16, .interval_us = 100'000},
                      {.length_m = 100, .size = 16, .interval_us = 2'000'000}};
    state.realised.hs_m = 4;
    state.choppiness_x = 1;
    state.choppiness_y = 0.5;
    state.rms_slope = 0.1;
    state.displacement_reach_m = 6;
    return state;
}

TEST(Staleness, costs_nothing_until_a_change_may_have_begun_and_then_grows_to_another_sea) {
    const SeaState state = stale_state();
    const sea::TimeUs heard_us = 50'000'000;
    EXPECT_EQ(stale_error_m(state, heard_us, heard_us - 5'000'000), 0);
    EXPECT_EQ(stale_error_m(state, heard_us, heard_us + 3'000'000), 0) << "2 s interval, 1 s more";
    double last_m = 0;
    for (int i = 1; i <= 100; ++i) {
        const double error_m = stale_error_m(state, heard_us, heard_us + 3'000'000 + i * 100'000);
        EXPECT_GT(error_m, last_m);
        last_m = error_m;
    }
    // Five standard deviations of the difference of two seas of 1 m each, and a tenth for slopes.
    EXPECT_NEAR(last_m, 5 * std::sqrt(2.0) * 1.1, 1e-12);
    EXPECT_EQ(stale_error_m(state, heard_us, heard_us + 3'600'000'000), last_m);
    EXPECT_EQ(stale_displacement_error_m(state, heard_us, heard_us + 3'000'000), 0);
    EXPECT_NEAR(stale_displacement_error_m(state, heard_us, heard_us + 3'600'000'000),
                6 * std::sqrt(2.0), 1e-12);
}

// Naive: of a storm that fades, what a client that was cut off may miss is as little as of the calm that comes.
TEST(Staleness, of_a_sea_that_fades_is_that_of_what_it_still_was) {
    SeaState state = stale_state();
    state.start_time_us = 40'000'000;
    const sea::TimeUs heard_us = 50'000'000, late_us = heard_us + 3'600'000'000;
    const double calm_m = stale_error_m(state, heard_us, late_us);
    state.glide = protocol::GlideValues{.end_us = 640'000'000};
    state.glide->realised = protocol::SeaNumbers{.hs_m = 10};
    EXPECT_NEAR(stale_error_m(state, heard_us, late_us),
                calm_m * state.realised_at(heard_us).hs_m / state.realised.hs_m, 1e-9);
    EXPECT_NEAR(stale_error_m(state, 641'000'000, late_us), calm_m, 1e-12);
}

// Naive: by the choppiness that it ends with, of which nothing moves sideways.
TEST(Staleness, of_a_sea_whose_choppiness_glides_is_that_of_what_moves_most) {
    SeaState state = stale_state();
    const sea::TimeUs heard_us = 50'000'000, late_us = heard_us + 3'600'000'000;
    state.choppiness_x = state.choppiness_y = 0;
    const double still_m = stale_error_m(state, heard_us, late_us);
    state.glide =
        protocol::GlideValues{.end_us = 640'000'000, .choppiness_x = 3, .choppiness_y = 2};
    EXPECT_NEAR(stale_error_m(state, heard_us, late_us), still_m * (1 + 3 * state.rms_slope),
                1e-12);
}

// The hardest change that the error is stated for: waves of the same energy that have nothing to do with those before.
TEST(Staleness, is_true_of_a_change_to_another_sea_of_the_same_height) {
    const SeaState state = stale_state();
    std::mt19937_64 random(4);
    std::normal_distribution<double> height(0, state.realised.hs_m / 4);
    int outside = 0, halfway = 0;
    for (int i = 0; i < 100'000; ++i) {
        const double before_m = height(random), after_m = height(random);
        const auto passed_us = static_cast<sea::TimeUs>(random() % sea::glide_us_min);
        const double share = sea::glide_share(passed_us, 0, sea::glide_us_min);
        const double missed_m = std::abs(share * (after_m - before_m));
        const double error_m = stale_error_m(state, -3'000'000, passed_us);
        outside += missed_m > error_m;
        halfway += missed_m > error_m / 5;
    }
    EXPECT_EQ(outside, 0) << "5.5 standard deviations: 4e-8 of 1e5";
    EXPECT_GT(halfway, 10'000) << "27 % are beyond 1.1 of them: it is not a bound of anything";
}

} // namespace
} // namespace seaway::client
