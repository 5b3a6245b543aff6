// SPDX-License-Identifier: Apache-2.0
// A server that has no time for a request now, and a client that has: what takes several requests is not lost with one of them.
#include <future>
#include <mutex>
#include <set>

#include <gtest/gtest.h>

#include "client/client.h"
#include "client/link/failure.h"
#include "client/link/patience.h"
#include "server/host/refusal.h"
#include "tests/client/wave_server.h"

namespace seaway::client {
namespace {

/// Refuses every second request for as long as it is busy, and says for how long.
class BusySea : public tests::WaveSea {
  public:
    std::atomic<int> refuses = 0; ///< so many yet
    std::atomic<std::uint32_t> hint_ms = 60;
    std::atomic<int> refused = 0, too_soon = 0;
    std::atomic<bool> refuses_all = false;  ///< not every second one
    std::atomic<bool> refuses_once = false; ///< each batch when it comes first
    std::mutex mutex;
    std::vector<double> answered_x_m; ///< the first place of each batch

    void query(server::QueryBatch batch, Queried done) override {
        const double first_x_m = batch.points.at(0).x_m;
        {
            const std::scoped_lock lock(mutex);
            refuses_all = refuses_all || refuses_once;
            refuses += refuses_once && seen_x_m_.insert(first_x_m).second ? 1 : 0;
        }
        if (const std::optional<Error> why = busy())
            return done(*why);
        {
            const std::scoped_lock lock(mutex);
            answered_x_m.push_back(first_x_m);
        }
        WaveSea::query(std::move(batch), std::move(done));
    }
    Result<server::GrantedSpectrum> spectrum(const server::SpectrumRequest& request) override {
        if (const std::optional<Error> why = busy())
            return *why;
        return WaveSea::spectrum(request);
    }
    void fetch(server::FetchRequest request, Fetched done) override {
        if (const std::optional<Error> why = busy())
            return done(*why);
        WaveSea::fetch(std::move(request), std::move(done));
    }

  private:
    std::set<double> seen_x_m_;
    int requests_ = 0;
    bool begun_ = false; ///< nobody can have heard before that the first one was refused
    std::chrono::steady_clock::time_point said_;

    std::optional<Error> busy() {
        const std::scoped_lock lock(mutex);
        const auto now = std::chrono::steady_clock::now();
        if (begun_ && now < said_ + std::chrono::milliseconds(hint_ms))
            ++too_soon;
        if ((++requests_ % 2 == 0 && !refuses_all) || refuses == 0)
            return std::nullopt;
        --refuses;
        ++refused;
        begun_ = true;
        said_ = now;
        Error why{server::Refusal::busy, "later"};
        why.retry_after_ms = hint_ms;
        return why;
    }
};

class PatienceOf : public ::testing::TestWithParam<bool> {
  protected:
    BusySea sea;
    std::unique_ptr<server::NetServer> net = tests::serve(sea);

