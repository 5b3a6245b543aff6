// SPDX-License-Identifier: Apache-2.0
// A client without threads (seaway_connect_options.threadless): the same by its program's own calls, and no thread to be found.
#include <algorithm>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <poll.h>

#include "tests/client/engine.h"
#include "tests/support/eventually.h"
#include "tests/support/fault_proxy.h"
#include "tests/support/folder.h"

extern "C" seaway_code one_answer_without_threads_in_c(const char* url, seaway_answer* water);

namespace seaway {
namespace {

using tests::FaultProxy;

class Threadless : public tests::Engine {
  protected:
    static seaway_connect_options options() {
        seaway_connect_options made{};
        made.timeout_s = 60;
        made.threadless = 1;
        return made;
    }
    /// Of this process, by their numbers.
    static std::set<std::string> threads() {
        std::set<std::string> all;
        for (const auto& one : std::filesystem::directory_iterator("/proc/self/task"))
            all.insert(one.path().filename());
        return all;
    }
    static seaway_event poll(const Sea& client, double timeout_s = 0) {
        seaway_event event = SEAWAY_SIZED(seaway_event);
        EXPECT_EQ(seaway_poll(client.handle(), timeout_s, &event), SEAWAY_OK)
            << seaway_last_error();
        return event;
    }
    /// As a loop of frames would, within a minute.
    template <class Condition>
    static bool in_frames(const Sea& client, const Condition& condition) {
        const auto until = std::chrono::steady_clock::now() + std::chrono::minutes(1);
        while (!condition()) {
            if (std::chrono::steady_clock::now() > until)
                return false;
            poll(client, 0.005);
        }
        return true;
    }
};

TEST_F(Threadless, makes_no_thread_whatever_it_is_asked) {
    const std::set<std::string> before = threads();
    // One that was joined stands in /proc for a moment: also one of a test before.
    const auto none_is_new = [&] { return std::ranges::includes(before, threads()); };
    {
        const Sea with("ws://localhost:" + std::to_string(net->port()));
        EXPECT_FALSE(none_is_new()) << "threads are seen where there are some";
    }
    ASSERT_TRUE(tests::eventually(none_is_new));
    const std::vector<seaway_point> points = places(10);
    Sea client("ws://localhost:" + std::to_string(net->port()), options());
    EXPECT_TRUE(none_is_new()) << "the name was looked up, too";
    client.subscribe();
    EXPECT_EQ(client.query(points).size(), 10u);
    hold_sea(client, true);
    hold_sea(client, false);
    std::uint64_t question = 0;
    ASSERT_EQ(seaway_ask(client.handle(), points.data(), points.size(), 0, 60, &question),
              SEAWAY_OK);
    while (poll(client, 0.01).kind != SEAWAY_ANSWERED)
        ;
    client.unsubscribe();
    net.reset();
    ASSERT_TRUE(in_frames(client, [&] { return client.status().state == SEAWAY_WAITING; }));
    ASSERT_TRUE(in_frames(client, [&] { return client.status().attempts == 1; }));
    EXPECT_TRUE(none_is_new());
}

TEST_F(Threadless, has_the_answers_of_a_client_with_threads) {
    const std::vector<seaway_point> points = places(200);
    for (const bool tiles : {true, false}) {
        Sea with(net->url()), without(net->url(), options());
        hold_sea(with, tiles);
        hold_sea(without, tiles);
        const std::vector<seaway_answer> expected = with.sample(points);
        const std::vector<seaway_answer> answers = without.sample(points);
        for (std::size_t i = 0; i < points.size(); ++i) {
            EXPECT_EQ(answers[i].height_m, expected[i].height_m);
            EXPECT_EQ(answers[i].error_m, expected[i].error_m);
            EXPECT_EQ(answers[i].flags, expected[i].flags);
        }
        EXPECT_EQ(with.query(points)[7].height_m, without.query(points)[7].height_m);
    }
}

TEST_F(Threadless, sleeps_at_its_descriptor_and_is_woken_by_what_comes_and_what_is_to_be_sent) {
    const Sea client(net->url(), options());
    pollfd waits{seaway_poll_descriptor(client.handle()), POLLIN, 0};
    ASSERT_GE(waits.fd, 0) << seaway_last_error();
    EXPECT_EQ(seaway_poll_descriptor(client.handle()), waits.fd);
    const std::vector<seaway_point> points = places(50);
    for (int round = 0; round < 20; ++round) {
        std::uint64_t question = 0;
        ASSERT_EQ(seaway_ask(client.handle(), points.data(), points.size(), 0, 60, &question),
                  SEAWAY_OK);
        seaway_event event{};
        while (event.kind != SEAWAY_ANSWERED) {
            ASSERT_EQ(::poll(&waits, 1, 60'000), 1);
            event = poll(client);
        }
        EXPECT_EQ(event.question, question);
        std::vector<seaway_answer> answers(points.size());
        ASSERT_EQ(seaway_take_answers(client.handle(), question, answers.data(), answers.size()),
                  SEAWAY_OK);
        EXPECT_EQ(answers[3].height_m,
                  sea.truth({points[3].x_m, points[3].y_m, points[3].time_us}).height_m);
    }
}

TEST_F(Threadless, is_what_the_worked_example_of_the_header_has_in_c) {
    seaway_answer water{};
    ASSERT_EQ(one_answer_without_threads_in_c(net->url().c_str(), &water), SEAWAY_OK)
        << seaway_last_error();
    EXPECT_NE(water.height_m, 0);
}

TEST_F(Threadless, does_nothing_between_two_polls) {
    sea.answer_queries = false;
    const Sea client(net->url(), options());
    const seaway_point point{1, 2, asked_us};
    std::uint64_t question = 0;
    ASSERT_EQ(seaway_ask(client.handle(), &point, 1, 0, 0.05, &question), SEAWAY_OK);
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    EXPECT_EQ(sea.queries, 0) << "it is sent by a poll";
    seaway_answer answer{};
    EXPECT_EQ(seaway_take_answers(client.handle(), question, &answer, 1), SEAWAY_PENDING)
        << "deadlines pass in polls";
    ASSERT_TRUE(in_frames(client, [&] {
        return seaway_take_answers(client.handle(), question, &answer, 1) != SEAWAY_PENDING;
    }));
}

TEST_F(Threadless, comes_back_in_polls_with_what_was_subscribed_to_and_goes_on_meanwhile) {
    FaultProxy line(net->port());
    Sea client("ws://127.0.0.1:" + std::to_string(line.port()), options());
    client.subscribe();
    hold_sea(client, false);
    const std::int64_t held_us = client.status().held_until_us;
    struct Told {
        std::thread::id by;
        std::vector<std::uint32_t> states;
    } told;
    ASSERT_EQ(seaway_watch_status(
                  client.handle(),
                  [](void* user, const seaway_status* status) {
                      auto* to = static_cast<Told*>(user);
                      to->by = std::this_thread::get_id();
                      to->states.push_back(status->state);
                  },
                  &told),
              SEAWAY_OK);
    // All that it holds has been told before the first is cut.
    ASSERT_TRUE(in_frames(client, [&] {
        return client.status().holds == (SEAWAY_HOLDS_WAVES | SEAWAY_HOLDS_TILES);
    }));
    poll(client);
    told.states.clear();
    for (std::uint32_t round = 2; round <= 4; ++round) {
        line.cut();
        sea::TimeUs last_us = client.now_us();
        ASSERT_TRUE(in_frames(client, [&] {
            const sea::TimeUs now_us = client.now_us();
            EXPECT_GE(now_us, last_us);
            last_us = now_us;
            const seaway_point here{5, 6, now_us};
            const seaway_answer answer = client.sample(here);
            EXPECT_LE(std::abs(answer.height_m - sea.truth({5, 6, now_us}).height_m),
                      answer.error_m);
            const seaway_status status = client.status();
            return status.connections == round && status.state == SEAWAY_CONNECTED;
        })) << client.status().reason;
    }
    EXPECT_EQ(client.status().seas, 1u);
    ASSERT_GE(told.states.size(), 9u) << "lost, an attempt, back: three times";
    EXPECT_EQ(told.states[0], static_cast<std::uint32_t>(SEAWAY_WAITING));
    EXPECT_EQ(told.states[1], static_cast<std::uint32_t>(SEAWAY_CONNECTING));
    EXPECT_EQ(told.by, std::this_thread::get_id());
    EXPECT_GT(client.status().held_until_us, held_us) << "each subscription brings the present";
}

TEST_F(Threadless, drops_the_sea_where_another_one_answers) {
    FaultProxy line(net->port());
    Sea client("ws://127.0.0.1:" + std::to_string(line.port()), options());
    hold_sea(client, false);
    // Its time began so much later that no clock is as far off.
    std::this_thread::sleep_for(std::chrono::milliseconds(700));
    tests::WaveSea other;
    const auto another = tests::serve(other);
    ASSERT_TRUE(another);
    line.lead_to(another->port());
    line.cut();
    ASSERT_TRUE(in_frames(client, [&] { return client.status().seas == 2; }))
        << client.status().reason;
    ASSERT_TRUE(in_frames(client, [&] { return client.status().state == SEAWAY_CONNECTED; }));
    EXPECT_NE(std::string(client.status().reason).find("another sea"), std::string::npos);
    EXPECT_LT(client.now_us(), sea.sea_time_us() - 500'000) << "the time is that of the other one";
    ASSERT_TRUE(in_frames(client, [&] { return client.status().holds == SEAWAY_HOLDS_WAVES; }));
    const seaway_point here{1, 2, client.now_us()};
    EXPECT_EQ(client.sample(here).flags, 0u) << "its waves were subscribed to again";
}

TEST_F(Threadless, stops_for_good_where_it_is_turned_away_and_says_why) {
    FaultProxy line(net->port());
    Sea client("ws://127.0.0.1:" + std::to_string(line.port()), options());
    hold_sea(client, false);
    const std::string token = tests::folder().write("token", "open sesame\n");
    server::NetOptions closed;
    closed.listen = "127.0.0.1:0";
    closed.client_token_file = token;
    auto behind_a_door = server::NetServer::start(closed, sea);
    std::filesystem::remove(token);
    ASSERT_TRUE(behind_a_door) << behind_a_door.error().message;
    line.lead_to((*behind_a_door)->port());
    line.cut();
    ASSERT_TRUE(in_frames(client, [&] { return client.status().state == SEAWAY_STOPPED; }))
        << client.status().reason;
    EXPECT_NE(std::string(client.status().reason).find("token"), std::string::npos)
        << client.status().reason;
    const std::uint32_t attempts = client.status().attempts;
    poll(client, 0.05);
    EXPECT_EQ(client.status().attempts, attempts) << "it does not come again";
    const seaway_point later{1, 2, client.now_us() + 1'000'000};
    EXPECT_EQ(client.sample(later).flags, static_cast<std::uint32_t>(SEAWAY_STALE))
        << "what is held stays";
}

TEST_F(Threadless, tells_of_an_attempt_that_leads_nowhere_and_can_be_left_in_the_middle_of_it) {
    FaultProxy line(net->port());
    Sea client("ws://127.0.0.1:" + std::to_string(line.port()), options());
    line.stall(true);
    line.cut();
    ASSERT_TRUE(in_frames(client, [&] { return client.status().state == SEAWAY_CONNECTING; }));
    const std::vector<seaway_point> points = places(1);
    seaway_answer answer{};
    EXPECT_EQ(seaway_query(client.handle(), points.data(), 1, 0, 10, &answer), SEAWAY_LOST)
        << "there is nobody to ask";
}

// Naive: an attempt that is given up says goodbye, and a peer that says nothing is waited for, for a second, each time. Half of that is
// enough for whatever else a busy machine does within a poll, once in five times.
TEST_F(Threadless, waits_in_no_poll_for_a_peer_that_shakes_hands_and_says_nothing) {
    using std::chrono::steady_clock;
    constexpr std::chrono::milliseconds enough{500};
    seaway_connect_options brief = options();
    brief.timeout_s = 1;
    steady_clock::duration longest = enough;
    for (int round = 0; round < 5 && longest >= enough; ++round) {
        tests::WaveSea silent;
        const auto peer = tests::serve(silent);
        ASSERT_TRUE(peer);
        FaultProxy line(peer->port());
        const std::string there = "ws://127.0.0.1:" + std::to_string(line.port());
        std::optional<Sea> client;
        ASSERT_TRUE(tests::eventually([&] { // one second may be too little for it
            try {
                client.emplace(there, brief);
            } catch (const SeaError&) {
            }
            return client.has_value();
        }));
        line.cut();
        ASSERT_TRUE(in_frames(*client, [&] { return client->status().state == SEAWAY_WAITING; }));
        silent.late_ms = 4'000; // its welcome has a time, and its thread waits for that
        longest = {};
        ASSERT_TRUE(tests::eventually([&] {
            const auto begun = steady_clock::now();
            poll(*client);
            longest = std::max(longest, steady_clock::now() - begun);
            return std::string(client->status().reason).find("sends no welcome") !=
                   std::string::npos;
        })) << client->status().reason;
        silent.late_ms = 0;
    }
    EXPECT_LT(longest, enough);
}

TEST_F(Threadless, that_is_polled_rarely_says_that_it_is_stale_and_is_right) {
    FaultProxy line(net->port());
    Sea client("ws://127.0.0.1:" + std::to_string(line.port()), options());
    hold_sea(client, false);
    ASSERT_TRUE(in_frames(client, [&] { return client.status().stale_s == 0; }));
    const auto asked_now = [&] {
        seaway_sampling how = SEAWAY_SIZED(seaway_sampling);
        how.times = SEAWAY_TIMES_OF_NOW;
        const auto [truly_us, now_us] = both_times(client);
        const seaway_point here{7, 8, now_us};
        seaway_answer answer{};
        EXPECT_EQ(seaway_sample_as(client.handle(), &how, &here, 1, &answer), SEAWAY_OK);
        EXPECT_LE(std::abs(answer.height_m - sea.truth({7, 8, truly_us}).height_m), answer.error_m);
        return answer.flags;
    };
    EXPECT_EQ(asked_now(), 0u);
    // Pings go out, and their answers come while nobody looks.
    line.stall(true);
    const auto later = std::chrono::steady_clock::now() + std::chrono::milliseconds(500);
    while (std::chrono::steady_clock::now() < later)
        poll(client, 0.01);
    line.stall(false);
    // Who is not heard for three seconds is silent.
    std::this_thread::sleep_for(std::chrono::milliseconds(3'200));
    EXPECT_EQ(asked_now(), static_cast<std::uint32_t>(SEAWAY_STALE));
    line.stall(true);
    poll(client);
    EXPECT_EQ(asked_now(), static_cast<std::uint32_t>(SEAWAY_STALE))
        << "what was said long ago is not news";
    line.stall(false);
    EXPECT_TRUE(in_frames(client, [&] { return asked_now() == 0; }));
    EXPECT_TRUE(client.is_connected());
}

TEST_F(Threadless, is_used_by_several_threads_as_any_client) {
    Sea client(net->url(), options());
    hold_sea(client, true);
    std::atomic<int> answered = 0;
    std::vector<std::thread> callers;
    for (int t = 0; t < 4; ++t)
        callers.emplace_back([&, t] {
            const std::vector<seaway_point> points = places(20);
            for (int i = 0; i < 20; ++i) {
                if (t == 0)
                    poll(client, 0.01);
                else if (t == 1)
                    EXPECT_EQ(client.sample(points).size(), 20u);
                else
                    EXPECT_EQ(client.query(points).size(), 20u);
                ++answered;
            }
        });
    for (std::thread& caller : callers)
        caller.join();
    EXPECT_EQ(answered, 80);
}

TEST_F(Threadless, ends_as_others_do) {
    seaway_connect_options once = options();
    once.stays_lost = 1;
    Sea client(net->url(), once);
    net->stop();
    ASSERT_TRUE(in_frames(client, [&] { return !client.is_connected(); }));
    EXPECT_EQ(client.status().state, static_cast<std::uint32_t>(SEAWAY_STOPPED));
    EXPECT_NE(std::string(client.status().reason).find("stops"), std::string::npos)
        << client.status().reason;
    EXPECT_GT(client.retry_after_s(), 0);
    while (poll(client).kind != SEAWAY_NOTHING)
        ;
    EXPECT_EQ(poll(client, 0.05).kind, static_cast<std::uint32_t>(SEAWAY_NOTHING));
}

TEST_F(Threadless, that_finds_no_server_says_why) {
    seaway_client* client = nullptr;
    seaway_connect_options made = options();
    made.timeout_s = 0.3;
    EXPECT_NE(refusal(seaway_connect("ws://127.0.0.1:1", &made, &client), SEAWAY_CANNOT_CONNECT)
                  .find("cannot connect to ws://127.0.0.1:1: "),
              std::string::npos);
    FaultProxy silent(net->port());
    silent.stall(true);
    const std::string url = "ws://127.0.0.1:" + std::to_string(silent.port());
    EXPECT_NE(refusal(seaway_connect(url.c_str(), &made, &client), SEAWAY_CANNOT_CONNECT).find(url),
              std::string::npos);
    made.threadless = 2;
    EXPECT_NE(refusal(seaway_connect(url.c_str(), &made, &client))
                  .find("threadless is 2: it must be 0 or 1"),
              std::string::npos);
    EXPECT_EQ(client, nullptr);
}

} // namespace
} // namespace seaway
