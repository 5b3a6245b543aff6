// SPDX-License-Identifier: Apache-2.0
// Hostile, broken and slow clients over real loopback sockets: they end with one log line and a
// reason, and a well-behaved subscriber next to them sees no gap.
#include "tests/server/net/net_fixture.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "protocol/limits.h"
#include "tests/support/process_status.h"

namespace seaway::tests {
namespace {

using wire::Body;
using wire::ErrorCode;

/// Subscribes and reads in a thread, acknowledging everything, however long nothing comes; remembers the times it saw.
class HealthySubscriber {
  public:
    explicit HealthySubscriber(int port) : client_(port) {
        EXPECT_FALSE(client_.connect());
        EXPECT_TRUE(client_.greet());
        EXPECT_FALSE(client_.send(protocol::subscribe(1, {.fields = {sea::Field::height}}, 8)));
        EXPECT_TRUE(client_.receive(Body::FetchDone));
        thread_ = std::thread([this] { run(); });
    }
    ~HealthySubscriber() {
        enough_ = true;
        join();
    }
    /// Once its server has stopped.
    void join() {
        if (thread_.joinable())
            thread_.join();
    }
    std::int64_t seen(int cascade) const { return seen_[static_cast<std::size_t>(cascade)]; }
    /// Keyframes that did not follow their predecessor.
    int gaps() const { return gaps_; }

