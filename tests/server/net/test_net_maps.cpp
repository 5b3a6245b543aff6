// SPDX-License-Identifier: Apache-2.0
// Bulk maps as the net serves them: who leaves, who reads slowly, and that nobody else waits for it.
#include <future>

#include "tests/server/net/net_fixture.h"

namespace seaway::tests {
namespace {

const std::string_view ask_for_a_map = "GET /v1/map HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n";

class NetMaps : public NetTest {};

// Naive: the thread of all sockets lets go of a map and waits for the threads that make it.
TEST_F(NetMaps, the_end_of_a_map_that_takes_long_delays_nobody_else) {
    std::promise<void> ends;
    std::promise<void> may_end;
    host.on_map_end = [&, wait = may_end.get_future().share()] {
        ends.set_value();
        wait.wait_for(std::chrono::seconds(20)); // a test that fails ends all the same
    };
    start();
    {
        RawPeer peer(port());
        peer.say(ask_for_a_map);
        EXPECT_TRUE(peer.header().starts_with("HTTP/1.1 200"));
    }
    ends.get_future().wait();
    EXPECT_EQ(get("/healthz").status, 200);
    Client client(port());
    ASSERT_FALSE(client.connect());
    EXPECT_TRUE(client.greet());
    EXPECT_EQ(*host.maps_alive, 1) << "it has not ended yet";
    may_end.set_value();
    EXPECT_TRUE(eventually([&] { return *host.maps_alive == 0; }));
}

TEST_F(NetMaps, who_leaves_before_its_map_begins_is_known_to_have_gone) {
    host.answer_maps = false;
    start();
    {
        RawPeer peer(port());
        peer.say(ask_for_a_map);
        ASSERT_TRUE(eventually([&] { return host.maps_asked == 1; }));
        EXPECT_FALSE(host.askers.front().gone());
    }
    EXPECT_TRUE(eventually([&] { return host.askers.front().gone(); }));
    EXPECT_TRUE(eventually([&] { return metric("seaway_net_connections") == 1; }));
}

TEST_F(NetMaps, who_leaves_while_rows_are_made_gives_its_place_back) {
    start();
    {
        RawPeer peer(port());
        peer.say(ask_for_a_map);
        EXPECT_TRUE(peer.header().starts_with("HTTP/1.1 200"));
        EXPECT_EQ(*host.maps_alive, 1);
    }
    EXPECT_TRUE(eventually([&] { return *host.maps_alive == 0; }));
}

// Naive: every write has a deadline of its own, so that a map of many is read for ever. The reader
// takes a piece at a time in less than that deadline.
TEST_F(NetMaps, who_reads_more_slowly_than_the_least_rate_loses_its_place) {
    host.map_bytes = 64 * 1024 * 1024;
    host.map_piece_bytes = 64 * 1024;
    options.write_timeout = std::chrono::milliseconds(500);
    options.map_bytes_per_s_min = 1e12; // nobody reads at that
    start();
    RawPeer peer(port(), 4096);
    peer.say(ask_for_a_map);
    peer.header();
    std::size_t pieces = 0;
    while (peer.reads(host.map_piece_bytes) && ++pieces < 1000)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    EXPECT_LT(pieces, 1000u);
    EXPECT_TRUE(eventually([&] { return *host.maps_alive == 0; }));
}

// Naive: what waits for the host's answer is kept where the answer is a refusal, and with it its place.
TEST_F(NetMaps, a_refused_map_says_why_and_leaves_nothing_behind) {
    host.is_busy = true;
    options.connections_max = 6;
    start();
    for (int i = 0; i < 10; ++i) {
        const HttpAnswer answer = get("/v1/map", i % 2 == 0 ? "GET" : "HEAD");
        EXPECT_EQ(answer.status, 503);
        EXPECT_EQ(answer.body, i % 2 == 0 ? "later\n" : "");
    }
    ASSERT_TRUE(eventually([&] { return metric("seaway_net_connections") == 1; }));
    EXPECT_EQ(metric("seaway_net_connections_refused_total{reason=\"server_full\"}"), 0);
    EXPECT_EQ(metric("seaway_net_http_responses_total{status=\"503\"}"), 10);
    host.is_busy = false;
    host.maps_ready = true;
    for (int i = 0; i < 10; ++i)
        EXPECT_EQ(get("/v1/map", i % 2 == 0 ? "GET" : "HEAD").status, 200);
    const std::string page = get("/metrics").body;
    const auto value = [&](const std::string& name) {
        const std::size_t at = page.find("\n" + name + " ");
        return at == std::string::npos ? 0.0 : std::stod(page.substr(at + name.size() + 2));
    };
    // Every connection had one answer, but for the one that asks.
    EXPECT_EQ(value("seaway_net_http_responses_total{status=\"200\"}"),
              value("seaway_net_connections_accepted_total") - 10 - 1);
    ASSERT_TRUE(eventually([&] { return metric("seaway_net_connections") == 1; }));
    EXPECT_TRUE(eventually([&] { return *host.maps_alive == 0; }));
}

// Naive: what a map costs the peer in all is held against the patience for one piece. This reader lets
// the server wait for longer than that, but has earned it by what it has read.
TEST_F(NetMaps, who_reads_faster_than_the_least_rate_may_take_as_long_as_it_needs) {
    host.map_bytes = 8 * 1024 * 1024;
    host.map_piece_bytes = 64 * 1024;
    options.write_timeout = std::chrono::milliseconds(1200);
    options.map_bytes_per_s_min = 1024; // 8192 s for all of it
    start();
    RawPeer peer(port(), 4096);
    peer.say(ask_for_a_map);
    const std::string header = peer.header();
    const std::size_t header_bytes = header.find("\r\n\r\n") + 4;
    for (int pause = 0; pause < 18; ++pause) { // 2.1 s of them
        ASSERT_TRUE(peer.reads(host.map_bytes / 20)) << pause;
        std::this_thread::sleep_for(std::chrono::milliseconds(120));
    }
    peer.rest();
    EXPECT_TRUE(peer.ended_in_order());
    EXPECT_EQ(peer.bytes_read(), header_bytes + host.map_bytes);
}

TEST_F(NetMaps, parameters_go_to_the_sea_under_their_names) {
    host.maps_ready = true;
    start();
    using Parameters = std::map<std::string, std::string>;
    for (const auto& [target, parameters] : std::map<std::string, Parameters>{
             {"/v1/map", {}},
             {"/v1/map?columns=2", {{"columns", "2"}}},
             {"/v1/map?columns=2&rows=31&t_s=-1.5",
              {{"columns", "2"}, {"rows", "31"}, {"t_s", "-1.5"}}},
             {"/v1/map?x0_m=&kind&y0_m=a=b&rows=4",
              {{"x0_m", ""}, {"kind", ""}, {"y0_m", "a=b"}, {"rows", "4"}}}}) {
        EXPECT_EQ(get(target).status, 200) << target;
        EXPECT_EQ(host.map_parameters, parameters) << target;
    }
}

// Naive: a map that is still being let go of outlives its server, and the last that knows the server is
// the thread that lets go.
TEST_F(NetMaps, a_server_that_has_ended_has_let_go_of_every_map) {
    std::promise<void> first_ends;
    std::promise<void> stopping;
    std::atomic<int> ends = 0;
    host.on_map_end = [&, wait = stopping.get_future().share()] {
        if (++ends > 1)
            return;
        first_ends.set_value();
        wait.wait_for(std::chrono::seconds(20)); // a test that fails ends all the same
        std::this_thread::sleep_for(std::chrono::milliseconds(100)); // in the middle of a row
    };
    start();
    {
        RawPeer peers[] = {RawPeer(port()), RawPeer(port())};
        for (RawPeer& peer : peers) {
            peer.say(ask_for_a_map);
            EXPECT_TRUE(peer.header().starts_with("HTTP/1.1 200"));
        }
    }
    first_ends.get_future().wait();
    ASSERT_TRUE(eventually([&] { return metric("seaway_net_connections") == 1; }));
    EXPECT_EQ(*host.maps_alive, 2) << "the second waits for the first";
    stopping.set_value();
    net.reset();
    EXPECT_EQ(*host.maps_alive, 0);
}

TEST_F(NetMaps, who_reads_fast_enough_gets_all_of_it) {
    host.map_bytes = 8 * 1024 * 1024;
    host.map_piece_bytes = 64 * 1024;
    start();
    const HttpAnswer answer = get("/v1/map");
    EXPECT_EQ(answer.status, 200);
    EXPECT_EQ(answer.body.size(), host.map_bytes);
}

} // namespace
} // namespace seaway::tests
