// SPDX-License-Identifier: Apache-2.0
// Whose turn it is on the io thread: between the sessions that are sent a keyframe others are read and answered.
#include <algorithm>
#include <deque>
#include <functional>
#include <list>
#include <new>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "server/net/core.h"
#include "server/net/session.h"
#include "tests/server/simulation/small_sea.h"

namespace seaway::tests {
namespace {

/// A connection that takes everything at once.
class OpenLink final : public server::Link {
  public:
    void send_more() override {
        while (const protocol::SharedBytes message = session->next_message()) {
            const wire::Message& said = *wire::GetMessage(message->data());
            if (const auto* tile = said.body_as_Tile()) {
                tiles_of.push_back(tile->time_us());
                order += 'k';
            } else if (said.body_as_SeaState() != nullptr) {
                order += 's';
            }
        }
    }
    void drop() noexcept override {}
    void close(protocol::SharedBytes, wire::ErrorCode, const std::string&) override {}

    std::vector<sea::TimeUs> tiles_of;
    std::string order; ///< of tiles and seas
    server::Session* session = nullptr;
};

/// Sessions that are subscribed, and an io thread made of turns by hand.
class NetTurns : public ::testing::Test {
  protected:
    void take_in(int sessions) {
        sea.answer_fetches = false; // what streams alone is counted
        for (int i = 0; i < sessions; ++i) {
            OpenLink& link = links.emplace_back();
            link.session = &sessions_.emplace_back(*core, link, peer, server::Standing::stranger);
            link.session->receive(protocol::hello("test", ""));
            link.session->receive(protocol::subscribe(
                1, {.cascades = 1u, .fields = {sea::Field::height}, .error_m = 0}, 3));
            EXPECT_EQ(std::exchange(link.order, ""), "s") << "the sea that it is told of first";
        }
    }
    void deliver(sea::TimeUs time_us, protocol::SharedBytes sea_state = {}) {
        auto keyframe = std::make_shared<sea::Keyframe>(*sea.keyframe(0, 1, sea.offered).keyframe);
        keyframe->time_us = time_us;
        const std::vector<float> lossless(sea.offered.size(), 0.0f);
        core->deliveries.add(
            {*encoder.encode(*keyframe, lossless, 0, sea.offered), {}, std::move(sea_state)});
    }
    /// Works that were posted; false: there was none.
    bool one_turn() {
        if (posted.empty())
            return false;
        const server::Core::Work work = std::move(posted.front());
        posted.pop_front();
        work();
        return true;
    }
    std::size_t told() const {
        return static_cast<std::size_t>(
            std::ranges::count_if(links, [](const OpenLink& link) { return link.order == "s"; }));
    }
    std::size_t sent() const {
        std::size_t count = 0;
        for (const OpenLink& link : links)
            count += link.tiles_of.size();
        return count;
    }

    /// A clock by which a turn has room for so many.
    static constexpr std::size_t a_turn = 4;
    server::Turns::Clock::time_point clock;
    SmallSea sea;
    std::deque<server::Core::Work> posted;
    std::shared_ptr<server::Core> core = std::make_shared<server::Core>(
        server::NetOptions{}, sea,
        [this](server::Core::Work work) { posted.push_back(std::move(work)); },
        [this] { return clock += server::Turns::length / a_turn; });
    server::Peer peer{"test", std::make_shared<server::Address>("test", core->options), true,
                      false};
    server::Encoder encoder;
    std::list<OpenLink> links;
    std::list<server::Session> sessions_;
};

// Naive: all of them in one go: with a thousand clients each answer waits for up to 20 ms.
TEST_F(NetTurns, a_keyframe_goes_to_some_sessions_at_a_time_and_then_others_have_their_turn) {
    take_in(3 * a_turn - 1);
    deliver(1000);
    ASSERT_TRUE(one_turn());
    EXPECT_EQ(sent(), a_turn);
    bool others_had_theirs = false;
    core->post([&] { others_had_theirs = true; });
    ASSERT_TRUE(one_turn());
    EXPECT_EQ(sent(), 2 * a_turn);
    ASSERT_TRUE(one_turn());
    EXPECT_TRUE(others_had_theirs) << "before the third turn";
    while (one_turn())
        continue;
    EXPECT_EQ(sent(), 3 * a_turn - 1);
    for (const OpenLink& link : links)
        EXPECT_EQ(link.tiles_of.size(), 1u) << "each of them once";
}

TEST_F(NetTurns, who_leaves_and_who_comes_between_two_turns_is_in_nobodys_way) {
    take_in(2 * a_turn);
    deliver(1000);
    ASSERT_TRUE(one_turn());
    auto leaves = std::next(sessions_.begin(), a_turn);
    sessions_.begin()->end("test", "has been sent it");
    leaves->end("test", "would have been next");
    take_in(1);
    while (one_turn())
        continue;
    EXPECT_EQ(sent(), 2 * a_turn - 1 + 1) << "but for the one that left before its turn";
    EXPECT_EQ(links.back().tiles_of.size(), 1u);
}

TEST_F(NetTurns, keyframes_come_to_everybody_in_the_order_in_which_they_were_made) {
    take_in(a_turn + 1);
    deliver(1000);
    deliver(2000);
    while (one_turn())
        continue;
    for (const OpenLink& link : links)
        EXPECT_EQ(link.tiles_of, (std::vector<sea::TimeUs>{1000, 2000}));
}

// Naive: all of them in one go: new grants for a thousand sessions, while nobody is read.
TEST_F(NetTurns,
       a_change_of_the_sea_is_told_to_some_sessions_at_a_time_and_then_others_have_their_turn) {
    take_in(3 * a_turn - 1);
    core->deliveries.announce(SmallSea::state_message(1));
    ASSERT_TRUE(one_turn());
    EXPECT_EQ(told(), a_turn);
    bool others_had_theirs = false;
    core->post([&] { others_had_theirs = true; });
    ASSERT_TRUE(one_turn());
    EXPECT_EQ(told(), 2 * a_turn);
    ASSERT_TRUE(one_turn());
    EXPECT_TRUE(others_had_theirs) << "before the third turn";
    while (one_turn())
        continue;
    EXPECT_EQ(told(), 3 * a_turn - 1);
}

// Naive: what clients have to know before it begins waits behind keyframes, which may be left out.
TEST_F(NetTurns, each_session_is_told_of_a_sea_once_and_before_all_keyframes_that_wait) {
    take_in(2 * a_turn);
    const protocol::SharedBytes next = SmallSea::state_message(1);
    deliver(1000);
    core->deliveries.announce(next);
    deliver(2000, next);
    while (one_turn())
        continue;
    for (const OpenLink& link : links)
        EXPECT_EQ(link.order, "skk");
    const protocol::SharedBytes unannounced = SmallSea::state_message(2);
    deliver(3000, unannounced);
    while (one_turn())
        continue;
    core->deliveries.announce(unannounced); // which the keyframe has brought along
    while (one_turn())
        continue;
    for (const OpenLink& link : links)
        EXPECT_EQ(link.order, "skksk");
}

/// Turns alone, on a clock that is set by who is at work.
class TurnsAlone : public ::testing::Test {
  protected:
    server::Turns::Work takes(int share_of_a_turn, char name) {
        return [this, share_of_a_turn, name] {
            done += name;
            clock += server::Turns::length / share_of_a_turn;
        };
    }
    std::string one() {
        done.clear();
        if (posted.empty())
            return "none";
        const server::Turns::Work turn = std::move(posted.front());
        posted.pop_front();
        turn();
        return done;
    }

