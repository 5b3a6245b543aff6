// SPDX-License-Identifier: Apache-2.0
// The client against the real net server on loopback, over a sea whose truth is known.
#include <cstdlib>
#include <random>
#include <thread>

#include <gtest/gtest.h>

#include "client/client.h"
#include "client/link/failure.h"
#include "tests/client/wave_server.h"

namespace seaway::client {
namespace {

using sea::Answer;
using sea::QueryPoint;
using tests::eventually;

/// Test `client_threadless` runs all of these with clients that make no thread, each with a loop that polls it.
struct Polled {
    std::shared_ptr<std::jthread> loop = {};
    void operator()(Client* client) {
        loop.reset();
        delete client;
    }
};

class Live : public tests::WaveServer {
  protected:
    std::unique_ptr<Client, Polled> connect(ClientEvents events = {}) {
        const bool threadless = std::getenv("SEAWAY_TEST_THREADLESS") != nullptr;
        auto made = Client::connect({.url = net->url(), .timeout_s = 60, .threadless = threadless},
                                    std::move(events));
        EXPECT_TRUE(made) << made.error().message;
        std::unique_ptr<Client, Polled> client(made ? made->release() : nullptr);
        if (client && threadless)
            client.get_deleter().loop = std::make_shared<std::jthread>(
                [client = client.get()](const std::stop_token& stop) {
                    while (!stop.stop_requested())
                        client->work_until(std::chrono::steady_clock::now() +
                                               std::chrono::milliseconds(2),
                                           [] { return false; });
                });
        return client;
    }

