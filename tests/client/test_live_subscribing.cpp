// SPDX-License-Identifier: Apache-2.0
// What a client is subscribed to where keyframes are slow to come.
#include <chrono>
#include <future>
#include <mutex>
#include <thread>

#include <gtest/gtest.h>

#include "client/client.h"
#include "client/link/failure.h"
#include "client/seaway.hpp"
#include "client/seaway_engine.h"
#include "tests/client/slow_waves.h"
#include "tests/client/wave_server.h"
#include "tests/support/fault_proxy.h"

namespace seaway::client {
namespace {

using tests::eventually;
using tests::FaultProxy;

/// Keyframes come when the test lets them.
class SlowTiles : public tests::WaveSea {
  public:
    std::atomic<bool> held_back = false;
    std::atomic<int> asked = 0;

    void fetch(server::FetchRequest request, Fetched done) override {
        if (held_back) {
            const std::scoped_lock lock(mutex_);
            waiting_.emplace_back(std::move(request), std::move(done));
            ++asked;
            return;
        }
        WaveSea::fetch(std::move(request), std::move(done));
    }
    void let_go() {
        held_back = false;
        const std::scoped_lock lock(mutex_);
        for (auto& [request, done] : waiting_)
            WaveSea::fetch(std::move(request), std::move(done));
        waiting_.clear();
    }

