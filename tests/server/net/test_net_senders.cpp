// SPDX-License-Identifier: Apache-2.0
// Several threads that send (--io-threads).
#include "server/net/senders.h"

#include <atomic>
#include <chrono>
#include <list>
#include <thread>

#include <gtest/gtest.h>

#include "tests/server/net/net_fixture.h"

namespace seaway::tests {
namespace {

/// Writes once somebody else writes, too, and says so; a minute at most.
class Together final : public server::Sending {
  public:
    Together(std::atomic<int>& of_all, bool has_something)
        : writing(of_all), something(has_something) {}
    bool take() noexcept override {
        taken_by = std::this_thread::get_id();
        return something;
    }
    void write() noexcept override {
        ++writing;
        met = eventually([this] { return writing >= 2; });
    }
    void written() noexcept override { ended_by = std::this_thread::get_id(); }

    std::atomic<int>& writing;
    const bool something;
    std::thread::id taken_by, ended_by;
    bool met = false;
};

TEST(Senders, writes_of_a_turn_go_side_by_side_and_all_else_is_done_by_the_caller) {
    server::Senders senders;
    senders.start(2);
    EXPECT_EQ(senders.threads(), 2);
    std::atomic<int> writing = 0;
    std::list<std::shared_ptr<Together>> all;
    for (int i = 0; i < 3; ++i)
        all.push_back(std::make_shared<Together>(writing, i < 2));
    EXPECT_FALSE(senders.later(all.front())) << "nothing is gathered now";
    senders.together([&] {
        for (const auto& one : all)
            EXPECT_TRUE(senders.later(one));
        EXPECT_EQ(writing, 0) << "not before all have been delivered to";
    });
    for (const auto& one : all) {
        EXPECT_EQ(one->met, one->something);
        EXPECT_EQ(one->taken_by, std::this_thread::get_id());
        EXPECT_EQ(one->ended_by, one->something ? std::this_thread::get_id() : std::thread::id());
        EXPECT_EQ(one.use_count(), 1) << "nobody is held beyond the turn";
    }
}

TEST(Senders, one_thread_alone_writes_at_once) {
    server::Senders senders;
    senders.start(1);
    std::atomic<int> writing = 2;
    senders.together(
        [&] { EXPECT_FALSE(senders.later(std::make_shared<Together>(writing, true))); });
}

TEST(Senders, what_was_gathered_before_an_exception_is_sent) {
    server::Senders senders;
    senders.start(2);
    std::atomic<int> writing = 2;
    const auto one = std::make_shared<Together>(writing, true);
    EXPECT_THROW(senders.together([&] {
        (void)senders.later(one);
        throw std::bad_alloc();
    }),
                 std::bad_alloc);
    EXPECT_TRUE(one->met);
}

class NetSenders : public NetTest {
  protected:
    std::unique_ptr<Client> subscribed() {
        auto client = greeted();
        EXPECT_FALSE(client->send(protocol::subscribe(1, heights, 8)));
        EXPECT_TRUE(client->receive(wire::Body::FetchDone));
        return client;
    }
    /// The next keyframe of the stream is this one.
    void expect_next(Client& client, std::int64_t n) {
        const wire::Message* message = client.receive(wire::Body::Tile);
        ASSERT_TRUE(message != nullptr) << client.error().message();
        EXPECT_EQ(message->body_as_Tile()->time_us(), n * interval_us);
        EXPECT_FALSE(client.send(protocol::ack(message->body_as_Tile()->keyframe())));
    }
};

// Through a file and without one: four subscribers have one.
TEST_F(NetSenders, everybody_is_sent_everything_in_order_whoever_leaves_comes_or_does_not_read) {
    options.io_threads = 4;
    start();
    std::list<std::unique_ptr<Client>> clients;
    for (int i = 0; i < 70; ++i) // two turns and more
        clients.push_back(subscribed());
    const auto deaf = subscribed();
    auto leaves = subscribed();
    for (std::int64_t n = 10; n < 30; ++n) {
        publish(n);
        if (n == 15)
            leaves.reset();
        for (const auto& client : clients)
            expect_next(*client, n);
        if (n == 20)
            clients.push_front(subscribed());
    }
    EXPECT_EQ(metric("seaway_net_sessions"), static_cast<double>(clients.size() + 1));
    net->stop();
    for (const auto& client : clients)
        EXPECT_EQ(client->close_code(), protocol::close_code(wire::ErrorCode::shutting_down));
}

} // namespace
} // namespace seaway::tests
