// SPDX-License-Identifier: Apache-2.0
// Bulk maps as the net serves them: who leaves, who reads slowly, and that nobody else waits for it.
#include <array>
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
    host.map_bytes_all = 64 * 1024 * 1024;
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
        const HttpAnswer answer = get("/v1/map");
        EXPECT_EQ(answer.status, 503);
        EXPECT_EQ(answer.body, "later\n");
    }
    ASSERT_TRUE(eventually([&] { return metric("seaway_net_connections") == 1; }));
    EXPECT_EQ(metric("seaway_net_connections_refused_total{reason=\"server_full\"}"), 0);
    EXPECT_EQ(metric("seaway_net_http_responses_total{status=\"503\"}"), 10);
    host.is_busy = false;
    host.maps_ready = true;
    for (int i = 0; i < 10; ++i)
        EXPECT_EQ(get("/v1/map").status, 200);
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

// Naive: the surface is made, and a place taken, before anybody looks at the method.
TEST_F(NetMaps, head_says_how_long_a_map_is_and_nothing_of_it_is_made) {
    host.is_busy = true;
    start();
    const HttpAnswer answer = get("/v1/map?columns=2", "HEAD");
    EXPECT_EQ(answer.status, 200);
    EXPECT_EQ(answer.body, "");
    EXPECT_EQ(answer.fields.at("Content-Length"), std::to_string(host.map_bytes_all));
    EXPECT_EQ(answer.fields.at("Content-Type"), "application/vnd.seaway.map");
    EXPECT_EQ(get("/v1/map?colour=blue", "HEAD").status, 400);
    EXPECT_EQ(host.maps_asked, 0);
}

// Two who read, but hardly: 4 KB at a time, whenever they like.
class SlowReaders {
  public:
    explicit SlowReaders(int port) {
        for (auto& peer : peers_) {
            peer = std::make_unique<RawPeer>(port, 4096);
            peer->say(ask_for_a_map);
            EXPECT_TRUE(peer->header().starts_with("HTTP/1.1 200"));
        }
        readers_[0] = std::thread([this] { read(*peers_[0]); });
        readers_[1] = std::thread([this] { read(*peers_[1]); });
    }
    ~SlowReaders() {
        enough_ = true;
        for (std::thread& reader : readers_)
            reader.join();
    }
    SlowReaders(const SlowReaders&) = delete;
    SlowReaders& operator=(const SlowReaders&) = delete;
    int cut_off() const { return cut_off_; }

  private:
    void read(RawPeer& peer) {
        while (!enough_ && peer.reads(4096))
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        cut_off_ += enough_ ? 0 : 1;
    }
    std::array<std::unique_ptr<RawPeer>, 2> peers_;
    std::array<std::thread, 2> readers_;
    std::atomic<bool> enough_ = false;
    std::atomic<int> cut_off_ = 0;
};

// Naive: who reads a little above the least rate keeps its place for an hour, and two of them both.
TEST_F(NetMaps, of_two_slow_readers_one_gives_way_to_a_third) {
    host.map_bytes_all = 64 * 1024 * 1024;
    host.map_piece_bytes = 64 * 1024;
    options.map_patience = std::chrono::milliseconds(100);
    start();
    const SlowReaders slow(port());
    ASSERT_TRUE(eventually([&] { return get("/v1/map").status == 200; })) << "a third has its turn";
    EXPECT_TRUE(eventually([&] { return slow.cut_off() == 1; }));
    EXPECT_EQ(slow.cut_off(), 1) << "the other one stays";
}