  private:
    std::mutex mutex_;
    std::vector<std::pair<server::FetchRequest, Fetched>> waiting_;
};

// Naive: it is told as a refusal, and whoever comes back next waits as after a failure.
TEST(Unsubscribing, while_a_client_that_came_back_subscribes_again_is_no_failure) {
    tests::SlowWaves sea;
    const auto net = tests::serve(sea);
    FaultProxy line(net->port());
    const auto client =
        Client::connect({.url = "ws://127.0.0.1:" + std::to_string(line.port()), .timeout_s = 60});
    ASSERT_TRUE(client) << client.error().message;
    ASSERT_TRUE((*client)->subscribe_spectrum({}, 30));
    sea.held_back = true;
    sea.asked = 0;
    line.cut();
    EXPECT_TRUE(eventually([&] { return sea.asked == 1; })) << "it asks again";
    (*client)->unsubscribe_spectrum();
    EXPECT_TRUE(eventually([&] { return (*client)->status().state == LinkState::connected; }));
    EXPECT_EQ((*client)->status().reason.find("unsubscribed"), std::string::npos)
        << (*client)->status().reason;
    sea.held_back = false;
}

// It waits for its turn behind a fetch, and is said to the server after the end that was meant for it.
TEST(Unsubscribing, ends_what_has_not_been_asked_for_yet) {
    SlowTiles sea;
    const auto net = tests::serve(sea);
    const auto client = Client::connect({.url = net->url(), .timeout_s = 60});
    ASSERT_TRUE(client) << client.error().message;
    sea.held_back = true;
    auto held = std::async(std::launch::async, [&] {
        const sea::TimeUs time_us = 5'010'000;
        return (*client)->hold({&time_us, 1}, 60).has_value();
    });
    EXPECT_TRUE(eventually([&] { return sea.asked == 1; }));
    std::atomic<bool> begins = false;
    auto subscribed = std::async(std::launch::async, [&] {
        begins = true;
        return (*client)->subscribe({.fields = sea::surface_fields}, 2, 60).has_value();
    });
    EXPECT_TRUE(eventually([&] { return begins.load(); }));
    // Nothing outside shows that it waits: it is some microseconds away.
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    (*client)->unsubscribe();
    sea.let_go();
    EXPECT_TRUE(held.get());
    EXPECT_TRUE(subscribed.get());
    EXPECT_TRUE(eventually([&] { return sea.subscriptions().size() == 0; }));
    EXPECT_FALSE((*client)->grant());
}

// Naive: what took too long was not granted. It is, its tiles come, and after the next outage nobody asks for them.
TEST(Subscribing, what_began_too_late_is_asked_for_again_as_any_other) {
    SlowTiles sea;
    const auto net = tests::serve(sea);
    FaultProxy line(net->port());
    const auto client =
        Client::connect({.url = "ws://127.0.0.1:" + std::to_string(line.port()), .timeout_s = 60});
    ASSERT_TRUE(client) << client.error().message;
    sea.held_back = true;
    const auto late =
        (*client)->subscribe({.fields = sea::surface_fields, .error_m = 0.5f}, 2, 0.3);
    ASSERT_FALSE(late);
    ASSERT_TRUE(late.error().is(Failure::deadline)) << late.error().message;
    EXPECT_TRUE(eventually([&] { return (*client)->grant().has_value(); })) << "it had begun";
    sea.let_go();
    line.cut();
    EXPECT_TRUE(eventually([&] {
        const ClientStatus status = (*client)->status();
        return status.connections == 2 && status.state == LinkState::connected;
    }));
    EXPECT_TRUE(eventually([&] { return sea.subscriptions().size() == 1; }));
    EXPECT_EQ(sea.wished_error_m, 0.5f);
}

TEST(Subscribing, that_was_not_answered_in_time_may_begin_and_is_ended_as_any_other) {
    SlowTiles sea;
    const auto net = tests::serve(sea);
    Sea client(net->url());
    sea.held_back = true;
    seaway_subscription impatient{};
    impatient.timeout_s = 0.3;
    ASSERT_EQ(seaway_subscribe(client.handle(), &impatient), SEAWAY_DEADLINE);
    seaway_grant grant = SEAWAY_SIZED(seaway_grant);
    const auto granted = [&] { return seaway_get_grant(client.handle(), &grant); };
    EXPECT_TRUE(eventually([&] { return granted() == SEAWAY_OK; })) << "it has begun";
    sea.let_go();
    client.unsubscribe();
    EXPECT_TRUE(eventually([&] { return sea.subscriptions().size() == 0; }));
    EXPECT_EQ(granted(), SEAWAY_NOT_HELD);
}

/// It grants, and has no room for what a subscription begins with.
class FullOfKeyframes : public tests::WaveSea {
  public:
    void fetch(server::FetchRequest, Fetched done) override {
        done(Error{server::Refusal::busy, "no room for keyframes"});
    }
};

TEST(Subscribing, where_the_first_keyframes_are_refused_is_granted_and_holds_nothing_yet) {
    FullOfKeyframes sea;
    const auto net = tests::serve(sea);
    Sea client(net->url());
    client.subscribe();
    EXPECT_EQ(client.status().holds, 0u);
    const seaway_point here{0, 0, client.now_us()};
    seaway_answer water{};
    EXPECT_EQ(seaway_sample(client.handle(), &here, 1, &water), SEAWAY_NOT_HELD);
}

// Naive: who wants the long waves alone holds nothing for ever.
TEST(Subscribing, to_some_cascades_holds_the_present_when_these_do) {
    tests::WaveSea sea;
    const auto net = tests::serve(sea);
    Sea client(net->url());
    seaway_wish wish = SEAWAY_SIZED(seaway_wish);
    wish.cascades = 1;
    ASSERT_EQ(seaway_subscribe_to(client.handle(), &wish, nullptr), SEAWAY_OK)
        << seaway_last_error();
    const seaway_status some = client.status();
    EXPECT_EQ(some.holds, static_cast<std::uint32_t>(SEAWAY_HOLDS_TILES));
    EXPECT_LT(some.held_from_us, some.held_until_us);
    // Of what is held, and of nothing else, that is said.
    seaway_looking looking = SEAWAY_SIZED(seaway_looking);
    looking.cascades = 1;
    seaway_sampling how = SEAWAY_SIZED(seaway_sampling);
    how.looking = &looking;
    const seaway_point here{0, 0, some.held_from_us};
    seaway_answer water{};
    EXPECT_EQ(seaway_sample_as(client.handle(), &how, &here, 1, &water), SEAWAY_OK)
        << seaway_last_error();
    EXPECT_EQ(water.flags & SEAWAY_EXTRAPOLATED, 0u);
    client.unsubscribe();
    EXPECT_EQ(client.status().holds, 0u) << "all count where nothing is subscribed to";
}

} // namespace
} // namespace seaway::client