    /// Random places within 100 km, at a few times from before the epoch to years after it.
    std::vector<QueryPoint> points(int count) {
        std::mt19937_64 random(5);
        std::uniform_real_distribution<double> place(-1e5, 1e5);
        std::uniform_int_distribution<sea::TimeUs> time(-1'000'000'000'000, 100'000'000'000'000);
        std::vector<sea::TimeUs> times;
        for (int i = 0; i < 20; ++i)
            times.push_back(time(random));
        std::vector<QueryPoint> made;
        for (int i = 0; i < count; ++i)
            made.push_back(
                {place(random), place(random), times[static_cast<std::size_t>(i) % times.size()]});
        return made;
    }
};

TEST_F(Live, server_answers_come_back_in_order_however_many_there_are) {
    const auto client = connect();
    ASSERT_TRUE(client);
    const std::vector<QueryPoint> asked = points(9000);
    const auto answers = client->ask(asked, {.timeout_s = 60});
    ASSERT_TRUE(answers) << answers.error().message;
    EXPECT_EQ(sea.queries, 3) << "4096 points a query";
    for (const std::size_t i : {0u, 1u, 4095u, 4096u, 8999u}) {
        const Answer truth = sea.truth(asked[i]);
        EXPECT_EQ((*answers)[i].height_m, truth.height_m);
        EXPECT_EQ((*answers)[i].flags, 0u);
    }
}

TEST_F(Live, exact_answers_are_asked_for_in_batches_the_server_takes) {
    const auto client = connect();
    ASSERT_TRUE(client);
    const auto answers = client->ask(points(600), {.exact = true, .timeout_s = 60});
    ASSERT_TRUE(answers) << answers.error().message;
    EXPECT_EQ(sea.queries, 3) << "256 points an exact query";
    EXPECT_EQ(answers->back().flags, static_cast<std::uint32_t>(sea::answer_exact));
}

TEST_F(Live, g8_no_points_is_an_answer_without_rows) {
    const auto client = connect();
    ASSERT_TRUE(client);
    const auto asked = client->ask({}, {});
    ASSERT_TRUE(asked);
    EXPECT_TRUE(asked->empty());
    EXPECT_TRUE(client->fetch_and_sample({}, 1)->empty());
}

TEST_F(Live, local_answers_hold_their_stated_bound_at_any_place_and_time) {
    const auto client = connect();
    ASSERT_TRUE(client);
    const std::vector<QueryPoint> asked = points(500);
    const auto answers = client->fetch_and_sample(asked, 30);
    ASSERT_TRUE(answers) << answers.error().message;
    for (std::size_t i = 0; i < asked.size(); ++i) {
        const Answer truth = sea.truth(asked[i]);
        const Answer& local = (*answers)[i];
        EXPECT_LE(std::abs(local.height_m - truth.height_m), local.error_m) << i;
        // Codec bounds of 0.5 mm and 5 mm/s in two cascades, 2.4 of spline gain each, displacement
        // times slope, and 0.4 mm of interpolation: some 7 mm.
        EXPECT_LT(local.error_m, 0.012);
        EXPECT_EQ(local.flags, 0u);
        // Slopes and velocities carry the codec's error over a grid spacing of 1 m, and its rate.
        for (int axis = 0; axis < 3; ++axis) {
            EXPECT_NEAR(local.normal[axis], truth.normal[axis], 0.01);
            EXPECT_NEAR(local.velocity_mps[axis], truth.velocity_mps[axis], 0.03);
        }
    }
}

TEST_F(Live, g8_equal_points_have_equal_answers_in_any_order) {
    const auto client = connect();
    ASSERT_TRUE(client);
    std::vector<QueryPoint> asked = points(50);
    const auto forward = client->fetch_and_sample(asked, 30);
    std::reverse(asked.begin(), asked.end());
    const auto backward = client->fetch_and_sample(asked, 30);
    ASSERT_TRUE(forward && backward);
    for (std::size_t i = 0; i < asked.size(); ++i)
        EXPECT_EQ((*forward)[i].height_m, (*backward)[asked.size() - 1 - i].height_m);
}

TEST_F(Live, g9_a_point_that_is_no_number_is_flagged) {
    const auto client = connect();
    ASSERT_TRUE(client);
    const QueryPoint point{std::nan(""), 0, 0};
    const auto local = client->fetch_and_sample({&point, 1}, 60);
    ASSERT_TRUE(local);
    EXPECT_TRUE((*local)[0].flags & sea::answer_invalid);
}

TEST_F(Live, what_is_held_is_not_fetched_again) {
    const auto client = connect();
    ASSERT_TRUE(client);
    const std::vector<sea::TimeUs> times{5'000'000, 5'010'000, 5'030'000};
    ASSERT_TRUE(client->hold(times, 60));
    EXPECT_EQ(sea.fetches, 1) << "all three lie between the same keyframes";
    ASSERT_TRUE(client->hold(times, 60));
    EXPECT_EQ(sea.fetches, 1);
}

TEST_F(Live, without_keyframes_nothing_can_be_sampled) {
    const auto client = connect();
    ASSERT_TRUE(client);
    const QueryPoint point{0, 0, 0};
    const auto local = client->sample({&point, 1});
    ASSERT_FALSE(local);
    EXPECT_EQ(failure_of(local.error()), Failure::not_held);
}

TEST_F(Live, g4_a_time_beyond_what_is_held_is_flagged_as_extrapolated) {
    const auto client = connect();
    ASSERT_TRUE(client);
    const sea::TimeUs time_us = 5'010'000;
    ASSERT_TRUE(client->hold({&time_us, 1}, 60));
    const QueryPoint points[] = {{0, 0, time_us}, {0, 0, time_us + 1'000'000}};
    const auto local = client->sample(points);
    ASSERT_TRUE(local);
    EXPECT_EQ((*local)[0].flags, 0u);
    EXPECT_EQ((*local)[1].flags, static_cast<std::uint32_t>(sea::answer_extrapolated));
}

// Naive: what was made for a time behind the last keyframe is taken for the time of that keyframe, too.
TEST_F(Live, g4_the_last_moment_that_is_held_is_that_whatever_was_asked_before) {
    for (const bool beyond_first : {true, false})
        for (const bool together : {true, false}) {
            const auto client = connect();
            ASSERT_TRUE(client);
            const sea::TimeUs time_us = 5'010'000;
            ASSERT_TRUE(client->hold({&time_us, 1}, 60));
            sea::TimeUs last_us = sea::time_us_max;
            for (const auto& cascade : client->sea_state(time_us)->cascades)
                last_us =
                    std::min(last_us, (time_us / cascade.interval_us + 1) * cascade.interval_us);
            std::vector<QueryPoint> points{{0, 0, last_us + 1000}, {0, 0, last_us}};
            if (!beyond_first)
                std::swap(points[0], points[1]);
            for (std::size_t i = 0; i < points.size(); i += together ? 2 : 1) {
                const auto some = std::span(points).subspan(i, together ? 2 : 1);
                const auto local = client->sample(some);
                ASSERT_TRUE(local);
                for (std::size_t n = 0; n < some.size(); ++n)
                    EXPECT_EQ((*local)[n].flags, some[n].time_us == last_us
                                                     ? 0u
                                                     : std::uint32_t{sea::answer_extrapolated})
                        << beyond_first << together;
            }
        }
}

TEST_F(Live, a_subscription_begins_with_the_present_and_moves_on) {
    std::atomic<sea::TimeUs> came_us = 0;
    const auto client = connect({.on_keyframe = [&](const HeldKeyframePtr& keyframe) {
        came_us = keyframe->keyframe().time_us;
    }});
    ASSERT_TRUE(client);
    const sea::TimeUs before_us = client->now_us();
    const auto grant = client->subscribe({.fields = sea::surface_fields}, 2, 60);
    ASSERT_TRUE(grant) << grant.error().message;
    EXPECT_EQ(grant->fields, sea::surface_fields);
    // Of the finer cascade two keyframes lie around the present of the subscription and two 0.2 s on. A busy
    // machine may take longer than that to come back.
    const HeldKeyframePtr last = client->ring().newest(1);
    ASSERT_TRUE(last);
    const QueryPoint now{1, 2, last->keyframe().time_us - 200'000};
    EXPECT_GT(now.time_us, before_us - 100'000);
    EXPECT_LT(now.time_us, client->now_us() + 200'000);
    const auto local = client->sample({&now, 1});
    ASSERT_TRUE(local) << local.error().message;
    EXPECT_EQ((*local)[0].flags, 0u);
    EXPECT_NEAR((*local)[0].height_m, sea.truth(now).height_m, (*local)[0].error_m);

    const std::int64_t later = 100'000; // keyframes, far from what is held
    for (std::int64_t n = later; n < later + 20; ++n)
        net->publish(sea.keyframe(1, n, sea::surface_fields));
    EXPECT_TRUE(eventually([&] { return came_us == (later + 19) * tests::wave_intervals_us[1]; }))
        << "the newest always arrives: what is skipped is older, and credit is given back";
}

TEST_F(Live, maps_that_are_not_offered_are_left_out_of_the_grant_and_of_sampling) {
    sea.offered = sea::FieldSet{sea::Field::height, sea::Field::height_rate};
    const auto client = connect();
    ASSERT_TRUE(client);
    const QueryPoint point{3, 4, 7'777'777};
    const auto local = client->fetch_and_sample({&point, 1}, 60);
    ASSERT_TRUE(local) << local.error().message;
    EXPECT_EQ((*local)[0].flags, sea::answer_vertical_velocity);
    const auto again = client->fetch_and_sample({&point, 1}, 60);
    ASSERT_TRUE(again);
    EXPECT_EQ(sea.fetches, 1) << "what is not offered is not waited for";

    sea.offered = sea::FieldSet{};
    const auto grant = client->subscribe({.fields = sea::surface_fields}, 2, 60);
    ASSERT_FALSE(grant);
    EXPECT_EQ(failure_of(grant.error()), Failure::refused);
}

TEST_F(Live, h1_the_clock_of_two_clients_agrees_with_the_sea) {
    const auto one = connect();
    const auto two = connect();
    ASSERT_TRUE(one && two);
    ASSERT_TRUE(eventually([&] { return one->clock().samples > 5 && two->clock().samples > 5; }));
    for (Client* client : {one.get(), two.get()}) {
        const sea::TimeUs before = sea.sea_time_us();
        const sea::TimeUs shown = client->now_us();
        const sea::TimeUs after = sea.sea_time_us();
        // The bound the clock states, and what it still slews from its first look.
        const ClockStatus status = client->clock();
        const double allowed = status.error_us + std::abs(status.slew_us) + 1;
        EXPECT_GE(static_cast<double>(shown - before), -allowed);
        EXPECT_LE(static_cast<double>(shown - after), allowed);
    }
}

TEST_F(Live, a_query_without_an_answer_passes_its_deadline_and_the_connection_goes_on) {
    const auto client = connect();
    ASSERT_TRUE(client);
    sea.answer_queries = false;
    const QueryPoint point{0, 0, 0};
    const auto late = client->ask({&point, 1}, {.timeout_s = 0.05});
    ASSERT_FALSE(late);
    EXPECT_EQ(failure_of(late.error()), Failure::deadline);
    sea.answer_queries = true;
    EXPECT_TRUE(client->ask({&point, 1}, {.timeout_s = 60}));
}

TEST_F(Live, a_server_that_stops_ends_the_connection_with_its_reason) {
    std::atomic<bool> closed = false;
    const auto client = connect({.on_closed = [&](const Error&) { closed = true; }});
    ASSERT_TRUE(client);
    const sea::TimeUs time_us = 5'010'000;
    ASSERT_TRUE(client->hold({&time_us, 1}, 60));
    net->stop();
    EXPECT_TRUE(eventually([&] { return closed.load(); }));
    EXPECT_FALSE(client->is_open());
    EXPECT_NE(client->closed_reason().find("shutting_down"), std::string::npos)
        << client->closed_reason();
    const QueryPoint point{0, 0, time_us};
    const auto lost = client->ask({&point, 1}, {});
    ASSERT_FALSE(lost);
    EXPECT_EQ(failure_of(lost.error()), Failure::lost);
    EXPECT_TRUE(client->sample({&point, 1})) << "what is held can still be sampled";
}

TEST_F(Live, many_threads_may_ask_and_sample_at_once) {
    const auto client = connect();
    ASSERT_TRUE(client);
    std::atomic<int> wrong = 0;
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&, t] {
            for (int i = 0; i < 5; ++i) {
                const QueryPoint point{1.0 * t, 1.0 * i, (t * 5 + i) * 50'000};
                const auto asked = client->ask({&point, 1}, {});
                const auto local = client->fetch_and_sample({&point, 1}, 60);
                wrong +=
                    !asked || !local ||
                    std::abs((*asked)[0].height_m - (*local)[0].height_m) > (*local)[0].error_m;
            }
        });
    for (std::thread& thread : threads)
        thread.join();
    EXPECT_EQ(wrong, 0);
}

TEST_F(Live, an_address_without_such_a_server_is_said_in_one_line) {
    const std::string http = net->url() + "/nowhere";
    const auto wrong_path = Client::connect({.url = http, .timeout_s = 60});
    ASSERT_FALSE(wrong_path);
    EXPECT_EQ(failure_of(wrong_path.error()), Failure::cannot_connect);
    EXPECT_NE(wrong_path.error().message.find("HTTP 404"), std::string::npos)
        << wrong_path.error().message;

    const std::string url = net->url();
    net->stop();
    const auto nobody = Client::connect({.url = url, .timeout_s = 60});
    ASSERT_FALSE(nobody);
    EXPECT_EQ(failure_of(nobody.error()), Failure::cannot_connect);
    EXPECT_NE(nobody.error().message.find("refused"), std::string::npos) << nobody.error().message;
}

} // namespace
} // namespace seaway::client
