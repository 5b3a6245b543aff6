// SPDX-License-Identifier: Apache-2.0
// Many sessions at once, and sessions that go in the middle of what they asked for.
#include <future>

#include <nlohmann/json.hpp>

#include "protocol/limits.h"
#include "tests/server/net/net_fixture.h"

namespace seaway::tests {
namespace {

using wire::Body;

class NetCrowd : public NetTest {};

TEST_F(NetCrowd, two_hundred_subscribers_of_mixed_qualities_start_at_once_and_each_gets_its_own) {
    constexpr std::size_t crowd = 200;
    host.answer_fetches = false; // all of them wait at the host, and come to the encoder in one go
    host.size = 128;
    options.idle_timeout = std::chrono::minutes(5); // who waits does not read: it answers no ping
    start();
    std::vector<std::unique_ptr<Client>> clients;
    for (std::size_t i = 0; i < crowd; ++i) {
        clients.push_back(greeted());
        const protocol::TileWish wish{
            .cascades = 1u, .fields = {sea::Field::height}, .error_m = SmallSea::bound(i % 2)};
        ASSERT_FALSE(clients.back()->send(protocol::subscribe(1, wish, 8)));
    }
    ASSERT_TRUE(eventually([&] { return metric("seaway_net_fetches_total") == crowd; }));
    for (const auto& answer : std::exchange(host.unanswered, {}))
        answer();
    for (const auto& client : clients) {
        ASSERT_TRUE(client->receive(Body::Subscribed));
        const wire::Message* message = client->receive();
        while (message && message->body_as_Tile())
            message = client->receive();
        ASSERT_TRUE(message && message->body_as_FetchDone()) << "nobody is refused what it needs";
    }
    EXPECT_EQ(metric("seaway_net_subscriptions"), crowd);
    for (const server::Quality quality : {0, 1})
        net->publish(host.keyframe(0, 9, {sea::Field::height}, quality));
    for (std::size_t i = 0; i < crowd; ++i) {
        const wire::Message* message = clients[i]->receive();
        ASSERT_TRUE(message && message->body_as_Tile()) << i;
        EXPECT_EQ(message->body_as_Tile()->time_us(), 9 * interval_us);
        EXPECT_EQ(message->body_as_Tile()->error(), codec_error * (i % 2 == 0 ? 1.0f : 8.0f));
    }
    clients.clear();
    EXPECT_TRUE(eventually([&] { return metric("seaway_net_subscriptions") == 0; }));
    EXPECT_TRUE(eventually([&] { return metric("seaway_net_sessions") == 0; }));
}

// Naive: the first 256 by number are listed, and whoever came later and does not read is seen nowhere.
TEST_F(NetCrowd, of_more_sessions_than_are_listed_those_furthest_behind_come_first) {
    constexpr std::size_t crowd = 258, listed_max = 256;
    options.admin_token_file = folder().write("crowd_admin", "master\n");
    options.idle_timeout = std::chrono::minutes(5); // they answer no ping
    start();
    const auto admin = greeted("master");
    std::vector<std::unique_ptr<Client>> clients;
    while (clients.size() + 1 < crowd)
        clients.push_back(greeted());
    // Of each the first keyframe takes its only credit; what comes after it waits, of the last one also of a second cascade.
    for (const std::uint32_t cascades : {1u, 3u}) {
        Client& client = *clients[cascades == 3 ? crowd - 2 : crowd - 3];
        const protocol::TileWish wish{.cascades = cascades, .fields = {sea::Field::height}};
        ASSERT_FALSE(client.send(protocol::subscribe(1, wish, 1)));
        ASSERT_TRUE(client.receive(Body::FetchDone));
    }
    net->publish(host.keyframe(0, 5, {sea::Field::height}));
    ASSERT_TRUE(clients[crowd - 3]->receive(Body::Tile));
    ASSERT_TRUE(clients[crowd - 2]->receive(Body::Tile));
    net->publish(host.keyframe(0, 6, {sea::Field::height}));
    net->publish(host.keyframe(1, 6, {sea::Field::height}));
    ASSERT_TRUE(
        eventually([&] { return metric("seaway_net_keyframes_awaiting_credit_total") == 3; }));
    ASSERT_FALSE(admin->send(protocol::administer(1, wire::Act::sessions, 0)));
    const wire::Message* told = admin->receive(Body::Administered);
    ASSERT_TRUE(told);
    const auto json =
        nlohmann::json::parse(told->body_as_Administered()->text()->string_view(), nullptr, false);
    EXPECT_EQ(json.at("sessions").get<std::size_t>(), crowd);
    const nlohmann::json& listed = json.at("listed");
    ASSERT_EQ(listed.size(), listed_max);
    const auto number = [&](std::size_t i) { return listed[i].at("session").get<std::size_t>(); };
    const auto bytes = [&](std::size_t i) {
        return listed[i].at("bytes_waiting").get<std::size_t>();
    };
    EXPECT_EQ(number(0), crowd) << "the last who came";
    EXPECT_EQ(number(1), crowd - 1);
    EXPECT_GT(bytes(0), bytes(1));
    EXPECT_GT(bytes(1), 0u);
    for (std::size_t i = 2; i < listed_max; ++i)
        EXPECT_EQ(number(i), i - 1) << "of equals by number";
    EXPECT_EQ(json.at("bytes_waiting").get<std::size_t>(), bytes(0) + bytes(1));
}

TEST_F(NetCrowd, upgrades_under_way_count_as_sessions) {
    options.sessions_max = 4;
    options.hello_deadline = std::chrono::minutes(5); // nobody says hello here, and nobody goes
    start();
    // The requests come in one go, so that several upgrades are under way before the first is over.
    constexpr int crowd = 24;
    const std::string_view request =
        "GET /v1/stream HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\n"
        "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
        "Sec-WebSocket-Protocol: seaway.v1\r\n\r\n";
    std::vector<std::unique_ptr<RawPeer>> peers;
    for (int i = 0; i < crowd; ++i)
        peers.push_back(std::make_unique<RawPeer>(port()));
    ASSERT_TRUE(eventually([&] { return metric("seaway_net_connections") == crowd + 1; }));
    std::promise<void> held;
    std::promise<void> go_on;
    host.on_state = [&] {
        held.set_value();
        go_on.get_future().wait();
    };
    std::thread holds([&] { get("/v1/state"); }); // the io thread
    held.get_future().wait();
    for (const auto& peer : peers)
        peer->say(request);
    go_on.set_value();
    holds.join();
    int upgraded = 0;
    for (const auto& peer : peers)
        upgraded += peer->header().starts_with("HTTP/1.1 101");
    EXPECT_EQ(upgraded, options.sessions_max);
}

TEST_F(NetCrowd, who_goes_in_the_middle_of_a_question_is_known_to_have_gone_and_leaves_no_trace) {
    host.answer_queries = false;
    host.answer_fetches = false;
    start();
    {
        const auto client = greeted();
        const sea::QueryPoint point{1, 2, 3};
        const sea::TimeUs time_us = 0;
        ASSERT_FALSE(client->send(protocol::subscribe(1, heights, 2)));
        ASSERT_FALSE(client->send(protocol::query(2, {&point, 1}, false)));
        ASSERT_FALSE(client->send(protocol::fetch(3, {&time_us, 1}, heights)));
        ASSERT_TRUE(eventually([&] { return metric("seaway_net_queries_total") == 1; }));
        ASSERT_TRUE(eventually([&] { return metric("seaway_net_fetches_total") == 2; }));
        for (const server::Asker& asker : host.askers)
            EXPECT_FALSE(asker.gone());
    }
    ASSERT_TRUE(eventually([&] { return metric("seaway_net_sessions") == 0; }));
    EXPECT_EQ(host.askers.size(), 3u);
    for (const server::Asker& asker : host.askers)
        EXPECT_TRUE(asker.gone());
    EXPECT_EQ(metric("seaway_net_subscriptions"), 0);
    for (const auto& answer : std::exchange(host.unanswered, {}))
        answer(); // too late, for nobody
    const auto other = greeted();
    ASSERT_FALSE(other->send(protocol::ping(1, 1)));
    EXPECT_TRUE(other->receive(Body::Pong));
}

TEST_F(NetCrowd, maps_however_they_end_leave_no_connection_behind) {
    host.maps_ready = true;
    start();
    for (int i = 0; i < 3; ++i) {
        HttpAnswer map; // one whose reader has gone holds its place until that is known
        ASSERT_TRUE(eventually([&] { return (map = get("/v1/map")).status != 503; }));
        EXPECT_EQ(map.status, 200);
        EXPECT_EQ(map.body.size(), SmallSea::map_chunks * SmallSea::map_chunk_bytes);
        EXPECT_EQ(get("/v1/map", "HEAD").status, 200) << "before a row of it is made";
        RawPeer leaves(port());
        leaves.say("GET /v1/map HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
        leaves.reset();
    }
    EXPECT_TRUE(eventually([&] { return metric("seaway_net_connections") == 1; }))
        << "the one that asks";
    EXPECT_TRUE(eventually([&] { return *host.maps_alive == 0; }));
}

TEST_F(NetCrowd, a_map_that_is_never_ready_is_let_go_when_the_server_stops) {
    start();
    RawPeer peer(port());
    peer.say("GET /v1/map HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
    EXPECT_TRUE(peer.header().starts_with("HTTP/1.1 200"));
    EXPECT_EQ(*host.maps_alive, 1);
    net.reset();
    EXPECT_EQ(*host.maps_alive, 0);
}

} // namespace
} // namespace seaway::tests
