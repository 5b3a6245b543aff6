// SPDX-License-Identifier: Apache-2.0
// Many small messages of one peer: they are answered in turns with what others want, and together where they came together.
#include <future>
#include <thread>

#include "tests/server/net/net_fixture.h"
#include "tests/sockets/client_frames.h"

namespace seaway::tests {
namespace {

using wire::Body;

class NetFloods : public NetTest {};

// Counted, not timed: how many of a thousand Pings are answered before a question that lies there behind them. Naive: all that one
// read brings, more than 200.
TEST_F(NetFloods, who_pings_without_end_delays_others_by_a_few_answers) {
    start();
    RawPeer floods(port());
    floods.upgrade();
    floods.frame(protocol::hello("floods", ""));
    EXPECT_TRUE(eventually([&] { return metric("seaway_net_sessions") == 1; }));
    const auto asks = greeted();
    std::promise<void> stands, goes_on;
    host.on_state = [&] { // on the network's thread
        stands.set_value();
        goes_on.get_future().wait();
        host.times_told = 0;
    };
    int told_before = -1;
    host.on_query = [&] { told_before = host.times_told; };
    std::thread holds([&] { get("/v1/state"); });
    stands.get_future().wait();
    protocol::Bytes pings;
    constexpr int count = 1000;
    for (std::uint32_t id = 1; id <= count; ++id)
        sockets::append_client_frame(pings, protocol::ping(id, 0));
    floods.say(pings);
    EXPECT_FALSE(asks->send(protocol::query(1, std::vector<sea::QueryPoint>(1), false)));
    goes_on.set_value();
    const wire::Message* reply = asks->receive(Body::QueryReply);
    EXPECT_TRUE(reply);
    holds.join();
    // Sixteen of what the system says has come, and sixteen of what was left of it, once or, where the question comes a little
    // later than it was sent, a few times.
    EXPECT_GE(told_before, 0);
    EXPECT_LE(told_before, 100);
    EXPECT_TRUE(eventually([&] { return host.times_told >= count; })) << "none of them is lost";
}

// Naive: what is answered together is answered once the rest of a message has come, or never.
TEST_F(NetFloods, answers_are_not_held_back_for_a_message_of_which_a_part_has_come) {
    start();
    RawPeer peer(port());
    peer.upgrade();
    protocol::Bytes all;
    sockets::append_client_frame(all, protocol::hello("raw", ""));
    sockets::append_client_frame(all, protocol::ping(1, 0));
    sockets::append_client_frame(all, protocol::ping(2, 0));
    all.insert(all.end(), {0x82, 0xfe}); // the beginning of a long one
    peer.say(all);
    EXPECT_TRUE(eventually([&] { return metric("seaway_net_messages_sent_total") == 4; }))
        << "Welcome, SeaState and two Pongs";
}

// What was asked for before what ends the session is answered before the end is told.
TEST_F(NetFloods, what_was_asked_before_nonsense_of_the_same_arrival_is_answered) {
    start();
    RawPeer peer(port());
    peer.upgrade();
    protocol::Bytes all;
    sockets::append_client_frame(all, protocol::hello("raw", ""));
    sockets::append_client_frame(all, protocol::ping(1, 0));
    sockets::append_client_frame(all, protocol::Bytes{1, 2, 3});
    peer.say(all);
    EXPECT_TRUE(eventually([&] { return metric("seaway_net_messages_sent_total") == 4; }))
        << "Welcome, SeaState, Pong, GoAway";
}

} // namespace
} // namespace seaway::tests
