// SPDX-License-Identifier: Apache-2.0
// Sessions over real loopback sockets: what a well-behaved client sees.
#include "tests/server/net/net_fixture.h"

#include "protocol/limits.h"

namespace seaway::tests {
namespace {

using wire::Body;
using wire::ErrorCode;

class NetSession : public NetTest {};

TEST_F(NetSession, hello_is_answered_by_welcome_and_the_sea_state) {
    start();
    Client client(port());
    ASSERT_FALSE(client.connect());
    EXPECT_EQ(client.subprotocol(), "seaway.v1");
    ASSERT_FALSE(client.send(protocol::hello("test", "")));
    const wire::Message* message = client.receive();
    ASSERT_TRUE(message);
    const wire::Welcome* welcome = message->body_as_Welcome();
    ASSERT_TRUE(welcome);
    EXPECT_EQ(welcome->version(), 1);
    EXPECT_EQ(welcome->points_per_query_max(), protocol::limits::points_per_query_max);
    message = client.receive();
    ASSERT_TRUE(message);
    ASSERT_TRUE(message->body_as_SeaState());
    EXPECT_EQ(protocol::values(*message->body_as_SeaState()).cascades.size(), 2u);
}

TEST_F(NetSession, a_first_message_that_is_not_hello_ends_the_session) {
    start();
    Client client(port());
    ASSERT_FALSE(client.connect());
    ASSERT_FALSE(client.send(protocol::ping(1, 2)));
    const wire::Message* message = client.receive();
    ASSERT_TRUE(message && message->body_as_GoAway());
    EXPECT_EQ(message->body_as_GoAway()->code(), ErrorCode::hello_expected);
    EXPECT_EQ(client.close_code(), protocol::close_code(ErrorCode::hello_expected));
}

TEST_F(NetSession, no_hello_within_the_deadline_ends_the_session) {
    options.hello_deadline = std::chrono::milliseconds(50);
    start();
    Client client(port());
    ASSERT_FALSE(client.connect());
    EXPECT_EQ(client.close_code(), protocol::close_code(ErrorCode::hello_expected));
}

TEST_F(NetSession, versions_that_the_server_does_not_speak_end_the_session) {
    start();
    Client client(port());
    ASSERT_FALSE(client.connect());
    const std::uint16_t versions[] = {7, 9};
    ASSERT_FALSE(client.send(protocol::hello("test", "", versions)));
    EXPECT_EQ(client.close_code(), protocol::close_code(ErrorCode::unsupported_version));
}

TEST_F(NetSession, tokens_open_the_door_and_nothing_else_does) {
    options.client_token_file = folder().write("client.token", "  open sesame \nsecond line\n");
    options.admin_token_file = folder().write("admin.token", "master\n");
    start();
    for (const auto& [token, allowed] : std::map<std::string, bool>{
             {"", false}, {"open", false}, {"open sesame", true}, {"master", true}, {"x", false}}) {
        Client client(port());
        ASSERT_FALSE(client.connect());
        EXPECT_EQ(client.greet(token), allowed) << token;
        if (!allowed) {
            EXPECT_EQ(client.close_code(), protocol::close_code(ErrorCode::unauthorised));
        }
    }
    net->stop();
    EXPECT_EQ(log.lines_with("administrator=true").size(), 1u);
    EXPECT_TRUE(log.lines_with("sesame").empty()) << "a token in the log";
}

TEST_F(NetSession, a_subscriber_gets_what_it_needs_now_and_then_every_keyframe_in_order) {
    start();
    publish(5);
    Client client(port());
    ASSERT_FALSE(client.connect());
    ASSERT_TRUE(client.greet());
    const sea::FieldSet fields{sea::Field::height, sea::Field::foam};
    ASSERT_FALSE(client.send(protocol::subscribe(
        3, {.cascades = 0xffffffffu, .fields = fields | sea::FieldSet{sea::Field::slope_x}}, 8)));
    const wire::Message* message = client.receive();
    ASSERT_TRUE(message && message->body_as_Subscribed());
    const wire::Subscribed* grant = message->body_as_Subscribed();
    EXPECT_EQ(grant->request_id(), 3u);
    EXPECT_EQ(grant->cascades(), 3u);
    EXPECT_EQ(grant->fields(), fields.bits()) << "slopes are not offered";
    EXPECT_EQ(grant->credit(), 8);

    std::map<std::pair<int, std::int64_t>, int> tiles; // (cascade, n) -> fields received
    std::vector<float> samples(32 * 32);
    bool streaming = false;
    for (std::int64_t n = 6; tiles[{1, 25}] < 2;) {
        message = client.receive();
        ASSERT_TRUE(message) << client.error().message();
        if (const wire::FetchDone* done = message->body_as_FetchDone()) {
            EXPECT_EQ(done->request_id(), 3u);
            EXPECT_EQ(done->keyframes(), 4u);
            EXPECT_EQ(done->fields(), fields.bits());
            EXPECT_EQ(tiles.size(), 5u); // keyframes 5 and 6 of two cascades, and what is awaited
            streaming = true;
            publish(++n, fields);
            continue;
        }
        const wire::Tile* tile = message->body_as_Tile();
        ASSERT_TRUE(tile);
        ASSERT_TRUE(protocol::check(*tile).has_value());
        const protocol::TileHeader header = protocol::header(*tile);
        const std::int64_t at = header.time_us / interval_us;
        ASSERT_TRUE(protocol::decode_tile({tile->payload()->data(), tile->payload()->size()},
                                          {32, 32}, 32, samples)
                        .has_value());
        for (int i = 0; i < 1024; ++i)
            ASSERT_NEAR(samples[static_cast<std::size_t>(i)],
                        sample_value(header.cascade, at, header.field, i % 32, i / 32),
                        codec_error * 1.0001f);
        if (++tiles[{header.cascade, at}] == 2) {
            ASSERT_FALSE(client.send(protocol::ack(header.keyframe)));
            if (streaming && header.cascade == 1 && at < 25)
                publish(++n, fields);
        }
    }
    for (int cascade = 0; cascade < 2; ++cascade)
        for (std::int64_t n = 5; n <= 25; ++n)
            EXPECT_EQ((tiles[{cascade, n}]), 2) << "cascade " << cascade << " keyframe " << n;
}

TEST_F(NetSession, fields_that_are_not_offered_are_refused_and_the_session_goes_on) {
    start();
    Client client(port());
    ASSERT_FALSE(client.connect());
    ASSERT_TRUE(client.greet());
    ASSERT_FALSE(client.send(protocol::subscribe(1, {.fields = {sea::Field::slope_x}}, 2)));
    const wire::Message* message = client.receive();
    ASSERT_TRUE(message && message->body_as_Refused());
    EXPECT_EQ(message->body_as_Refused()->code(), ErrorCode::not_offered);
    ASSERT_FALSE(client.send(protocol::subscribe(2, {.fields = {}}, 2)));
    message = client.receive();
    ASSERT_TRUE(message && message->body_as_Refused());
    EXPECT_EQ(message->body_as_Refused()->code(), ErrorCode::bad_value);
    EXPECT_EQ(message->body_as_Refused()->request_id(), 2u);
    const sea::TimeUs time_us = 0;
    ASSERT_FALSE(client.send(protocol::fetch(3, {&time_us, 1}, {.fields = {sea::Field::slope_x}})));
    message = client.receive();
    ASSERT_TRUE(message && message->body_as_Refused());
    EXPECT_EQ(message->body_as_Refused()->code(), ErrorCode::not_offered);
    ASSERT_FALSE(client.send(protocol::ping(4, 99)));
    message = client.receive();
    ASSERT_TRUE(message && message->body_as_Pong());
    EXPECT_EQ(message->body_as_Pong()->client_time_us(), 99);
}

TEST_F(NetSession, a_subscription_that_is_refused_leaves_the_one_before) {
    start();
    Client client(port());
    ASSERT_FALSE(client.connect());
    ASSERT_TRUE(client.greet());
    ASSERT_FALSE(client.send(protocol::subscribe(1, {.fields = {sea::Field::height}}, 2)));
    ASSERT_TRUE(client.receive(Body::FetchDone));
    EXPECT_EQ(metric("seaway_net_subscriptions"), 1);
    ASSERT_FALSE(client.send(protocol::subscribe(2, {.fields = {sea::Field::slope_x}}, 2)));
    ASSERT_TRUE(client.receive(Body::Refused));
    EXPECT_EQ(metric("seaway_net_subscriptions"), 1);
    publish(50);
    EXPECT_TRUE(client.receive(Body::Tile));
}

// A keyframe made for an earlier plan has less than was granted since: half of it is of no use.
TEST_F(NetSession, keyframes_that_lack_what_was_granted_are_left_out) {
    start();
    Client client(port());
    ASSERT_FALSE(client.connect());
    ASSERT_TRUE(client.greet());
    const sea::FieldSet both{sea::Field::height, sea::Field::foam};
    ASSERT_FALSE(client.send(protocol::subscribe(1, {.cascades = 1u, .fields = both}, 8)));
    ASSERT_TRUE(client.receive(Body::FetchDone));
    net->publish(host.keyframe(0, 7, {sea::Field::height}));
    net->publish(host.keyframe(0, 8, both));
    for (int field = 0; field < 2; ++field) {
        const wire::Message* message = client.receive();
        ASSERT_TRUE(message && message->body_as_Tile());
        EXPECT_EQ(message->body_as_Tile()->time_us(), 8 * interval_us);
    }
}

TEST_F(NetSession, without_acknowledgements_the_credit_is_sent_and_then_only_the_newest) {
    start();
    Client client(port());
    ASSERT_FALSE(client.connect());
    ASSERT_TRUE(client.greet());
    ASSERT_FALSE(
        client.send(protocol::subscribe(1, {.cascades = 1u, .fields = {sea::Field::height}}, 2)));
    ASSERT_TRUE(client.receive(Body::FetchDone));
    for (std::int64_t n = 10; n < 20; ++n) {
        publish(n);
        ASSERT_TRUE(eventually([&] { // each keyframe has reached the outbox before the next
            return metric("seaway_net_keyframes_published_total") == static_cast<double>(n - 9);
        }));
    }
    std::vector<std::uint64_t> numbers;
    for (const std::int64_t n : {10, 11}) {
        const wire::Message* message = client.receive();
        ASSERT_TRUE(message && message->body_as_Tile());
        EXPECT_EQ(message->body_as_Tile()->time_us(), n * interval_us);
        numbers.push_back(message->body_as_Tile()->keyframe());
    }
    ASSERT_FALSE(client.send(protocol::ack(numbers[1])));
    const wire::Message* message = client.receive();
    ASSERT_TRUE(message && message->body_as_Tile());
    EXPECT_EQ(message->body_as_Tile()->time_us(), 19 * interval_us);
    EXPECT_EQ(metric("seaway_net_keyframes_replaced_total"), 7);
}

TEST_F(NetSession, fetch_sends_the_keyframes_around_each_time_once) {
    start();
    Client client(port());
    ASSERT_FALSE(client.connect());
    ASSERT_TRUE(client.greet());
    const sea::TimeUs times[] = {7 * interval_us + 50'000, 40 * interval_us + 1};
    ASSERT_FALSE(
        client.send(protocol::fetch(8, times, {.cascades = 2u, .fields = {sea::Field::height}})));
    std::set<sea::TimeUs> seen;
    while (true) {
        const wire::Message* message = client.receive();
        ASSERT_TRUE(message);
        if (const wire::FetchDone* done = message->body_as_FetchDone()) {
            EXPECT_EQ(done->request_id(), 8u);
            EXPECT_EQ(done->keyframes(), 4u);
            break;
        }
        ASSERT_TRUE(message->body_as_Tile());
        EXPECT_EQ(message->body_as_Tile()->cascade(), 1);
        seen.insert(message->body_as_Tile()->time_us() / interval_us);
    }
    EXPECT_EQ(seen, (std::set<sea::TimeUs>{7, 8, 40, 41}));
}

TEST_F(NetSession, a_query_is_answered_in_order_and_limits_are_refusals) {
    start();
    Client client(port());
    ASSERT_FALSE(client.connect());
    ASSERT_TRUE(client.greet());
    std::vector<sea::QueryPoint> points;
    for (int i = 0; i < 4096; ++i)
        points.push_back({.x_m = i * 1.5, .y_m = 1e6, .time_us = i});
    ASSERT_FALSE(client.send(protocol::query(5, points, false)));
    const wire::Message* message = client.receive();
    ASSERT_TRUE(message && message->body_as_QueryReply());
    EXPECT_EQ(message->body_as_QueryReply()->epoch(), SmallSea::answering_epoch);
    const auto* answers = message->body_as_QueryReply()->answers();
    ASSERT_EQ(answers->size(), points.size());
    for (std::uint32_t i = 0; i < answers->size(); ++i)
        ASSERT_EQ(protocol::answer(*answers->Get(i)).height_m, 1.5 * i + 1e6);

    points.push_back(points.front());
    ASSERT_FALSE(client.send(protocol::query(6, points, false)));
    message = client.receive();
    ASSERT_TRUE(message && message->body_as_Refused());
    EXPECT_EQ(message->body_as_Refused()->code(), ErrorCode::too_many_points);
    points.resize(257);
    ASSERT_FALSE(client.send(protocol::query(7, points, true)));
    message = client.receive();
    ASSERT_TRUE(message && message->body_as_Refused());
    EXPECT_EQ(message->body_as_Refused()->code(), ErrorCode::too_many_points);
}

TEST_F(NetSession, queries_in_flight_are_limited_a_session) {
    host.answer_queries = false;
    start();
    Client client(port());
    ASSERT_FALSE(client.connect());
    ASSERT_TRUE(client.greet());
    const sea::QueryPoint point{.x_m = 1, .y_m = 2, .time_us = 3};
    const auto in_flight = static_cast<std::uint32_t>(protocol::limits::queries_in_flight_max);
    for (std::uint32_t id = 0; id <= in_flight; ++id)
        ASSERT_FALSE(client.send(protocol::query(id, {&point, 1}, false)));
    const wire::Message* message = client.receive();
    ASSERT_TRUE(message && message->body_as_Refused());
    EXPECT_EQ(message->body_as_Refused()->code(), ErrorCode::too_many_requests);
    EXPECT_EQ(message->body_as_Refused()->request_id(), in_flight);
    for (const auto& answer : host.unanswered) // as from another thread
        answer();
    for (std::uint32_t id = 0; id < in_flight; ++id) {
        message = client.receive();
        ASSERT_TRUE(message && message->body_as_QueryReply());
        EXPECT_EQ(message->body_as_QueryReply()->request_id(), id);
    }
}

TEST_F(NetSession, an_answer_that_comes_after_the_session_or_the_server_does_nothing) {
    host.answer_queries = false;
    start();
    const sea::QueryPoint point{.x_m = 1, .y_m = 2, .time_us = 3};
    {
        Client client(port());
        ASSERT_FALSE(client.connect());
        ASSERT_TRUE(client.greet());
        for (std::uint32_t id = 0; id < 2; ++id)
            ASSERT_FALSE(client.send(protocol::query(id, {&point, 1}, false)));
        ASSERT_TRUE(eventually([&] { return metric("seaway_net_queries_total") == 2; }));
    }
    ASSERT_TRUE(eventually([&] { return metric("seaway_net_sessions") == 0; }));
    host.unanswered.at(0)();
    EXPECT_EQ(get("/healthz").status, 200);
    net.reset();
    host.unanswered.at(1)();
}

TEST_F(NetSession, a_new_sea_state_reaches_every_session) {
    start();
    std::vector<std::unique_ptr<Client>> clients;
    for (int i = 0; i < 5; ++i) {
        clients.push_back(std::make_unique<Client>(port()));
        ASSERT_FALSE(clients.back()->connect());
        ASSERT_TRUE(clients.back()->greet());
    }
    net->announce(SmallSea::state_message(7));
    for (const auto& client : clients) {
        const wire::Message* message = client->receive();
        ASSERT_TRUE(message && message->body_as_SeaState());
        EXPECT_EQ(message->body_as_SeaState()->epoch(), 7u);
    }
}

// Naive: what was granted in a calm sea is stated for ever. And keyframes of the rung before that are on their way when
// the rung changes are thrown away: a hole of an interval.
TEST_F(NetSession, when_the_sea_changes_what_is_granted_is_said_again_and_nothing_is_missing) {
    start();
    publish(5);
    Client client(port());
    ASSERT_FALSE(client.connect());
    ASSERT_TRUE(client.greet());
    ASSERT_FALSE(client.send(protocol::subscribe(3, heights, 8)));
    const wire::Message* message = client.receive();
    ASSERT_TRUE(message && message->body_as_Subscribed());
    EXPECT_EQ(message->body_as_Subscribed()->error_m(), SmallSea::bound(0));
    EXPECT_EQ(message->body_as_Subscribed()->why(), nullptr)
        << "nothing less: nothing more to read";
    EXPECT_EQ(message->body_as_Subscribed()->limits(), nullptr);
    while (!message->body_as_FetchDone())
        ASSERT_TRUE((message = client.receive()));
    net->announce(SmallSea::state_message(7));
    ASSERT_TRUE((message = client.receive()) && message->body_as_SeaState()) << "and nothing else";
    host.coarser_now = true;
    net->announce(SmallSea::state_message(8));
    bool told = false, announced = false;
    while (!told || !announced) {
        ASSERT_TRUE((message = client.receive()));
        announced = announced || message->body_as_SeaState();
        if (const wire::Subscribed* again = message->body_as_Subscribed()) {
            EXPECT_EQ(again->request_id(), 3u);
            EXPECT_EQ(again->error_m(), SmallSea::bound(1));
            EXPECT_EQ(again->why()->str(), "the sea has grown");
            told = true;
        }
    }
    const auto next_tile_us = [&] {
        do
            message = client.receive();
        while (message && !message->body_as_Tile());
        EXPECT_TRUE(message);
        return message ? message->body_as_Tile()->time_us() : 0;
    };
    const auto on_its_way = [&](std::int64_t n, server::Quality quality) {
        net->publish(host.keyframe(0, n, {sea::Field::height}, quality));
    };
    host.subscriptions().set(99, {.cascades = 1u, .fields = {sea::Field::height}}); // another one's
    on_its_way(7, 0);
    EXPECT_EQ(next_tile_us(), 7 * interval_us) << "of the rung before";
    on_its_way(8, 1);
    EXPECT_EQ(next_tile_us(), 8 * interval_us);
    on_its_way(9, 0);
    on_its_way(9, 1);
    EXPECT_EQ(next_tile_us(), 9 * interval_us);
    on_its_way(10, 1);
    EXPECT_EQ(next_tile_us(), 10 * interval_us) << "each once";
}

TEST_F(NetSession, the_subscription_ends_with_unsubscribe_and_with_the_session) {
    start();
    {
        Client client(port());
        ASSERT_FALSE(client.connect());
        ASSERT_TRUE(client.greet());
        ASSERT_FALSE(client.send(protocol::subscribe(1, {.fields = {sea::Field::height}}, 2)));
        ASSERT_TRUE(client.receive(Body::FetchDone));
        EXPECT_EQ(metric("seaway_net_subscriptions"), 1);
        ASSERT_FALSE(client.send(protocol::unsubscribe()));
        ASSERT_TRUE(eventually([&] { return metric("seaway_net_subscriptions") == 0; }));
        ASSERT_FALSE(client.send(protocol::subscribe(2, {.fields = {sea::Field::height}}, 2)));
        ASSERT_TRUE(client.receive(Body::FetchDone));
        EXPECT_EQ(metric("seaway_net_subscriptions"), 1);
    }
    EXPECT_TRUE(eventually([&] { return metric("seaway_net_subscriptions") == 0; }));
    net->stop();
    EXPECT_EQ(host.subscriptions().size(), 0u);
}

TEST_F(NetSession, one_keyframe_is_encoded_once_for_all_sessions_and_for_later_fetches) {
    start();
    std::vector<std::unique_ptr<Client>> clients;
    for (int i = 0; i < 10; ++i) {
        clients.push_back(std::make_unique<Client>(port()));
        ASSERT_FALSE(clients.back()->connect());
        ASSERT_TRUE(clients.back()->greet());
        ASSERT_FALSE(
            clients.back()->send(protocol::subscribe(1, {.fields = {sea::Field::height}}, 8)));
        ASSERT_TRUE(clients.back()->receive(Body::FetchDone));
    }
    EXPECT_EQ(metric("seaway_net_fields_encoded_total"), 4) << "two cascades, keyframes 0 and 1";
    publish(50);
    for (const auto& client : clients)
        for (int cascade = 0; cascade < 2; ++cascade)
            ASSERT_TRUE(client->receive(Body::Tile));
    EXPECT_EQ(metric("seaway_net_fields_encoded_total"), 6);
}

TEST_F(NetSession, a_keyframe_that_is_not_finite_is_not_sent_and_is_counted) {
    start();
    Client client(port());
    ASSERT_FALSE(client.connect());
    ASSERT_TRUE(client.greet());
    ASSERT_FALSE(client.send(protocol::subscribe(1, {.fields = {sea::Field::height}}, 8)));
    ASSERT_TRUE(client.receive(Body::FetchDone));
    KeyframeTiles tiles = host.keyframe(0, 8, {sea::Field::height});
    auto broken = std::make_shared<sea::Keyframe>(*tiles.keyframe);
    broken->values[77] = std::nanf("");
    net->publish({.keyframe = broken, .codec_error = tiles.codec_error});
    net->publish(host.keyframe(0, 9, {sea::Field::height}));
    const wire::Message* message = client.receive();
    ASSERT_TRUE(message && message->body_as_Tile());
    EXPECT_EQ(message->body_as_Tile()->time_us(), 9 * interval_us);
    EXPECT_EQ(metric("seaway_net_keyframes_wrong_total"), 1);
}

} // namespace
} // namespace seaway::tests
