// SPDX-License-Identifier: Apache-2.0
// Of many messages of one arrival some are given, and then others have their turn.
#include <algorithm>
#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <new>
#include <utility>

#include <boost/asio/post.hpp>
#include <gtest/gtest.h>

#include "tests/sockets/served_fixture.h"

namespace seaway::sockets {
namespace {

using ServedTurns = ServedWebSocketTest;

// Naive: all of an arrival in one go, and then the next: hundreds of messages before anybody else is looked at.
TEST_F(ServedTurns, of_a_flood_of_messages_a_few_are_given_and_then_others_have_their_turn) {
    constexpr std::size_t count = 4000; // 104 KB
    FrameBytes flood;
    for (std::size_t i = 0; i < count; ++i)
        append_client_frame(flood, FrameBytes(20, static_cast<std::uint8_t>(i)));
    std::size_t before = 0, most = 0;
    const std::function<void()> others = [&] {
        most = std::max(most, heard.size() - std::exchange(before, heard.size()));
        if (heard.size() < count)
            boost::asio::post(pair->io, others);
    };
    boost::asio::post(pair->io, others);
    read_all();
    say(flood);
    run_until([&] { return heard.size() == count; });
    // What is left of one arrival, and the beginning of the next.
    EXPECT_LE(most, 2u * ServedWebSocket::messages_a_turn);
    for (std::size_t i = 0; i < heard.size(); ++i)
        ASSERT_EQ(heard[i], FrameBytes(20, static_cast<std::uint8_t>(i))) << "in order";
}

TEST_F(ServedTurns, what_is_left_of_many_messages_waits_for_the_turn_that_it_is_given) {
    std::deque<std::function<void()>> turns;
    later = [&](std::function<void()> work) { turns.push_back(std::move(work)); };
    accept();
    constexpr std::size_t a_turn = ServedWebSocket::messages_a_turn;
    FrameBytes many;
    for (std::size_t i = 0; i < 2 * a_turn + 3; ++i)
        append_client_frame(many, FrameBytes(20, static_cast<std::uint8_t>(i)));
    FrameBytes part;
    append_client_frame(part, FrameBytes(20));
    many.insert(many.end(), part.begin(), part.begin() + 10);
    read_all();
    say(many);
    for (const std::size_t given : {a_turn, 2 * a_turn, 2 * a_turn + 3}) {
        run_until([&] { return heard.size() >= given; });
        pair->io.restart();
        pair->io.run_for(std::chrono::milliseconds(20));
        EXPECT_EQ(heard.size(), given);
        ASSERT_EQ(turns.size(), given < 2 * a_turn + 3 ? 1u : 0u);
        if (turns.empty())
            break;
        const std::function<void()> turn = std::move(turns.front());
        turns.pop_front();
        turn();
    }
    EXPECT_EQ(last_of_a_turn, (std::vector<std::size_t>{a_turn, 2 * a_turn, 2 * a_turn + 3}))
        << "whoever answers some together knows when there are no more";
    say({part.begin() + 10, part.end()});
    run_until([&] { return heard.size() == 2 * a_turn + 4; });
}

// Naive: a reader that owns the socket, as those of connections do, is held by it from then on, and nobody hears of its end.
TEST_F(ServedTurns, who_reads_on_and_then_finds_no_memory_is_not_held) {
    const auto owner = std::make_shared<char>();
    server->read([this, owner](const Result<ServedWebSocket::Message>&) {
        server->read([owner](const Result<ServedWebSocket::Message>&) {});
        throw std::bad_alloc();
    });
    say(client_frame(FrameBytes(20)));
    pair->io.restart();
    EXPECT_THROW(pair->io.run_for(std::chrono::seconds(20)), std::bad_alloc);
    EXPECT_EQ(owner.use_count(), 1);
    read_all();
    say(client_frame(FrameBytes(21)));
    run_until([&] { return heard.size() == 1; });
    EXPECT_EQ(heard[0].size(), 21u) << "the next one goes to who reads then";
}

TEST_F(ServedTurns, who_is_closed_while_what_he_said_waits_ends_with_an_error) {
    std::deque<std::function<void()>> turns;
    later = [&](std::function<void()> work) { turns.push_back(std::move(work)); };
    accept();
    FrameBytes many;
    for (int i = 0; i < 100; ++i)
        append_client_frame(many, FrameBytes(20));
    read_all();
    say(many);
    run_until([&] { return !turns.empty(); });
    server->socket().close();
    EXPECT_FALSE(end) << "never within the call";
    turns.front()();
    ASSERT_TRUE(end);
    EXPECT_TRUE(end->is(WebSocketEnd::broken)) << end->message;
    EXPECT_EQ(heard.size(), std::size_t{ServedWebSocket::messages_a_turn});
}

} // namespace
} // namespace seaway::sockets
