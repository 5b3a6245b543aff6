// SPDX-License-Identifier: Apache-2.0
#include "sockets/served_web_socket.h"

#include <functional>
#include <thread>

#include <boost/asio/steady_timer.hpp>
#include <gtest/gtest.h>

#include "tests/sockets/served_fixture.h"
#include "tests/support/allocations.h"

namespace seaway::sockets {
namespace {

namespace asio = boost::asio;

TEST_F(ServedWebSocketTest, many_messages_of_one_arrival_are_read_one_by_one_when_they_are_wanted) {
    FrameBytes together;
    for (int i = 0; i < 1000; ++i) // 27 KB: more than one arrival holds
        append_client_frame(together, FrameBytes(20, static_cast<std::uint8_t>(i)));
    read_max = 3;
    read_all();
    say(together);
    run_until([&] { return heard.size() == 3; });
    pair->io.restart();
    pair->io.run_for(std::chrono::milliseconds(50));
    EXPECT_EQ(heard.size(), 3u) << "nobody asked for the fourth";
    read_max = 1000;
    read_all();
    run_until([&] { return heard.size() == 1000; });
    for (std::size_t i = 0; i < heard.size(); ++i)
        ASSERT_EQ(heard[i], FrameBytes(20, static_cast<std::uint8_t>(i)));
}

TEST_F(ServedWebSocketTest, a_large_message_comes_whole_in_many_arrivals) {
    FrameBytes large(100'000);
    for (std::size_t i = 0; i < large.size(); ++i)
        large[i] = static_cast<std::uint8_t>(i % 251);
    read_all();
    say(client_frame(large));
    run_until([&] { return heard.size() == 1; });
    EXPECT_EQ(heard[0], large);
}

TEST_F(ServedWebSocketTest, pings_are_answered_with_what_they_say) {
    read_all();
    say(client_frame(FrameBytes{'o', 'n', 'e'}, {.opcode = 9}));
    const std::string pong("\x8a\x03one", 5);
    run_until([&] { return answer.size() >= pong.size(); });
    EXPECT_EQ(answer, pong);
}

// RFC 6455, 5.5.3: the last ping is the one that must be answered; what waits for a peer that reads nothing is one pong.
TEST_F(ServedWebSocketTest, a_flood_of_pings_to_which_nobody_listens_leaves_one_answer_waiting) {
    const FrameBytes message(90'000, 'm');
    const std::vector<std::span<const std::uint8_t>> spans(300,
                                                           message); // 27 MB: no socket takes it
    bool written = false;
    ASSERT_FALSE(server->begin(spans));
    finish(*server, [&] { written = true; });
    FrameBytes pings;
    for (int i = 0; i < 5000; ++i)
        append_client_frame(pings, FrameBytes{'p', static_cast<std::uint8_t>('0' + i % 10)},
                            {.opcode = 9});
    append_client_frame(pings, FrameBytes{'x'});
    read_all();
    say(pings);
    const auto last_pong_is_9 = [&] { // wherever it came, between two messages
        const std::size_t at = answer.rfind("\x8a\x02p");
        return at != std::string::npos && answer.compare(at + 3, 1, "9") == 0;
    };
    run_until([&] { return written && heard.size() == 1 && last_pong_is_9(); });
    std::size_t pongs = 0;
    for (std::size_t at = answer.find("\x8a\x02p"); at != std::string::npos;
         at = answer.find("\x8a\x02p", at + 1))
        ++pongs;
    EXPECT_LE(pongs, 5000u / 600u) << "a few for each arrival, not one for each ping";
}

/// From now on the peer takes nothing, and the system has room for nothing more.
class ServedWebSocketNobodyReads : public ServedWebSocketTest {
  protected:
    void fill() {
        listens = false;
        const std::vector<std::span<const std::uint8_t>> spans(300, message);
        ASSERT_FALSE(server->begin(spans));
        go_on();
        for (int quiet = 0; quiet < 3;) { // the system makes more room for a while
            const int before = pieces;
            run_for(std::chrono::milliseconds(50));
            quiet = before == pieces ? quiet + 1 : 0;
        }
    }
    /// One piece after another, so that one is always under way.
    void go_on() {
        server->finish([this](const Result<bool>& all) {
            ++pieces;
            if (all && !*all)
                go_on();
        });
    }
    int pieces = 0;
    void run_for(std::chrono::milliseconds time) {
        pair->io.restart();
        pair->io.run_for(time);
        pair->io.restart();
        pair->io.poll(); // who stood still for that long has run nothing
    }
    const FrameBytes ping = client_frame(FrameBytes{'p'}, {.opcode = 9});
    const FrameBytes message = FrameBytes(90'000, 'm');
};

// Naive: each ping is read, and renews the patience with a peer that has taken nothing for hours.
TEST_F(ServedWebSocketNobodyReads, who_takes_no_answers_is_not_read_from_until_he_does) {
    fill();
    read_all();
    say(ping);
    run_for(std::chrono::milliseconds(50));
    say(client_frame(FrameBytes{'a'}));
    run_until([&] { return heard.size() == 1; }); // one answer lies there
    say(ping);
    run_for(std::chrono::milliseconds(50));
    say(client_frame(FrameBytes{'b'}));
    run_for(std::chrono::milliseconds(200));
    EXPECT_EQ(heard.size(), 1u) << "and one more";
    listens = true;
    listen();
    run_until([&] { return heard.size() == 2; });
    EXPECT_FALSE(end);
}

TEST_F(ServedWebSocketNobodyReads, who_pings_without_end_and_takes_no_answer_is_given_up) {
    accept(std::chrono::milliseconds(400));
    fill();
    read_all();
    asio::steady_timer again(pair->io);
    const std::function<void(error_code)> say_again = [&](error_code) {
        if (end)
            return;
        say(ping);
        again.expires_after(std::chrono::milliseconds(20));
        again.async_wait(say_again);
    };
    say_again({});
    run_until([&] { return end.has_value(); });
    ASSERT_TRUE(end);
    EXPECT_TRUE(end->is(WebSocketEnd::unread)) << end->message;
    EXPECT_EQ(end->message, "pings and pongs could not be sent within 400 ms");
}

TEST_F(ServedWebSocketNobodyReads, who_is_closed_while_he_is_not_read_from_ends_with_an_error) {
    fill();
    read_all();
    say(ping);
    run_for(std::chrono::milliseconds(50));
    say(ping);
    run_for(std::chrono::milliseconds(50));
    server->socket().close();
    EXPECT_FALSE(end) << "never within the call";
    run_until([&] { return end.has_value(); });
    EXPECT_TRUE(end->is(WebSocketEnd::broken)) << end->message;
}

// Of 27 MB some 64 KiB at a time, whole messages: so that who sends can tell a slow reader from one that has stopped.
TEST_F(ServedWebSocketTest, what_a_slow_reader_takes_is_told_piece_by_piece) {
    const FrameBytes message(90'000, 'm');
    const std::vector<std::span<const std::uint8_t>> spans(300, message);
    ASSERT_FALSE(server->begin(spans));
    int pieces = 0;
    bool all = false;
    const std::function<void(const Result<bool>&)> next = [&](const Result<bool>& done) {
        ++pieces;
        all = done.value();
        if (!all)
            server->finish(next);
    };
    server->finish(next);
    read_all();
    run_until([&] { return all; });
    EXPECT_GT(pieces, 100) << "the system takes a few MB at once";
    EXPECT_LE(pieces, 300);
}

TEST_F(ServedWebSocketTest, who_closes_is_answered_with_the_same_code_and_the_stream_ends) {
    read_all();
    say(client_frame(FrameBytes{0x03, 0xe9, 'b', 'y', 'e'}, {.opcode = 8}));
    run_until([&] { return end.has_value(); });
    EXPECT_TRUE(end->is(WebSocketEnd::closed));
    EXPECT_EQ(server->peer_close().code, 1001u);
    EXPECT_EQ(server->peer_close().reason, "bye");
    bool left = false;
    server->leave([&] { left = true; });
    run_until([&] { return gone; });
    EXPECT_EQ(answer, std::string("\x88\x02\x03\xe9", 4));
    EXPECT_FALSE(left) << "the peer is still there";
    pair->ends[1]->close();
    run_until([&] { return left; });
}

TEST_F(ServedWebSocketTest, what_is_not_understood_is_told_so_by_its_code) {
    read_all();
    say({0x82, 0x01, 0x00});
    run_until([&] { return end.has_value(); });
    EXPECT_TRUE(end->is(WebSocketEnd::not_understood)) << end->message;
    server->leave([] {});
    run_until([&] { return gone; });
    EXPECT_EQ(answer, std::string("\x88\x02\x03\xea", 4)); // 1002
}

// Naive: closed with a part of the message unread, where the system has the peer throw away why.
TEST_F(ServedWebSocketTest, who_goes_on_with_a_message_that_is_too_large_hears_why_before_the_end) {
    read_all();
    say(client_frame(FrameBytes(2'000'000)));
    run_until([&] { return end.has_value(); });
    EXPECT_TRUE(end->is(WebSocketEnd::not_understood)) << end->message;
    bool left = false;
    server->leave([&] { left = true; });
    run_until([&] { return gone; });
    EXPECT_EQ(answer, std::string("\x88\x02\x03\xf1", 4)); // 1009
    EXPECT_TRUE(in_order) << "FIN, not RST";
    EXPECT_FALSE(left) << "the peer is still there";
    pair->ends[1]->close();
    run_until([&] { return left; });
}

TEST_F(ServedWebSocketTest, who_never_ends_is_left_when_enough_of_it_was_taken) {
    accept(std::chrono::seconds(10), std::chrono::minutes(10)); // longer than a test waits
    read_all();
    say(client_frame(FrameBytes(3 * Socket::parted_bytes_max)));
    run_until([&] { return end.has_value(); });
    bool left = false;
    server->leave([&] { left = true; });
    run_until([&] { return left; });
}

TEST_F(ServedWebSocketTest, a_peer_that_says_nothing_is_pinged_and_given_up) {
    accept(std::chrono::milliseconds(200));
    read_all();
    run_until([&] { return end.has_value(); });
    EXPECT_TRUE(end->is(WebSocketEnd::silent)) << end->message;
    EXPECT_EQ(answer.substr(0, 2), std::string("\x89\x00", 2))
        << "a ping, and more where this machine stood still";
}

// Naive: a process that was stopped for a while, or its machine, ends everybody for silence before it has looked at what they
// said meanwhile.
TEST_F(ServedWebSocketTest, who_was_not_heard_because_the_process_stood_still_is_pinged_first) {
    accept(std::chrono::milliseconds(400));
    read_all();
    const std::string ping("\x89\x00", 2);
    run_until([&] { return !answer.empty(); });
    EXPECT_EQ(answer.substr(0, 2), ping) << "asked already";
    const std::size_t asked = answer.size(); // more often where this machine stood still
    std::this_thread::sleep_for(std::chrono::milliseconds(700)); // nothing runs
    run_until([&] { return answer.size() >= asked + 2 || end; });
    EXPECT_FALSE(end);
    EXPECT_EQ(answer.substr(asked, 2), ping) << "asked anew";
    say(client_frame(FrameBytes{'h'}));
    run_until([&] { return end || !heard.empty(); });
    EXPECT_FALSE(end);
    run_until([&] { return end.has_value(); });
    EXPECT_TRUE(end->is(WebSocketEnd::silent)) << "and who stays silent is given up as before";
}

// Naive: it is taken to be heard later than now, and when the timer looks next all of its patience is over.
TEST_F(ServedWebSocketTest, who_speaks_behind_a_standstill_is_pinged_before_it_is_given_up) {
    accept(std::chrono::milliseconds(400));
    read_all();
    std::this_thread::sleep_for(std::chrono::milliseconds(700));
    say(client_frame(FrameBytes{'a'}));
    run_until([&] { return !heard.empty(); });
    say(client_frame(FrameBytes{'b'}));
    run_until([&] { return !answer.empty() || end; });
    EXPECT_FALSE(end);
    EXPECT_EQ(answer.substr(0, 2), std::string("\x89\x00", 2))
        << "a ping, and more where this machine stood still";
}

TEST_F(ServedWebSocketTest, who_is_not_listened_to_is_not_silent) {
    accept(std::chrono::milliseconds(100));
    pair->io.restart();
    pair->io.run_for(std::chrono::milliseconds(400));
    read_all();
    say(client_frame(FrameBytes{'h'}));
    run_until([&] { return end || !heard.empty(); });
    EXPECT_FALSE(end);
}

// Naive: a look at the silence that was on its way when the peer closed takes over the timer that ends the wait for it.
TEST_F(ServedWebSocketTest,
       who_closes_and_stays_is_left_in_time_also_when_silence_is_looked_at_just_then) {
    accept(std::chrono::milliseconds(200), std::chrono::milliseconds(300));
    bool left = false;
    server->read([&](const Result<ServedWebSocket::Message>& message) {
        EXPECT_FALSE(message);
        server->leave([&] { left = true; });
    });
    say(client_frame(FrameBytes{0x03, 0xe8}, {.opcode = 8}));
    // The frame is there and the timer, of half the patience, has run out before the loop looks at either.
    std::this_thread::sleep_for(std::chrono::milliseconds(150));
    run_until([&] { return left; });
    EXPECT_TRUE(left);
}

// Naive: the handler that hears of the end is put into memory of its own, inside of a function that may not throw.
TEST_F(ServedWebSocketTest, closing_takes_no_memory) {
    read_all();
    run_until([&] { return true; });
    for (int i = 0; i < 16; ++i) // what Asio keeps of blocks that were given back is taken
        asio::post(pair->io, [held = std::array<char, 64>{}] { (void)held; });
    {
        const tests::NoMemoryOnce none(0);
        const tests::Allocations allocations;
        server->socket().close();
        EXPECT_EQ(allocations.count(), 0u);
    }
    EXPECT_FALSE(end) << "not within the call";
    run_until([&] { return end.has_value(); });
}

TEST_F(ServedWebSocketTest, a_peer_that_is_gone_ends_what_is_read) {
    read_all();
    pair->ends[1]->close();
    run_until([&] { return end.has_value(); });
    EXPECT_TRUE(end->is(WebSocketEnd::broken)) << end->message;
}

// Closed while it reads: the reader is told, and nothing keeps the loop from its end.
TEST_F(ServedWebSocketTest, what_is_under_way_when_it_is_closed_ends_with_an_error) {
    read_all();
    server->socket().close();
    EXPECT_FALSE(end) << "never within the call";
    run_until([&] { return end.has_value(); });
    EXPECT_TRUE(end->is(WebSocketEnd::broken)) << end->message;
}

} // namespace
} // namespace seaway::sockets
