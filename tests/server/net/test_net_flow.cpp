// SPDX-License-Identifier: Apache-2.0
// How requests and answers flow: reading is taken up again, connections go on or end as they say, what
// is begun is finished, and what is told is all that there is.
#include "tests/server/net/net_fixture.h"

#include <csignal>
#include <filesystem>
#include <future>
#include <mutex>

#include "protocol/limits.h"
#include "server/net/encode_worker.h"
#include "tests/support/process_status.h"

namespace seaway::tests {
namespace {

using server::EncodeWorker;
using wire::Body;
namespace limits = protocol::limits;

class NetFlow : public NetTest {};

// 40 replies are 6 MB: more than the kernel and the outbox hold together, so that the server reads no
// further until the client does. Naive: nothing begins it again.
TEST_F(NetFlow, who_asks_much_and_reads_late_gets_every_answer_in_order) {
    options.write_timeout = std::chrono::minutes(5);
    start();
    const auto client = greeted();
    const std::vector<sea::QueryPoint> points(limits::points_per_query_max);
    constexpr std::uint32_t count = 40;
    std::thread asks([&] {
        for (std::uint32_t id = 1; id <= count; ++id)
            EXPECT_FALSE(client->send(protocol::query(id, points, false)));
    });
    EXPECT_TRUE(eventually([&] {
        return metric("seaway_net_outbox_bytes") >= static_cast<double>(limits::replies_bytes_max);
    }));
    EXPECT_LT(metric("seaway_net_queries_total"), count) << "reading has paused";
    for (std::uint32_t id = 1; id <= count; ++id) {
        const wire::Message* message = client->receive();
        if (!message || !message->body_as_QueryReply()) {
            ADD_FAILURE() << "no answer to " << id;
            break;
        }
        EXPECT_EQ(message->body_as_QueryReply()->request_id(), id);
    }
    asks.join();
}

struct Exchange {
    std::string request;
    int status;
    bool goes_on;
};

TEST_F(NetFlow, every_answer_says_whether_the_connection_goes_on_and_so_it_does) {
    options.http_deadline = std::chrono::minutes(5);
    options.client_token_file = folder().write("flow_token", "open sesame\n");
    options.sessions_max = 1;
    host.is_busy = true; // maps are refused
    start();
    Client only(port());
    ASSERT_FALSE(only.connect());
    ASSERT_TRUE(only.greet("open sesame")); // a place that no token takes away
    const std::string rest =
        " HTTP/1.1\r\nHost: 127.0.0.1\r\nAuthorization: Bearer open sesame\r\n";
    const std::string upgrade =
        "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: "
        "13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
        "Sec-WebSocket-Protocol: ";
    const Exchange exchanges[] = {
        {"GET /v1/state" + rest + "\r\n", 200, true},
        {"GET /v1/state" + rest + "Connection: close\r\n\r\n", 200, false},
        {"GET /healthz HTTP/1.0\r\n\r\n", 200, false},
        {"GET /healthz HTTP/1.0\r\nConnection: keep-alive\r\n\r\n", 200, false},
        {"HEAD /v1/map HTTP/1.0\r\nAuthorization: Bearer open sesame\r\n"
         "Connection: keep-alive\r\n\r\n",
         200, false},
        {"HEAD /healthz" + rest + "\r\n", 200, true},
        {"HEAD /healthz" + rest + "Connection: close\r\n\r\n", 200, false},
        {"GET /none" + rest + "\r\n", 404, true},
        {"POST /v1/plan" + rest + "Content-Length: 3\r\n\r\nabc", 405, true},
        {"GET /v1/stream" + rest + "\r\n", 426, true},
        {"GET /v1/state HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n", 401, false},
        {"GET /v1/map" + rest + "\r\n", 503, false},
        {"HEAD /v1/map" + rest + "\r\n", 200, true},
        {"GET /v1/stream" + rest + upgrade + "other.v1\r\n\r\n", 400, false},
        {"GET /v1/stream" + rest + upgrade + "seaway.v1\r\n\r\n", 503, false},
        {"GET /healthz" + rest + "X: " + std::string(9000, 'x') + "\r\n\r\n", 431, false},
        {"GET /healthz" + rest + "Content-Length: 1025\r\n\r\n", 413, false},
        {"nonsense\r\n\r\n", 400, false}};
    for (const auto& [request, status, goes_on] : exchanges) {
        RawPeer peer(port());
        peer.say(request);
        const std::string header = peer.header();
        EXPECT_TRUE(header.starts_with("HTTP/1.1 " + std::to_string(status))) << header;
        EXPECT_EQ(header.find("Connection: close\r\n") == std::string::npos, goes_on)
            << request << header;
        peer.say("GET /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n");
        const std::string next = peer.rest();
        EXPECT_EQ(next.find("HTTP/1.1 200 OK") != std::string::npos, goes_on) << request << next;
    }
}

// Of four that wait with half a request the second has waited longest, since the first had an answer.
TEST_F(NetFlow, who_has_waited_longest_without_a_whole_request_makes_room_and_nobody_else) {
    options.connections_max = 4;
    options.http_deadline = std::chrono::minutes(5);
    start();
    std::unique_ptr<RawPeer> peers[4];
    for (auto& peer : peers) {
        peer = std::make_unique<RawPeer>(port());
        peer->say("GET /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\n");
    }
    peers[0]->say("\r\n");
    EXPECT_TRUE(peers[0]->header().starts_with("HTTP/1.1 200"));
    peers[0]->say("GET /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\n");
    EXPECT_EQ(get("/healthz").status, 200) << "the newcomer";
    for (const int stays : {0, 2, 3, 1}) {
        peers[stays]->say("Connection: close\r\n\r\n");
        EXPECT_EQ(peers[stays]->rest().find("HTTP/1.1 200") != std::string::npos, stays != 1)
            << stays;
    }
    EXPECT_EQ(metric("seaway_net_connections_given_up_total"), 1);
    EXPECT_EQ(metric("seaway_net_connections_refused_total{reason=\"server_full\"}"), 0);
}

// A query behind a path is part of no path.
TEST_F(NetFlow, every_path_is_the_same_with_a_query_behind_it) {
    host.maps_ready = true;
    start();
    for (const auto& [path, status] : std::map<std::string, int>{{"/", 200},
                                                                 {"/healthz", 200},
                                                                 {"/metrics", 200},
                                                                 {"/v1/state", 200},
                                                                 {"/v1/plan", 200},
                                                                 {"/v1/map", 200},
                                                                 {"/v1/stream", 426},
                                                                 {"/none", 404}})
        for (const char* query : {"", "?", "?a=1", "?a=1&b=/v1/stream"})
            EXPECT_EQ(get(path + query).status, status) << path << query;
    EXPECT_EQ(get("/v1/plan?a=1", "POST").status, 405);
    EXPECT_EQ(get("/v1/map?a=1", "POST").status, 405);
    RawPeer peer(port());
    peer.say("GET /v1/stream?name=x HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\n"
             "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
             "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
             "Sec-WebSocket-Protocol: seaway.v1\r\n\r\n");
    EXPECT_TRUE(peer.header().starts_with("HTTP/1.1 101"));
}

TEST_F(NetFlow, hello_is_answered_with_every_sea_that_is_known_in_their_order) {
    host.states = {SmallSea::state_message(4), SmallSea::state_message(9),
                   SmallSea::state_message(6)};
    start();
    Client client(port());
    ASSERT_FALSE(client.connect());
    ASSERT_FALSE(client.send(protocol::hello("test", "")));
    ASSERT_TRUE(client.receive(Body::Welcome));
    for (const std::uint32_t epoch : {4u, 9u, 6u}) {
        const wire::Message* message = client.receive();
        ASSERT_TRUE(message && message->body_as_SeaState());
        EXPECT_EQ(message->body_as_SeaState()->epoch(), epoch);
    }
}

// A keyframe made for an earlier plan may lack a field. What is said to have come is what all have, and
// nothing else is sent.
TEST_F(NetFlow, a_fetch_brings_and_names_the_fields_that_every_keyframe_of_it_holds) {
    const sea::FieldSet both{sea::Field::height, sea::Field::foam};
    for (const int lacking : {0, 1}) {
        host.lacks = {{lacking, {sea::Field::foam}}};
        net = nullptr;
        start();
        const auto client = greeted();
        const sea::TimeUs time_us = (10 + lacking) * interval_us;
        ASSERT_FALSE(client->send(protocol::fetch(1, {&time_us, 1}, {.fields = both})));
        int tiles = 0;
        const wire::Message* message = client->receive();
        for (; message && message->body_as_Tile(); message = client->receive(), ++tiles)
            EXPECT_EQ(message->body_as_Tile()->field(), wire::Field::height);
        EXPECT_EQ(tiles, 4) << "two keyframes of two cascades";
        ASSERT_TRUE(message && message->body_as_FetchDone());
        EXPECT_EQ(message->body_as_FetchDone()->keyframes(), 4u);
        EXPECT_EQ(message->body_as_FetchDone()->fields(), sea::FieldSet{sea::Field::height}.bits())
            << "cascade " << lacking << " lacks foam";
    }
}

class NetStream : public NetTest {
  protected:
    /// A client that has had keyframe 10 of the first cascade, its whole credit, while 11 waits; gives
    /// the number to acknowledge.
    std::uint64_t client_with_one_waiting() {
        start();
        client = greeted();
        EXPECT_FALSE(client->send(protocol::subscribe(1, heights, 1)));
        EXPECT_TRUE(client->receive(Body::FetchDone));
        publish(10);
        const std::uint64_t number = streamed(10, wire::Field::height);
        publish(11);
        EXPECT_TRUE(eventually([&] { return metric("seaway_net_outbox_bytes") > 0; }));
        return number;
    }
    /// The next message is a tile of keyframe n; gives its number.
    std::uint64_t streamed(std::int64_t n, wire::Field field) {
        const wire::Message* message = client->receive();
        const wire::Tile* tile = message ? message->body_as_Tile() : nullptr;
        EXPECT_TRUE(tile) << n;
        if (tile == nullptr)
            return 0;
        EXPECT_EQ(tile->time_us(), n * interval_us);
        EXPECT_EQ(tile->field(), field);
        return tile->keyframe();
    }
    /// Three answers and no tile before them: what may go out has gone by then.
    void expect_no_tile() {
        for (std::uint32_t id = 100; id < 103; ++id) {
            ASSERT_FALSE(client->send(protocol::ping(id, 0)));
            const wire::Message* message = client->receive();
            ASSERT_TRUE(message);
            ASSERT_TRUE(message->body_as_Pong())
                << "kind " << static_cast<int>(message->body_type());
        }
    }
    /// Another subscription, and the tiles that it begins with, which are all of its field.
    void subscribe_again(sea::Field field, std::uint8_t credit) {
        ASSERT_FALSE(
            client->send(protocol::subscribe(2, {.cascades = 1u, .fields = {field}}, credit)));
        const wire::Message* message = client->receive();
        ASSERT_TRUE(message && message->body_as_Subscribed());
        EXPECT_EQ(message->body_as_Subscribed()->credit(), credit);
        for (message = client->receive(); message && message->body_as_Tile();
             message = client->receive())
            EXPECT_EQ(message->body_as_Tile()->field(), static_cast<wire::Field>(field));
        ASSERT_TRUE(message && message->body_as_FetchDone());
    }

