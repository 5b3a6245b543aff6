// SPDX-License-Identifier: Apache-2.0
// What a client is subscribed to where keyframes are slow to come.
#include <chrono>
#include <future>
#include <mutex>
#include <thread>

#include <gtest/gtest.h>

#include "client/client.h"
#include "client/link/failure.h"
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

// It waits for its turn behind a fetch, and is said to the server after the end that was meant for it.
TEST(Unsubscribing, ends_what_has_not_been_asked_for_yet) {
    SlowTiles sea;
    const auto net = tests::serve(sea);
    const auto client = Client::connect({.url = net->url()});
    ASSERT_TRUE(client) << client.error().message;
    sea.held_back = true;
    auto held = std::async(std::launch::async, [&] {
        const sea::TimeUs time_us = 5'010'000;
        return (*client)->hold({&time_us, 1}, 60).has_value();
    });
    EXPECT_TRUE(eventually([&] { return sea.asked == 1; }));
    auto subscribed = std::async(std::launch::async, [&] {
        return (*client)->subscribe({.fields = sea::surface_fields}, 2, 60).has_value();
    });
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
    const auto client = Client::connect({.url = "ws://127.0.0.1:" + std::to_string(line.port())});
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

} // namespace
} // namespace seaway::client