    std::unique_ptr<Client> connect() {
        auto client =
            Client::connect({.url = net->url(), .timeout_s = 60, .threadless = GetParam()});
        EXPECT_TRUE(client) << (client ? "" : client.error().message);
        return client ? std::move(*client) : nullptr;
    }
};

TEST_P(PatienceOf, who_asks_about_more_than_a_batch_loses_none_of_it_to_a_server_that_is_busy) {
    const auto client = connect();
    ASSERT_TRUE(client);
    const std::size_t batch = client->welcome().exact_points_per_query_max;
    std::vector<sea::QueryPoint> points;
    for (std::size_t i = 0; i < 9 * batch + 1; ++i)
        points.push_back({0.37 * static_cast<double>(i), 11, 1'500'000});
    sea.refuses = 5;
    const auto answers = client->ask(points, {.exact = true, .timeout_s = 60});
    ASSERT_TRUE(answers) << answers.error().message;
    EXPECT_EQ(sea.refused, 5);
    ASSERT_EQ(answers->size(), points.size());
    for (std::size_t i = 0; i < points.size(); i += batch / 3)
        EXPECT_NEAR((*answers)[i].height_m, sea.truth(points[i]).height_m, 1e-6) << i;
    EXPECT_NEAR(answers->back().height_m, sea.truth(points.back()).height_m, 1e-6);
}

// Naive: the one that was refused last comes first, and the oldest is refused until its patience ends.
TEST_P(PatienceOf, of_batches_that_were_refused_the_first_comes_again_first) {
    const auto client = connect();
    ASSERT_TRUE(client);
    const std::size_t batch = client->welcome().exact_points_per_query_max;
    std::vector<sea::QueryPoint> points;
    for (std::size_t i = 0; i < 4 * batch; ++i) // as many as are under way at once
        points.push_back({static_cast<double>(i), 0, 0});
    sea.refuses_once = true;
    ASSERT_TRUE(client->ask(points, {.exact = true, .timeout_s = 60}));
    EXPECT_EQ(sea.refused, 4);
    const auto b = static_cast<double>(batch);
    EXPECT_EQ(sea.answered_x_m, (std::vector<double>{0, b, 2 * b, 3 * b}));
}

// Naive: who rests hears of nothing, and waits a minute for a server that has gone.
TEST_P(PatienceOf, who_rests_hears_of_the_end_of_the_connection) {
    for (const bool fetches : {false, true}) {
        net = tests::serve(sea);
        const auto client = connect();
        ASSERT_TRUE(client);
        sea.refuses_all = true;
        sea.refuses = 1'000'000;
        sea.refused = 0;
        sea.hint_ms = 500'000;
        auto asked = std::async(std::launch::async, [&]() -> Result<void> {
            const sea::TimeUs time_us = 7'000'000;
            const sea::QueryPoint point{1, 2, 0};
            if (fetches)
                return client->hold({&time_us, 1}, 2000);
            const auto answers = client->ask({&point, 1}, {.timeout_s = 2000});
            return answers ? Result<void>() : answers.error();
        });
        ASSERT_TRUE(tests::eventually([&] { return sea.refused == 1; }));
        net.reset();
        ASSERT_EQ(asked.wait_for(std::chrono::seconds(100)), std::future_status::ready);
        const Result<void> end = asked.get();
        ASSERT_FALSE(end);
        EXPECT_EQ(failure_of(end.error()), Failure::lost) << end.error().message;
    }
}

TEST_P(PatienceOf, who_subscribes_to_waves_has_it_too_until_another_wish_comes) {
    const auto client = connect();
    ASSERT_TRUE(client);
    sea.refuses_all = true;
    sea.refuses = 2;
    const auto granted = client->subscribe_spectrum({}, 60);
    ASSERT_TRUE(granted) << granted.error().message;
    EXPECT_EQ(sea.refused, 2);
    EXPECT_EQ(sea.too_soon, 0);
    sea.hint_ms = 4000; // so long has the other thread, at least
    const int before = sea.refused;
    sea.refuses = 1;
    auto other = std::async(std::launch::async, [&] {
        EXPECT_TRUE(tests::eventually([&] { return sea.refused == before + 1; }));
        client->unsubscribe_spectrum();
    });
    const auto late = client->subscribe_spectrum({}, 60);
    other.wait();
    ASSERT_FALSE(late) << "nothing is wanted any more";
    EXPECT_EQ(failure_of(late.error()), Failure::refused);
}

TEST_P(PatienceOf, who_fetches_comes_again_no_sooner_than_the_server_said) {
    const auto client = connect();
    ASSERT_TRUE(client);
    sea.refuses = 2;
    for (const sea::TimeUs time_us : {3'000'000, 9'000'000}) {
        const auto held = client->hold({&time_us, 1}, 60);
        ASSERT_TRUE(held) << held.error().message;
        const sea::QueryPoint point{3, 4, time_us};
        const auto answers = client->sample({&point, 1});
        ASSERT_TRUE(answers);
        EXPECT_NEAR((*answers)[0].height_m, sea.truth(point).height_m, (*answers)[0].error_m);
    }
    EXPECT_EQ(sea.refused, 2);
    EXPECT_EQ(sea.too_soon, 0);
}

TEST_P(PatienceOf, who_has_no_more_of_it_is_told_what_the_server_said) {
    const auto client = connect();
    ASSERT_TRUE(client);
    sea.refuses = 1'000'000;
    sea.hint_ms = 120'000;
    const sea::QueryPoint point{1, 2, 0};
    const sea::TimeUs time_us = 7'000'000;
    const auto asked = client->ask({&point, 1}, {.timeout_s = 60});
    ASSERT_FALSE(asked);
    EXPECT_EQ(failure_of(asked.error()), Failure::refused);
    EXPECT_NE(asked.error().message.find("later"), std::string::npos) << asked.error().message;
    EXPECT_EQ(sea.refused, 1) << "to ask again would take longer than it has";
    sea.refuses = 0;
    ASSERT_TRUE(client->ask({&point, 1}, {.timeout_s = 60})) << "for which no time has to pass";
    sea.refuses = 1'000'000;
    const auto fetched = client->hold({&time_us, 1}, 60);
    ASSERT_FALSE(fetched);
    EXPECT_EQ(failure_of(fetched.error()), Failure::refused);
    EXPECT_EQ(sea.refused, 2);
}

INSTANTIATE_TEST_SUITE_P(Threads, PatienceOf, ::testing::Values(false, true),
                         [](const auto& tested) { return tested.param ? "none" : "its_own"; });

TEST(Patience, comes_again_by_lot_within_its_time_and_for_nothing_else) {
    Error busy = failed(Failure::refused, "later");
    EXPECT_FALSE(Patience(1000).again(busy)) << "nothing says that it would help";
    busy.retry_after_ms = 10'000;
    const auto now = Patience::Clock::now();
    const auto s = [&](const Patience& patience) {
        const auto at = patience.again(busy);
        return at ? std::chrono::duration<double>(*at - now).count() : -1;
    };
    double least_s = 1e9, most_s = 0;
    for (int i = 0; i < 100; ++i) {
        const double at_s = s(Patience(1000));
        least_s = std::min(least_s, at_s);
        most_s = std::max(most_s, at_s);
    }
    // A hundred lots between 10 and 20: none in the lowest or the highest third has odds of (2/3)^100, 2e-18.
    EXPECT_GE(least_s, 10);
    EXPECT_LT(least_s, 13.4);
    EXPECT_GT(most_s, 16.6);
    EXPECT_GE(s(Patience(15)), 10) << "sooner than by lot, where that is too late";
    EXPECT_LT(s(Patience(9)), 0);
    EXPECT_LT(s(Patience(10.1)), 0) << "no time would be left for an answer";
    for (const Failure other : {Failure::lost, Failure::deadline, Failure::too_large}) {
        busy.kind = other;
        EXPECT_FALSE(Patience(1000).again(busy));
    }
}

} // namespace
} // namespace seaway::client