    std::unique_ptr<Client> client;
};

TEST_F(NetStream, who_unsubscribes_gets_no_keyframe_that_waited_for_credit) {
    const std::uint64_t number = client_with_one_waiting();
    ASSERT_FALSE(client->send(protocol::unsubscribe()));
    EXPECT_TRUE(eventually([&] { return metric("seaway_net_subscriptions") == 0; }));
    EXPECT_EQ(metric("seaway_net_outbox_bytes"), 0) << "what waited is released now";
    ASSERT_FALSE(client->send(protocol::ack(number)));
    expect_no_tile();
    publish(12);
    expect_no_tile();
}

// What waited was of the earlier subscription. What has been sent of it is still on its way: it is in the
// window until it is acknowledged, whichever subscription it was of.
TEST_F(NetStream, another_subscription_begins_without_what_waited_and_with_what_is_on_its_way) {
    const std::uint64_t number = client_with_one_waiting();
    subscribe_again(sea::Field::foam, 1);
    EXPECT_EQ(metric("seaway_net_outbox_bytes"), 0) << "nothing waits any more";
    publish(12, {sea::Field::height, sea::Field::foam});
    EXPECT_TRUE(eventually([&] { return metric("seaway_net_outbox_bytes") > 0; }));
    expect_no_tile();
    ASSERT_FALSE(client->send(protocol::ack(number)));
    streamed(12, wire::Field::foam);
    expect_no_tile();
}

// Naive: the first is given back before the other is granted, and a simulation that looks in between ends what nobody wants.
TEST_F(NetStream, another_subscription_takes_the_place_of_the_first_with_no_moment_between) {
    struct Seen {
        std::mutex mutex;
        std::vector<sea::FieldSet> wanted;
    };
    const auto seen = std::make_shared<Seen>();
    host.subscriptions().on_change([this, seen] {
        const std::scoped_lock lock(seen->mutex);
        seen->wanted.push_back(host.subscriptions().wanted(0));
    });
    client_with_one_waiting();
    subscribe_again(sea::Field::foam, 1);
    const std::scoped_lock lock(seen->mutex);
    EXPECT_EQ(seen->wanted,
              (std::vector{sea::FieldSet{sea::Field::height}, sea::FieldSet{sea::Field::foam}}));
}

// Naive: what follows from maps that are sent to somebody is made for nobody.
TEST_F(NetStream, who_takes_what_follows_alone_is_sent_it_beside_who_takes_what_it_follows_from) {
    start();
    host.subscriptions().set(1000, {.cascades = 1u, .fields = sea::surface_fields});
    client = greeted();
    const sea::FieldSet moved{sea::Field::displacement_x};
    ASSERT_FALSE(client->send(protocol::subscribe(1, {.cascades = 1u, .fields = moved}, 1)));
    ASSERT_TRUE(client->receive(Body::FetchDone));
    host.newest = 10;
    server::KeyframeTiles deep = host.keyframe(0, 10, sea::surface_fields);
    deep.compact_size = 16;
    deep.follows = sea::following(sea::surface_fields);
    net->publish(deep);
    streamed(10, wire::Field::displacement_x);
}

TEST_F(NetStream, each_subscription_has_the_credit_that_it_asks_for) {
    client_with_one_waiting();
    subscribe_again(sea::Field::foam, 3);
    for (const std::int64_t n : {12, 13, 14}) {
        publish(n, {sea::Field::foam});
        if (n < 14)
            streamed(n, wire::Field::foam);
    }
    EXPECT_TRUE(eventually([&] { return metric("seaway_net_outbox_bytes") > 0; }));
    expect_no_tile(); // 10, 12 and 13 are on their way
}

// Naive: one that this sea cannot grant ends what there was, and the client, which was refused, goes on with it.
TEST_F(NetStream, a_refused_subscription_leaves_what_waits_and_what_there_was) {
    for (const bool offered : {true, false}) {
        net = nullptr;
        const std::uint64_t number = client_with_one_waiting();
        const sea::FieldSet fields = offered ? sea::FieldSet{} : sea::FieldSet{sea::Field::slope_x};
        ASSERT_FALSE(client->send(protocol::subscribe(2, {.fields = fields}, 1)));
        const wire::Message* message = client->receive();
        ASSERT_TRUE(message && message->body_as_Refused());
        EXPECT_EQ(message->body_as_Refused()->code(),
                  offered ? wire::ErrorCode::bad_value : wire::ErrorCode::not_offered);
        ASSERT_FALSE(client->send(protocol::ack(number)));
        streamed(11, wire::Field::height);
        expect_no_tile();
    }
}

// Where many are sent the same it comes out of a file for those whose fields lie one behind the other there, and is
// written for the others.
TEST_F(NetStream, everybody_is_sent_the_same_bytes_whatever_way_they_take) {
    host.size = 300; // four tiles a field
    start();
    const sea::FieldSet all{sea::Field::height, sea::Field::displacement_x,
                            sea::Field::displacement_y};
    const sea::FieldSet with_a_gap{sea::Field::height, sea::Field::displacement_y};
    std::vector<std::unique_ptr<Client>> clients;
    for (int i = 0; i < 8; ++i) {
        Client& one = *clients.emplace_back(greeted());
        const protocol::TileWish wish{.cascades = 1u, .fields = i < 4 ? all : with_a_gap};
        ASSERT_FALSE(one.send(protocol::subscribe(1, wish, 4)));
        ASSERT_TRUE(one.receive(wire::Body::FetchDone));
    }
    for (const std::int64_t n : {10, 11})
        net->publish(host.keyframe(0, n, all));
    std::map<std::tuple<std::int64_t, wire::Field, int>, std::vector<std::uint8_t>> first;
    for (std::size_t i = 0; i < clients.size(); ++i)
        for (int tile = 0; tile < 2 * 4 * (i < 4 ? 3 : 2); ++tile) {
            const wire::Message* message = clients[i]->receive();
            ASSERT_TRUE(message && message->body_as_Tile()) << i << ", tile " << tile;
            const wire::Tile& it = *message->body_as_Tile();
            const std::vector<std::uint8_t> payload(it.payload()->begin(), it.payload()->end());
            const auto [same, is_first] =
                first.try_emplace({it.time_us(), it.field(), it.part()}, payload);
            EXPECT_EQ(is_first, i == 0);
            EXPECT_EQ(same->second, payload) << i << ", tile " << tile;
        }
    EXPECT_EQ(first.size(), 2u * 4u * 3u);
}

// What is sent out of a file cannot say, as other writes do, that a peer that has gone is an error and no signal.
TEST_F(NetStream, no_thread_that_sends_is_ended_by_a_peer_that_goes_away) {
    start();
    greeted(); // so that the thread has begun
    std::size_t blocking = 0;
    for (const auto& thread : std::filesystem::directory_iterator("/proc/self/task"))
        blocking += signals_in(thread, "SigBlk") == 1ull << (SIGPIPE - 1);
    EXPECT_EQ(blocking, 1u) << "the io thread; one that is only beginning blocks all signals";
}

TEST(EncodeWorker, what_has_begun_is_finished_before_the_next_of_its_line) {
    for (const bool starts : {false, true}) {
        EncodeWorker worker;
        const auto submit = [&](EncodeWorker::Job job) {
            return starts ? worker.submit_start(std::move(job))
                          : worker.submit_fetched(std::move(job));
        };
        std::promise<void> gate;
        ASSERT_TRUE(submit([opened = gate.get_future().share()](server::Encoder&) {
            opened.wait();
            return true;
        }));
        std::string order; // of the encode thread, read when it has done
        std::promise<void> done;
        const auto slices = [&](char name, int count, bool last) {
            return [&, name, left = count, last](server::Encoder&) mutable {
                order += name;
                if (--left == 0 && last)
                    done.set_value();
                return left == 0;
            };
        };
        ASSERT_TRUE(submit(slices('a', 3, false)));
        ASSERT_TRUE(submit(slices('b', 1, false)));
        ASSERT_TRUE(submit(slices('c', 2, true)));
        gate.set_value();
        done.get_future().wait();
        worker.stop();
        EXPECT_EQ(order, "aaabcc") << (starts ? "starts" : "fetches");
    }
}

} // namespace
} // namespace seaway::tests