// Naive: the place is given on while the threads of the map that gave way still run.
TEST_F(NetMaps, a_place_comes_back_once_its_map_has_ended_and_nobody_waits_for_that) {
    std::promise<void> ends;
    std::promise<void> may_end;
    std::atomic<int> ended = 0;
    host.on_map_end = [&, wait = may_end.get_future().share()] {
        if (++ended > 1)
            return;
        ends.set_value();
        wait.wait_for(std::chrono::seconds(20)); // a test that fails ends all the same
    };
    host.map_bytes_all = 64 * 1024 * 1024;
    host.map_piece_bytes = 64 * 1024;
    options.map_patience = std::chrono::milliseconds(0);
    start();
    const SlowReaders slow(port());
    std::unique_ptr<RawPeer> third;
    std::future<void> one_ends = ends.get_future();
    const auto asked_until_one_ends = [&] { // refused as long as nobody is behind
        third = std::make_unique<RawPeer>(port());
        third->say(ask_for_a_map);
        return one_ends.wait_for(std::chrono::seconds(3)) == std::future_status::ready;
    };
    std::this_thread::sleep_for(std::chrono::milliseconds(300)); // until they are behind
    ASSERT_TRUE(eventually(asked_until_one_ends));
    EXPECT_EQ(get("/healthz").status, 200);
    EXPECT_EQ(host.maps_asked, 2) << "the third waits for the place";
    may_end.set_value();
    EXPECT_TRUE(third->header().starts_with("HTTP/1.1 200"));
    EXPECT_EQ(host.maps_asked, 3);
    net.reset(); // before what its maps call when they end
}

TEST_F(NetMaps, who_waits_for_rows_is_not_behind_and_keeps_its_place) {
    start(); // no row is ever ready
    std::vector<std::unique_ptr<RawPeer>> peers;
    for (int i = 0; i < 2; ++i) {
        peers.push_back(std::make_unique<RawPeer>(port()));
        peers.back()->say(ask_for_a_map);
        EXPECT_TRUE(peers.back()->header().starts_with("HTTP/1.1 200"));
    }
    std::this_thread::sleep_for(options.map_patience);
    for (int i = 0; i < 3; ++i) {
        const HttpAnswer answer = get("/v1/map");
        EXPECT_EQ(answer.status, 503);
        EXPECT_EQ(answer.fields.at("Retry-After"), "1");
    }
    EXPECT_EQ(host.maps_asked, 2);
    peers.clear();
    host.maps_ready = true;
    EXPECT_TRUE(eventually([&] { return get("/v1/map").status == 200; }));
}

TEST_F(NetMaps, one_for_which_there_is_no_memory_ends_short_and_gives_its_place_back) {
    host.maps_fail = true;
    start();
    for (int i = 0; i < 4; ++i) {
        RawPeer peer(port());
        peer.say(ask_for_a_map);
        EXPECT_TRUE(peer.header().starts_with("HTTP/1.1 200")) << i;
        EXPECT_EQ(peer.rest(), "");
        ASSERT_TRUE(eventually([&] { return *host.maps_alive == 0; }));
    }
}

// Naive: what a map costs the peer in all is held against the patience for one piece. This reader lets
// the server wait for longer than that, but has earned it by what it has read.
TEST_F(NetMaps, who_reads_faster_than_the_least_rate_may_take_as_long_as_it_needs) {
    host.map_bytes_all = 8 * 1024 * 1024;
    host.map_piece_bytes = 64 * 1024;
    options.write_timeout = std::chrono::seconds(4); // many times a pause
    options.map_bytes_per_s_min = 1024;              // 8192 s for all of it
    start();
    RawPeer peer(port(), 4096);
    peer.say(ask_for_a_map);
    const std::string header = peer.header();
    const std::size_t header_bytes = header.find("\r\n\r\n") + 4;
    for (int pause = 0; pause < 19; ++pause) { // 6.1 s of them
        ASSERT_TRUE(peer.reads(host.map_bytes_all / 20)) << pause;
        std::this_thread::sleep_for(std::chrono::milliseconds(320));
    }
    peer.rest();
    EXPECT_TRUE(peer.ended_in_order());
    EXPECT_EQ(peer.bytes_read(), header_bytes + host.map_bytes_all);
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
    host.map_bytes_all = 8 * 1024 * 1024;
    host.map_piece_bytes = 64 * 1024;
    start();
    const HttpAnswer answer = get("/v1/map");
    EXPECT_EQ(answer.status, 200);
    EXPECT_EQ(answer.body.size(), host.map_bytes_all);
}

} // namespace
} // namespace seaway::tests