  private:
    void run() {
        while (!enough_) {
            const wire::Message* message = client_.receive(std::chrono::milliseconds(100));
            if (message == nullptr && client_.error() != std::errc::timed_out)
                return;
            const wire::Tile* tile = message != nullptr ? message->body_as_Tile() : nullptr;
            if (tile == nullptr)
                continue;
            const std::int64_t n = tile->time_us() / interval_us;
            auto& last = seen_.at(tile->cascade());
            if (last != 0 && n != last + 1)
                ++gaps_;
            last = n;
            if (client_.send(protocol::ack(tile->keyframe())))
                return;
        }
    }
    Client client_;
    std::array<std::atomic<std::int64_t>, 2> seen_{};
    std::atomic<int> gaps_ = 0;
    std::atomic<bool> enough_ = false;
    std::thread thread_;
};

class NetHostile : public NetTest {
  protected:
    /// Publishes keyframes [from, to) as fast as the healthy one takes them.
    void stream(HealthySubscriber& healthy, std::int64_t from, std::int64_t to) {
        for (std::int64_t n = from; n < to; ++n) {
            publish(n);
            ASSERT_TRUE(eventually([&] { return healthy.seen(0) == n && healthy.seen(1) == n; }))
                << "keyframe " << n << " did not arrive";
        }
    }
    std::size_t closed(std::string_view reason) const {
        return log.lines_with("event=session_closed", fmt::format("reason={} ", reason)).size();
    }
};

TEST_F(NetHostile, bytes_that_are_no_message_end_the_session_with_bad_message) {
    start();
    std::mt19937_64 numbers(1);
    for (int round = 0; round < 20; ++round) {
        Client client(port());
        ASSERT_FALSE(client.connect());
        if (round % 2 == 0) {
            ASSERT_TRUE(client.greet());
        }
        protocol::Bytes garbage(1 + numbers() % 3000);
        for (std::uint8_t& byte : garbage)
            byte = static_cast<std::uint8_t>(numbers());
        ASSERT_FALSE(client.send(garbage));
        EXPECT_EQ(client.close_code(), protocol::close_code(ErrorCode::bad_message));
    }
    net->stop();
    EXPECT_EQ(closed("bad_message"), 20u);
}

/// One way to be a bad client.
struct Attack {
    std::string name;
    std::function<void(RawPeer&)> act;
    std::string reason; ///< of event=session_closed, or of event=connection_refused
};

protocol::Bytes no_method_of_http() {
    std::mt19937_64 numbers(2);
    protocol::Bytes garbage(5000);
    for (std::uint8_t& byte : garbage)
        byte = static_cast<std::uint8_t>(numbers());
    garbage[0] = 0x00; // not the start of any method
    return garbage;
}

std::vector<Attack> attacks() {
    const protocol::Bytes garbage = no_method_of_http();
    const protocol::Bytes hello = protocol::hello("raw", "");
    return {
        {"random bytes instead of HTTP", [=](RawPeer& peer) { peer.say(garbage); }, "bad_http"},
        {"a header without end",
         [=](RawPeer& peer) { peer.say("GET / HTTP/1.1\r\nX: " + std::string(20'000, 'x')); },
         "bad_http"},
        {"random bytes instead of frames",
         [=](RawPeer& peer) {
             peer.upgrade();
             protocol::Bytes frames = garbage;
             frames[0] = 0xff; // reserved bits and opcode
             peer.say(frames);
         },
         "bad_message"},
        {"a frame that announces 2^62 bytes",
         [=](RawPeer& peer) {
             peer.upgrade();
             peer.say(std::string_view("\x82\xff\x40\0\0\0\0\0\0\0\0\0\0\0", 14));
         },
         "bad_message"},
        {"a frame without mask",
         [=](RawPeer& peer) {
             peer.upgrade();
             peer.say(std::string_view("\x82\x01\x00", 3));
         },
         "bad_message"},
        {"text",
         [=](RawPeer& peer) {
             peer.upgrade();
             peer.say(std::string_view("\x81\x82\0\0\0\0hi", 8));
         },
         "bad_message"},
        {"silence after the upgrade", [=](RawPeer& peer) { peer.upgrade(); }, "hello_expected"},
        {"disconnect in the middle of a frame",
         [=](RawPeer& peer) {
             peer.upgrade();
             peer.frame(hello);
             peer.frame(protocol::ping(1, 1), 20);
             peer.reset();
         },
         "disconnected"},
        {"disconnect in the middle of the upgrade",
         [=](RawPeer& peer) {
             peer.say("GET /v1/stream HTTP/1.1\r\nUpgr");
             peer.reset();
         },
         ""},
    };
}

// Naive: a name that closes its quotes and begins a line of its own is an entry of the log that nobody made.
TEST_F(NetHostile, a_name_is_logged_as_120_characters_of_one_line_without_quotes) {
    start();
    std::string name = "x\" event=change_made\n\r\x1b[2J";
    while (name.size() + 2 <= protocol::limits::hello_text_bytes_max)
        name += "\xc3\xbc"; // u with two dots
    {
        Client client(port());
        ASSERT_FALSE(client.connect());
        ASSERT_FALSE(client.send(protocol::hello(name, "")));
        ASSERT_TRUE(client.receive(Body::SeaState));
    }
    net.reset();
    const std::vector<std::string> lines = log.lines_with("event=change_made");
    ASSERT_EQ(lines.size(), 1u) << log.text();
    const std::string& line = lines.front();
    const std::size_t begin = line.find("client=\""), end = line.find("\" administrator=");
    ASSERT_NE(begin, std::string::npos) << line;
    ASSERT_NE(end, std::string::npos) << line;
    const std::string logged = line.substr(begin + 8, end - begin - 8);
    EXPECT_EQ(logged, "x? event=change_made???[2J" + std::string(120 - 26, '?'));
    EXPECT_NE(line.find("event=session_open"), std::string::npos);
    EXPECT_EQ(std::count(line.begin(), line.end(), '"'), 2) << line;
}

TEST_F(NetHostile, every_kind_of_bad_client_ends_with_one_line_and_nobody_else_notices) {
    // They hold for the healthy one, too, and for attacks that are to end otherwise.
    options.hello_deadline = options.http_deadline = std::chrono::seconds(3);
    start();
    HealthySubscriber healthy(port());
    std::int64_t n = 10;
    for (const Attack& attack : attacks()) {
        for (int round = 0; round < 3; ++round) {
            RawPeer peer(port());
            attack.act(peer);
            stream(healthy, n, n + 5);
            n += 5;
            if (attack.reason != "disconnected" && !attack.reason.empty()) {
                EXPECT_TRUE(peer.closed_by_server()) << attack.name;
            }
        }
    }
    EXPECT_TRUE(eventually([&] { return metric("seaway_net_sessions") == 1; }));
    const auto not_understood = metric("seaway_net_handshakes_failed_total");
    EXPECT_EQ(healthy.gaps(), 0);
    net->stop();
    healthy.join();
    EXPECT_EQ(not_understood, 6);
    EXPECT_EQ(log.lines_with("event=connection_refused", "reason=bad_http").size(), 1u)
        << "of one address one line in ten seconds";
    EXPECT_EQ(closed("bad_message"), 12u);
    EXPECT_EQ(closed("hello_expected"), 3u);
    EXPECT_EQ(closed("disconnected"), 3u);
    EXPECT_EQ(closed("shutting_down"), 1u);
    EXPECT_EQ(log.lines_with("event=session_closed").size(), 19u) << log.text();
}

TEST_F(NetHostile, a_client_that_never_reads_is_cut_by_its_write_and_nobody_else_notices) {
    // Replies of 160 KB each fill what the kernel holds for the stalled client; then its write
    // stands still. It has asked for no more than it may.
    options.write_timeout = std::chrono::milliseconds(300);
    start();
    HealthySubscriber healthy(port());
    RawPeer stalled(port(), 4096);
    stalled.upgrade();
    stalled.frame(protocol::hello("stalled", ""));
    const std::vector<sea::QueryPoint> points(protocol::limits::points_per_query_max);
    for (std::uint32_t id = 0; id < 16; ++id)
        stalled.frame(protocol::query(id, points, false));
    std::int64_t n = 10;
    ASSERT_TRUE(eventually([&] {
        stream(healthy, n, n + 1);
        ++n;
        return metric("seaway_net_sessions") == 1;
    }));
    EXPECT_EQ(healthy.gaps(), 0);
    net->stop();
    EXPECT_EQ(closed("too_slow"), 1u) << log.text();
    EXPECT_EQ(log.lines_with("could not be sent within 300 ms").size(), 1u)
        << "once, however many messages it was sent together: " << log.text();
}

TEST_F(NetHostile, a_client_that_is_dead_but_connected_is_cut_when_it_answers_no_ping) {
    options.idle_timeout = std::chrono::milliseconds(300);
    start();
    RawPeer dead(port());
    dead.upgrade();
    dead.frame(protocol::hello("dead", ""));
    EXPECT_TRUE(dead.closed_by_server());
    // The socket ends a moment before the session that the timeout is told to.
    EXPECT_TRUE(eventually([&] { return metric("seaway_net_sessions") == 0; }));
    net->stop();
    EXPECT_EQ(closed("idle"), 1u) << log.text();
}

TEST_F(NetHostile, a_client_that_answers_pings_is_not_cut) {
    options.idle_timeout =
        std::chrono::seconds(1); // a busy machine lets its client wait for a part of that
    start();
    bool stays = false;
    // It is this process that answers, which a busy machine may have stand still for half a second.
    for (int i = 0; i < 5 && !stays; ++i) {
        Client quiet(port());
        ASSERT_FALSE(quiet.connect());
        ASSERT_TRUE(quiet.greet());
        stays = quiet.stays_quiet_for(std::chrono::milliseconds(3000)) &&
                metric("seaway_net_sessions") == 1;
    }
    EXPECT_TRUE(stays);
}

TEST_F(NetHostile, sea_states_that_cannot_be_sent_close_the_session_as_too_slow) {
    start();
    RawPeer stalled(port(), 4096);
    stalled.upgrade();
    stalled.frame(protocol::hello("stalled", ""));
    ASSERT_TRUE(eventually([&] { return metric("seaway_net_messages_sent_total") == 2; }));
    // 100 KB each: a few fill the kernel's buffers, sixteen wait, the next is one too many.
    for (std::uint32_t epoch = 1; epoch < 60; ++epoch)
        net->announce(SmallSea::state_message(epoch, 100'000));
    EXPECT_TRUE(eventually([&] { return metric("seaway_net_sessions") == 0; }));
    net->stop();
    EXPECT_EQ(closed("too_slow"), 1u) << log.text();
}

TEST_F(NetHostile, a_flood_of_requests_without_reading_is_not_read_beyond_the_limit) {
    start();
    RawPeer flood(port(), 4096);
    flood.upgrade();
    flood.frame(protocol::hello("flood", ""));
    const std::vector<sea::QueryPoint> points(protocol::limits::points_per_query_max);
    std::thread sender([&] {
        for (std::uint32_t id = 0; id < 400; ++id)
            flood.frame(protocol::query(id, points, false));
    });
    // 400 replies are 64 MB; what waits is at most the limit, one reply and those in flight.
    const auto bound = static_cast<double>(protocol::limits::replies_bytes_max +
                                           (1 + protocol::limits::queries_in_flight_max) * 170'000);
    double most = 0;
    const auto look = [&] { return most = std::max(most, metric("seaway_net_outbox_bytes")); };
    EXPECT_TRUE(eventually(
        [&] { return look() > 0.5 * static_cast<double>(protocol::limits::replies_bytes_max); }));
    for (int i = 0; i < 50; ++i) {
        look();
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    EXPECT_LE(most, bound);
    net->stop();
    sender.join();
}

TEST_F(NetHostile, memory_stays_flat_while_stalled_and_broken_clients_come_and_go) {
    options.sessions_max = 64;
    host.size = 64;
    start();
    HealthySubscriber healthy(port());
    std::int64_t n = 10;
    const auto wave = [&] {
        std::vector<std::unique_ptr<RawPeer>> stalled;
        for (int i = 0; i < 30; ++i) {
            stalled.push_back(std::make_unique<RawPeer>(port(), 4096));
            stalled.back()->upgrade();
            stalled.back()->frame(protocol::hello("stalled", ""));
            stalled.back()->frame(protocol::subscribe(1, {.fields = {sea::Field::height}}, 8));
        }
        stream(healthy, n, n + 40);
        n += 40;
        for (std::size_t i = 0; i < stalled.size(); i += 2)
            stalled[i]->reset();
    };
    wave();
    wave(); // thread arenas and buffers have their size now
    const auto all_have_gone = [&] { return metric("seaway_net_sessions") == 1; };
    EXPECT_TRUE(eventually(all_have_gone));
    const double before = memory_bytes(getpid());
    for (int round = 0; round < 8; ++round)
        wave();
    EXPECT_TRUE(eventually(all_have_gone));
    const double grown = memory_bytes(getpid()) - before;
    EXPECT_EQ(healthy.gaps(), 0);
    // 240 sessions and 320 keyframes of 2 x 64 x 64 samples went by: 10 MB of floats and 1000 KB
    // for each session kept would show; fragmentation of the heap is below 4 MB.
#if !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__) // they keep what is freed
    EXPECT_LT(grown, 4e6);
#endif
    net->stop();
}

TEST_F(NetHostile, stop_ends_in_time_although_a_client_never_reads) {
    start();
    RawPeer stalled(port(), 4096);
    stalled.upgrade();
    stalled.frame(protocol::hello("stalled", ""));
    const std::vector<sea::QueryPoint> points(protocol::limits::points_per_query_max);
    for (std::uint32_t id = 0; id < 16; ++id)
        stalled.frame(protocol::query(id, points, false));
    ASSERT_TRUE(eventually([&] { return metric("seaway_net_queries_total") >= 8; }));
    net->stop(); // a hang here is a failure by the test's own time limit
    EXPECT_EQ(log.lines_with("event=session_closed").size(), 1u);
}

TEST_F(NetHostile, a_flood_of_bad_connections_is_not_a_flood_of_log) {
    start();
    const auto begin = std::chrono::steady_clock::now();
    for (int i = 0; i < 2000; ++i) {
        RawPeer peer(port());
        peer.say(std::string_view("\0\0\0\r\n\r\n", 7));
    }
    ASSERT_TRUE(eventually([&] { return metric("seaway_net_handshakes_failed_total") == 2000; }));
    HealthySubscriber healthy(port());
    EXPECT_TRUE(eventually([&] { return !log.lines_with("event=session_open").empty(); }))
        << "what others do is told all the same";
    net->stop();
    healthy.join();
    EXPECT_EQ(log.lines_with("event=stopping").size(), 1u);
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
    EXPECT_LE(static_cast<double>(log.lines_with("event=connection_refused").size()),
              1 + taken.count() / 10);
    EXPECT_GE(log.lines_with("event=connection_refused", "count=").size(), 1u);
}

} // namespace
} // namespace seaway::tests
