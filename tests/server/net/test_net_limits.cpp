// SPDX-License-Identifier: Apache-2.0
// Limits of the server and who may come in, each seen at its edge: what is within is served, one
// more is refused by name, and what was refused can be had later.
#include "tests/server/net/net_fixture.h"

#include <cmath>
#include <fstream>

#include "protocol/limits.h"
#include "server/net/refusals.h"

namespace seaway::tests {
namespace {

using wire::Body;
using wire::ErrorCode;
namespace limits = protocol::limits;

class NetLimits : public NetTest {};

TEST_F(NetLimits, fetches_in_flight_are_limited_a_session_and_places_come_back) {
    host.answer_fetches = false;
    start();
    const auto client = greeted();
    const auto other = greeted();
    const sea::TimeUs time_us = 0;
    std::uint32_t id = 0;
    for (int i = 0; i < limits::fetches_in_flight_max; ++i)
        ASSERT_FALSE(client->send(protocol::fetch(++id, {&time_us, 1}, heights)));
    // Neither a fetch nor the start of a subscription, which is one.
    ASSERT_FALSE(client->send(protocol::fetch(++id, {&time_us, 1}, heights)));
    expect_refused(*client, id, ErrorCode::too_many_requests, "earlier fetches");
    ASSERT_FALSE(client->send(protocol::subscribe(++id, heights, 2)));
    expect_refused(*client, id, ErrorCode::too_many_requests, "earlier fetches");
    ASSERT_FALSE(other->send(protocol::fetch(7, {&time_us, 1}, heights)));
    ASSERT_TRUE(eventually([&] { return metric("seaway_net_fetches_total") == 3; }))
        << "another session has places of its own";

    for (const auto& answer : std::exchange(host.unanswered, {}))
        answer();
    ASSERT_TRUE(other->receive(Body::FetchDone));
    for (int i = 0; i < limits::fetches_in_flight_max; ++i)
        ASSERT_TRUE(client->receive(Body::FetchDone));
    host.answer_fetches = true;
    for (int i = 0; i < 3; ++i) { // one after the other, without end
        ASSERT_FALSE(client->send(protocol::fetch(++id, {&time_us, 1}, heights)));
        const wire::Message* done = client->receive(Body::FetchDone);
        ASSERT_TRUE(done);
        EXPECT_EQ(done->body_as_FetchDone()->request_id(), id);
    }
}

// Naive: the place is given back behind the way out that a refusal takes.
TEST_F(NetLimits, what_the_sea_refuses_gives_its_place_back) {
    host.is_busy = true;
    start();
    const auto client = greeted();
    const sea::QueryPoint point{.x_m = 1, .y_m = 2, .time_us = 3};
    std::uint32_t id = 0;
    for (int i = 0; i < 2 * limits::queries_in_flight_max; ++i) {
        ASSERT_FALSE(client->send(protocol::query(++id, {&point, 1}, false)));
        expect_refused(*client, id, ErrorCode::too_many_requests, "later");
        ASSERT_FALSE(client->send(protocol::fetch(++id, {&point.time_us, 1}, heights)));
        expect_refused(*client, id, ErrorCode::too_many_requests, "later");
    }
    host.is_busy = false;
    ASSERT_FALSE(client->send(protocol::query(++id, {&point, 1}, false)));
    EXPECT_TRUE(client->receive(Body::QueryReply));
    ASSERT_FALSE(client->send(protocol::fetch(++id, {&point.time_us, 1}, heights)));
    EXPECT_TRUE(client->receive(Body::FetchDone));
}

TEST_F(NetLimits, places_out_of_range_and_times_out_of_range_are_refused_by_name) {
    start();
    const auto client = greeted();
    const auto ask = [&](std::uint32_t id, const sea::QueryPoint& point) {
        const sea::QueryPoint points[] = {{1, 2, 3}, point};
        ASSERT_FALSE(client->send(protocol::query(id, points, false)));
    };
    const sea::TimeUs beyond_us = std::numeric_limits<sea::TimeUs>::max();
    ask(1, {0, 0, beyond_us});
    expect_refused(*client, 1, ErrorCode::bad_value, "points.time_us [1] is 9223372036854775807");
    ask(2, {-1e300, 0, 0});
    expect_refused(*client, 2, ErrorCode::bad_value, "points.x_m [1] is -1e+300");
    ask(3, {0, 1.5e9, 0});
    expect_refused(*client, 3, ErrorCode::bad_value, "points.y_m [1] is 1500000000");
    const sea::TimeUs times[] = {0, -limits::time_us_max - 1};
    ASSERT_FALSE(client->send(protocol::fetch(4, times, heights)));
    expect_refused(*client, 4, ErrorCode::bad_value, "times_us [1] is -1000000000000000001");
    ask(5, {limits::position_m_max, -limits::position_m_max, -limits::time_us_max});
    EXPECT_TRUE(client->receive(Body::QueryReply)) << "the ends belong to the range";
}

TEST_F(NetLimits, keyframes_that_the_encoder_has_no_room_for_are_dropped_and_counted) {
    host.size = 256; // some milliseconds each: the encoder falls behind at once
    start();
    const auto client = greeted();
    ASSERT_FALSE(client->send(protocol::subscribe(1, heights, 2)));
    ASSERT_TRUE(client->receive(Body::FetchDone));
    const server::KeyframeTiles tiles = host.keyframe(0, 9, {sea::Field::height});
    constexpr int published = 400;
    for (int i = 0; i < published; ++i) {
        auto next = std::make_shared<sea::Keyframe>(*tiles.keyframe);
        next->time_us = (10 + i) * interval_us;
        net->publish({.keyframe = next, .codec_error = tiles.codec_error});
    }
    ASSERT_TRUE(eventually([&] {
        return metric("seaway_net_keyframes_published_total") +
                   metric("seaway_net_keyframes_dropped_total") ==
               published;
    }));
    EXPECT_GE(metric("seaway_net_keyframes_published_total"),
              std::floor(metric("seaway_memory_share_bytes{of=\"encoding\"}") /
                         static_cast<double>(tiles.keyframe->bytes())))
        << "what had room was sent on";
}

TEST_F(NetLimits, half_a_request_is_waited_for_until_the_deadline_and_whole_ones_are_served) {
    options.http_deadline =
        std::chrono::seconds(4); // for all of a request in three parts, on a busy machine
    start();
    RawPeer halves(port());
    for (const std::string_view part :
         {"GET /heal", "thz HTTP/1.1\r\nHost: 127.0.0.1\r\n", "\r\n"}) {
        halves.say(part);
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    const std::string answer = halves.header();
    EXPECT_NE(answer.find("200 OK"), std::string::npos) << answer;

    RawPeer half(port());
    half.say("GET /healthz HTTP/1.1\r\nHost:");
    ASSERT_TRUE(eventually([&] { return metric("seaway_net_connections") == 1; }))
        << "the one that asks: both others are closed";
    EXPECT_EQ(half.rest(), "") << "no answer to half a question";
    EXPECT_TRUE(half.ended_in_order());
}

TEST_F(NetLimits, connections_up_to_the_limit_are_taken_and_one_more_is_closed_at_once) {
    options.connections_max = 2;
    options.hello_deadline = std::chrono::minutes(5); // who says nothing stays for that long
    start();
    // Sessions: what has not sent a whole request would make room for the newcomer.
    auto first = std::make_unique<RawPeer>(port());
    first->upgrade();
    RawPeer second(port());
    second.upgrade();
    RawPeer one_more(port());
    const std::string busy = one_more.rest();
    EXPECT_TRUE(busy.starts_with("HTTP/1.1 503")) << "busy, not broken: " << busy;
    EXPECT_NE(busy.find("\r\nRetry-After: 1\r\n"), std::string::npos) << busy;
    const std::size_t body = busy.find("\r\n\r\n") + 4;
    EXPECT_NE(busy.find(fmt::format("Content-Length: {}\r\n", busy.size() - body)),
              std::string::npos);
    first->reset();
    std::string page;
    ASSERT_TRUE(eventually([&] {
        RawPeer asks(port());
        asks.say("GET /metrics HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n");
        page = asks.rest();
        return page.starts_with("HTTP/1.1 200");
    })) << "a place that came back";
    EXPECT_NE(page.find("\nseaway_net_connections_accepted_total 3\n"), std::string::npos)
        << "the first, the second and the one that asks:\n"
        << page;
}

// What went over the wire, counted on the other side of it.
TEST_F(NetLimits, bytes_and_messages_are_counted_each_way) {
    start();
    Client client(port());
    ASSERT_FALSE(client.connect());
    const protocol::Bytes asked[] = {protocol::hello("counts", ""), protocol::ping(1, 2),
                                     protocol::ping(2, 3), protocol::ping(3, 4)};
    double asked_bytes = 0;
    for (const protocol::Bytes& message : asked) {
        ASSERT_FALSE(client.send(message));
        asked_bytes += static_cast<double>(message.size());
    }
    const double answered_bytes = static_cast<double>(
        protocol::welcome(1, "seaway " SEAWAY_VERSION, 0).size() +
        SmallSea::state_message(0)->size() + 3 * protocol::pong(1, 2, 0).size());
    for (const wire::Body kind : {wire::Body::Welcome, wire::Body::SeaState, wire::Body::Pong,
                                  wire::Body::Pong, wire::Body::Pong})
        ASSERT_TRUE(client.receive(kind));
    EXPECT_EQ(metric("seaway_net_messages_received_total"), 4);
    EXPECT_EQ(metric("seaway_net_received_bytes_total"), asked_bytes);
    EXPECT_EQ(metric("seaway_net_messages_sent_total"), 5);
    EXPECT_EQ(metric("seaway_net_sent_bytes_total"), answered_bytes);
}

TEST(Refusals, each_kind_has_its_wire_code_and_its_status) {
    using server::Refusal;
    const auto is = [](const Error& error, ErrorCode code, unsigned status) {
        EXPECT_EQ(server::wire_code(error), code) << error.message;
        EXPECT_EQ(server::http_status(error), status) << error.message;
    };
    is({Refusal::bad_value, "range"}, ErrorCode::bad_value, 400);
    is({Refusal::not_offered, "none of it"}, ErrorCode::not_offered, 404);
    is({Refusal::busy, "later"}, ErrorCode::too_many_requests, 503);
    is({Refusal::gone, "never"}, ErrorCode::internal, 500);
    is({ErrorCode::too_many_points, "the protocol's own"}, ErrorCode::too_many_points, 500);
    is({"of no kind"}, ErrorCode::internal, 500);
}

TEST_F(NetLimits, subscribers_of_different_quality_get_each_keyframe_once_in_their_own) {
    start();
    const protocol::TileWish wishes[] = {
        {.cascades = 1u, .fields = {sea::Field::height}, .error_m = SmallSea::bound(0)},
        {.cascades = 1u, .fields = {sea::Field::height}, .error_m = SmallSea::bound(1)}};
    std::unique_ptr<Client> clients[2];
    for (std::size_t i = 0; i < 2; ++i) {
        clients[i] = greeted();
        ASSERT_FALSE(clients[i]->send(protocol::subscribe(1, wishes[i], 8)));
        const wire::Message* grant = clients[i]->receive(Body::Subscribed);
        ASSERT_TRUE(grant);
        EXPECT_EQ(grant->body_as_Subscribed()->error_m(), wishes[i].error_m);
        const wire::Message* message = clients[i]->receive();
        while (message && message->body_as_Tile()) { // what it needs now, in its quality too
            EXPECT_LE(message->body_as_Tile()->error(), codec_error * (i == 0 ? 1.0f : 8.0f));
            EXPECT_GT(message->body_as_Tile()->error(), codec_error * (i == 0 ? 0.5f : 4.0f));
            message = clients[i]->receive();
        }
        ASSERT_TRUE(message && message->body_as_FetchDone());
    }
    std::set<std::uint64_t> numbers;
    for (std::int64_t n = 10; n < 16; ++n) {
        for (const server::Quality quality : {0, 1})
            net->publish(host.keyframe(0, n, {sea::Field::height}, quality));
        for (std::size_t i = 0; i < 2; ++i) {
            const wire::Message* message = clients[i]->receive();
            ASSERT_TRUE(message && message->body_as_Tile());
            const wire::Tile& tile = *message->body_as_Tile();
            EXPECT_EQ(tile.time_us(), n * interval_us) << "each once, in order";
            EXPECT_EQ(tile.error(), codec_error * (i == 0 ? 1.0f : 8.0f));
            EXPECT_TRUE(numbers.insert(tile.keyframe()).second);
            ASSERT_FALSE(clients[i]->send(protocol::ack(tile.keyframe())));
        }
    }
    for (const auto& client : clients) {
        ASSERT_FALSE(client->send(protocol::ping(99, 1)));
        const wire::Message* message = client->receive();
        ASSERT_TRUE(message && message->body_as_Pong()) << "nothing of the other quality follows";
    }
}

// ---- who may come in -------------------------------------------------------------------------

class NetTokens : public NetLimits {
  protected:
    std::string file(const std::string& name, const std::string& text) {
        return folder().write("limits_" + name, text);
    }
    /// 0: came in; else the code of the close.
    unsigned knock(std::string_view token) {
        Client client(port());
        EXPECT_FALSE(client.connect());
        return client.greet(token) ? 0u : client.close_code();
    }
};

TEST_F(NetTokens, a_client_token_alone_lets_in_nobody_without_it_and_makes_nobody_administrator) {
    options.client_token_file = file("client", "open sesame\n");
    start();
    const unsigned unauthorised = protocol::close_code(ErrorCode::unauthorised);
    for (const std::string_view wrong : {"", " ", "open", "open sesame ", "Open sesame", "master"})
        EXPECT_EQ(knock(wrong), unauthorised) << wrong;
    EXPECT_EQ(knock(std::string_view("\0open sesame", 12)), unauthorised);
    EXPECT_EQ(knock("open sesame"), 0u);
    net->stop();
    EXPECT_TRUE(log.lines_with("administrator=true").empty());
    EXPECT_EQ(log.lines_with("administrator=false").size(), 1u);
}

TEST_F(NetTokens, without_tokens_everybody_comes_in_and_nobody_is_administrator) {
    start();
    for (const std::string_view token : {"", "x", "open sesame"})
        EXPECT_EQ(knock(token), 0u) << token;
    net->stop();
    EXPECT_TRUE(log.lines_with("administrator=true").empty());
    EXPECT_EQ(log.lines_with("administrator=false").size(), 3u);
}

TEST_F(NetTokens, an_admin_token_alone_leaves_the_door_open_and_marks_who_brings_it) {
    options.admin_token_file = file("admin", "master\n");
    start();
    for (const std::string_view token : {"", "x", "master"})
        EXPECT_EQ(knock(token), 0u) << token;
    net->stop();
    EXPECT_EQ(log.lines_with("administrator=true").size(), 1u);
    EXPECT_EQ(log.lines_with("administrator=false").size(), 2u);
}

} // namespace
} // namespace seaway::tests
