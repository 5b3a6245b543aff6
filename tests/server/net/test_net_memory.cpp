// SPDX-License-Identifier: Apache-2.0
// What all sessions together may have the server hold: the rest waits, is refused, or goes.
#include <algorithm>
#include <random>

#include "tests/server/net/net_fixture.h"

namespace seaway::tests {
namespace {

using wire::Body;
using wire::ErrorCode;

class NetMemory : public NetTest {};

// Naive: a bound for each session alone: 64 that fetch and read nothing hold 2 GB.
TEST_F(NetMemory, fetched_tiles_that_nobody_reads_have_one_bound_for_all_sessions) {
    start();
    const std::shared_ptr<server::Room>& room = host.memory()->room(server::MemoryUse::fetched);
    const server::Room::Place unread = room->take(room->bytes_max()); // by others
    const auto client = greeted();
    const sea::TimeUs time_us = 3;
    for (std::uint32_t id = 1; id <= 3; ++id) {
        ASSERT_FALSE(client->send(protocol::fetch(id, {&time_us, 1}, heights)));
        const wire::Message* refused = client->receive(Body::Refused);
        ASSERT_TRUE(refused);
        EXPECT_EQ(refused->body_as_Refused()->code(), ErrorCode::too_many_requests);
        EXPECT_GT(refused->body_as_Refused()->retry_after_ms(), 0u);
    }
    ASSERT_FALSE(client->send(protocol::subscribe(4, heights, 1)));
    EXPECT_TRUE(client->receive(Body::FetchDone)) << "a subscription begins all the same";
}

// Naive: told to ask again, one that can never be served does, and each time most of its work is done.
TEST_F(NetMemory, a_fetch_that_is_more_than_all_of_that_alone_is_too_large) {
    host.holds(0); // one keyframe always finds room, a second one does not
    start();
    const auto client = greeted();
    const sea::TimeUs time_us = 3;
    ASSERT_FALSE(client->send(protocol::fetch(1, {&time_us, 1}, heights)));
    expect_refused(*client, 1, ErrorCode::too_large, "fetch fewer times or fields");
}

// Naive: its tiles are remembered until the stream has gone on, which there is none of.
TEST_F(NetMemory, what_was_encoded_for_a_fetch_goes_when_nobody_asks_for_it_again) {
    start();
    const auto client = greeted();
    const sea::TimeUs time_us = 5;
    ASSERT_FALSE(client->send(protocol::fetch(1, {&time_us, 1}, heights)));
    ASSERT_TRUE(client->receive(Body::FetchDone));
    EXPECT_GT(metric("seaway_net_fields_encoded_total"), 0);
    EXPECT_TRUE(
        eventually([&] { return metric("seaway_memory_held_bytes{of=\"encoded\"}") == 0; }));
}

// Naive: each session may leave a megabyte of replies unread: a thousand of them fill the machine.
TEST_F(NetMemory, answers_that_nobody_has_read_have_one_bound_for_all_sessions) {
    host.answer_queries = false; // under way, they have their room already
    host.holds(0);               // one always finds room, a second one only where it is small
    start();
    const auto crowd = greeted();
    const std::vector<sea::QueryPoint> many(4096);
    ASSERT_FALSE(crowd->send(protocol::query(1, many, false)));
    ASSERT_FALSE(crowd->send(protocol::query(2, many, false)));
    expect_refused(*crowd, 2, ErrorCode::too_many_requests, "answers that nobody has read");
    const auto other = greeted();
    ASSERT_FALSE(other->send(protocol::query(1, many, false)));
    expect_refused(*other, 1, ErrorCode::too_many_requests, "answers that nobody has read");
    host.answer_queries = true;
    const std::vector<sea::QueryPoint> few(16);
    ASSERT_FALSE(other->send(protocol::query(2, few, false)));
    EXPECT_TRUE(other->receive(Body::QueryReply)) << "some points are answered, whoever floods";
    while (!host.unanswered.empty()) {
        host.unanswered.back()();
        host.unanswered.pop_back();
    }
    EXPECT_TRUE(crowd->receive(Body::QueryReply));
    ASSERT_TRUE(eventually([&] { return metric("seaway_memory_held_bytes{of=\"replies\"}") == 0; }))
        << "what has been sent is not held";
    ASSERT_FALSE(other->send(protocol::query(3, many, false)));
    EXPECT_TRUE(other->receive(Body::QueryReply));
}

// Naive: each session that does not read holds the keyframe that it was being sent, another one each.
TEST_F(NetMemory, who_is_furthest_behind_goes_where_tiles_of_the_stream_fill_their_memory) {
    host.holds(64u * 1024 * 1024); // 4 MiB of them
    options.write_timeout = std::chrono::minutes(5);
    start();
    const std::string closed = "seaway_net_sessions_closed_total{reason=\"too_slow\"}";
    std::vector<std::unique_ptr<RawPeer>> readers_of_nothing;
    std::minstd_rand random;
    std::int64_t n = 10;
    for (; metric(closed) < 1 && readers_of_nothing.size() < 100; ++n) {
        RawPeer& peer = *readers_of_nothing.emplace_back(std::make_unique<RawPeer>(port(), 4096));
        peer.upgrade();
        peer.frame(protocol::hello("test", ""));
        peer.frame(protocol::subscribe(1, heights, 8));
        const auto subscribed = static_cast<double>(readers_of_nothing.size());
        // What was published last may still be on its way, and have somebody go before this one is counted.
        ASSERT_TRUE(eventually([&] {
            return metric("seaway_net_subscriptions") == subscribed || metric(closed) >= 1;
        }));
        auto noise = std::make_shared<sea::Keyframe>(*host.keyframe(0, n, heights.fields).keyframe);
        noise->size = 256;
        noise->values.resize(256 * 256);
        std::ranges::generate(noise->values, [&random] { return static_cast<float>(random()); });
        net->publish({.keyframe = noise, .codec_error = {0.0f}}); // a tile of 256 KB
        ASSERT_TRUE(eventually(
            [&] { return metric("seaway_net_keyframes_published_total") == subscribed; }));
    }
    EXPECT_LT(readers_of_nothing.size(), 100u);
    EXPECT_TRUE(eventually([&] {
        return metric("seaway_memory_held_bytes{of=\"streamed\"}") <=
               metric("seaway_memory_share_bytes{of=\"streamed\"}");
    })) << "what is being sent to who does not read is held, too";
    EXPECT_GT(metric("seaway_net_sessions"), 1) << "those who came later stay";
    const auto healthy = greeted();
    ASSERT_FALSE(healthy->send(protocol::subscribe(1, heights, 8)));
    EXPECT_TRUE(healthy->receive(Body::FetchDone));
}

} // namespace
} // namespace seaway::tests