    server::Turns::Clock::time_point clock;
    std::deque<server::Turns::Work> posted;
    bool no_memory = false;
    server::Turns turns{[this](server::Turns::Work turn) {
                            if (no_memory)
                                throw std::bad_alloc();
                            posted.push_back(std::move(turn));
                        },
                        [this] { return clock; }};
    std::string done;
};

// Naive: who is sent a keyframe takes the whole turn, and the rest of what others are sent waits for its end.
TEST_F(TurnsAlone, keyframes_and_all_else_have_a_length_each_and_one_work_at_least) {
    turns.first(takes(1, 'k'));
    for (const char name : {'a', 'b', 'c', 'd'})
        turns.later(takes(2, name));
    turns.later(takes(1, 'e'));
    EXPECT_EQ(posted.size(), 1u) << "one turn for all";
    EXPECT_EQ(one(), "kab");
    turns.first(takes(100, 'k'));
    EXPECT_EQ(one(), "kcd");
    EXPECT_EQ(one(), "e") << "longer than a turn";
    EXPECT_EQ(one(), "none");
}

TEST_F(TurnsAlone, what_work_asks_for_comes_in_the_next_turn_and_after_what_waits) {
    turns.later([&] {
        takes(4, 'a')();
        turns.first(takes(4, 'k'));
        turns.later(takes(4, 'c'));
    });
    turns.later(takes(1, 'b'));
    EXPECT_EQ(one(), "ab");
    EXPECT_EQ(one(), "kc");
    EXPECT_EQ(one(), "none");
}

// Naive: who has a work behind each of his works has the whole turn, and nobody is read meanwhile.
TEST_F(TurnsAlone, who_asks_again_and_again_has_one_work_a_turn) {
    const std::function<void()> again = [&] {
        takes(100, 'a')();
        turns.later(again);
    };
    turns.later(again);
    turns.later(takes(100, 'b'));
    EXPECT_EQ(one(), "ab");
    EXPECT_EQ(one(), "a");
    turns.clear();
}

TEST_F(TurnsAlone, whom_memory_fails_takes_nobody_elses_turn) {
    turns.later([] { throw std::bad_alloc(); });
    turns.later(takes(1, 'a'));
    EXPECT_THROW(one(), std::bad_alloc);
    EXPECT_EQ(one(), "a");
    no_memory = true;
    EXPECT_THROW(turns.later(takes(1, 'b')), std::bad_alloc);
    no_memory = false;
    turns.later(takes(1, 'c'));
    EXPECT_EQ(one(), "b");
    EXPECT_EQ(one(), "c");
    turns.later([&] {
        takes(1, 'd')();
        no_memory = true; // for the turn after this one
    });
    turns.later(takes(1, 'e'));
    EXPECT_EQ(one(), "d");
    no_memory = false;
    EXPECT_EQ(one(), "none");
    turns.go_on();
    EXPECT_EQ(one(), "e") << "which the server's watch sees to";
    turns.go_on();
    EXPECT_EQ(one(), "none") << "nothing waits";
    turns.later(takes(1, 'd'));
    turns.clear();
    EXPECT_EQ(one(), "");
}

} // namespace
} // namespace seaway::tests
