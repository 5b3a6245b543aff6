// SPDX-License-Identifier: Apache-2.0
// Acknowledgements as a session takes them: the window that they give back, and what they cannot do. Without sockets.
#include <algorithm>

#include <gtest/gtest.h>

#include "server/net/core.h"
#include "server/net/session.h"
#include "tests/server/simulation/small_sea.h"

namespace seaway::tests {
namespace {

/// A connection that takes everything at once.
class Line final : public server::Link {
  public:
    void send_more() override {
        while (const protocol::SharedBytes message = session->next_message()) {
            session->sent();
            if (const auto* tile = wire::GetMessage(message->data())->body_as_Tile()) {
                streamed.push_back(tile->keyframe());
                fields.insert(static_cast<sea::Field>(tile->field()));
            }
        }
    }
    void drop() noexcept override {}
    void close(protocol::SharedBytes go_away, wire::ErrorCode code,
               const std::string& why) override {
        ended = code;
        ended_why = why;
        EXPECT_TRUE(wire::GetMessage(go_away->data())->body_as_GoAway());
    }

    std::vector<std::uint64_t> streamed; ///< numbers of keyframes, one a tile
    sea::FieldSet fields;                ///< of all these tiles
    wire::ErrorCode ended = wire::ErrorCode::none;
    std::string ended_why;
    server::Session* session = nullptr;
};

class NetAcks : public ::testing::Test {
  protected:
    NetAcks() {
        sea.answer_fetches = false; // what streams alone is counted
        line.session = &session;
        session.receive(protocol::hello("test", ""));
    }
    void subscribe(int credit) {
        session.receive(protocol::subscribe(
            1, {.cascades = 1u, .fields = {sea::Field::height}, .error_m = 0}, credit));
    }
    void publish(int keyframes = 1) {
        for (; keyframes > 0; --keyframes)
            core->deliveries.add(
                {*encoder.encode(*sea.keyframe(0, ++newest, sea.offered).keyframe,
                                 std::vector<float>(sea.offered.size(), 0.1f), 0, sea.offered)});
    }
    /// A keyframe of maps of which others follow, for who takes compact ones.
    server::EncodedKeyframePtr compact(sea::FieldSet maps, sea::FieldSet follows) {
        return *encoder.encode(*sea.keyframe(0, ++newest, maps).keyframe,
                               std::vector<float>(static_cast<std::size_t>(maps.size()), 0.1f), 0,
                               maps, {.size = 16, .follows = follows});
    }
    /// The fields of the tiles that this keyframe is sent as, once the sea changed to deep water, or from it.
    sea::FieldSet sent_over_a_change(bool deep_before, const server::EncodedKeyframePtr& keyframe) {
        for (const bool deep : {deep_before, !deep_before}) {
            sea.deep = deep;
            session.announce(SmallSea::state_message(++epoch));
        }
        line.fields = {};
        core->deliveries.add({keyframe});
        return line.fields;
    }
    /// How many of so many keyframes are sent, the newest of those that wait among them.
    std::size_t sent_of(int keyframes) {
        const std::size_t before = line.streamed.size();
        publish(keyframes);
        return line.streamed.size() - before;
    }
    void acknowledge(std::uint64_t keyframe, const std::vector<std::uint64_t>& also = {}) {
        session.receive(protocol::ack(keyframe, also));
    }

    SmallSea sea;
    std::shared_ptr<server::Core> core = std::make_shared<server::Core>(
        server::NetOptions{}, sea, [](const server::Core::Work& work) { work(); });
    server::Peer peer{"test", std::make_shared<server::Address>("test", core->options), true,
                      false};
    server::Encoder encoder;
    Line line;
    server::Session session{*core, line, peer, server::Standing::stranger};
    std::int64_t newest = 0;
    std::uint32_t epoch = 0;
};

TEST_F(NetAcks, one_of_several_keyframes_gives_the_place_of_each_back) {
    subscribe(4);
    ASSERT_EQ(sent_of(6), 4u) << "the credit";
    const std::vector<std::uint64_t> first = line.streamed;
    acknowledge(first[2], {first[0], first[3]});
    ASSERT_EQ(line.streamed.size(), 5u) << "the newest that waited, at once";
    EXPECT_EQ(sent_of(6), 2u) << "three places, one of which that took";
    acknowledge(first[1], {line.streamed[4], line.streamed[5], line.streamed[6]});
    EXPECT_EQ(sent_of(6), 3u) << "all four, and one that waited went into the first of them";
}

// Naive: what stands in `also` counts where the first number did.
TEST_F(NetAcks, a_keyframe_in_also_counts_whatever_the_others_are) {
    subscribe(1);
    for (int turn = 0; turn < 3; ++turn) {
        ASSERT_EQ(sent_of(2), turn == 0 ? 1u : 0u);
        const std::uint64_t number = line.streamed.back();
        acknowledge(0, {number, number + 1000});
        EXPECT_NE(line.streamed.back(), number) << "what waited is sent";
    }
}

TEST_F(NetAcks, of_what_is_unknown_repeated_or_acknowledged_before_give_no_place) {
    subscribe(2);
    ASSERT_EQ(sent_of(4), 2u);
    const std::uint64_t first = line.streamed[0];
    acknowledge(first, {first, first, 0, ~0ull, first + 1000});
    EXPECT_EQ(line.streamed.size(), 3u) << "one place, which the one that waited took";
    acknowledge(first, {first, 0, ~0ull, first + 1000});
    EXPECT_EQ(sent_of(4), 0u);
    EXPECT_FALSE(session.ended());
}

// Naive: what is granted as maps by now is to be maps of each keyframe, and as what follows of each likewise. Those that are on
// their way when it changes are all dropped, though their tiles say what follows from them.
TEST_F(NetAcks, come_for_keyframes_on_their_way_too_when_what_follows_from_them_changes) {
    const sea::FieldSet heights{sea::Field::height, sea::Field::height_rate};
    const sea::FieldSet moved = sea::surface_fields.without(heights);
    session.receive(protocol::subscribe(
        1, {.cascades = 1u, .fields = sea::surface_fields, .error_m = 0, .compact = true}, 1));
    EXPECT_EQ(sent_over_a_change(true, compact(heights, moved)), heights) << "the others follow";
    EXPECT_EQ(sent_over_a_change(true, compact(heights, moved)), sea::FieldSet{})
        << "a credit of one is in use";
    acknowledge(line.streamed.back());
    EXPECT_EQ(line.fields, heights) << "what waited, once that came back";
    acknowledge(line.streamed.back());
    EXPECT_EQ(sent_over_a_change(false, compact(sea::surface_fields, {})), sea::surface_fields)
        << "nothing follows";
    acknowledge(line.streamed.back());
    EXPECT_EQ(sent_over_a_change(false, compact(sea::surface_fields, moved)), heights)
        << "no more than is needed";
    acknowledge(line.streamed.back());
    EXPECT_EQ(sent_over_a_change(true, compact(sea::surface_fields, moved)), heights)
        << "nor of a sea whose others follow, where those of the next are granted as maps";
    acknowledge(line.streamed.back());
    EXPECT_EQ(sent_over_a_change(true, compact(heights, {})), sea::FieldSet{}) << "half of it";
    EXPECT_EQ(sent_over_a_change(true, compact({sea::Field::height}, moved)), sea::FieldSet{})
        << "no rates follow from heights";
    EXPECT_EQ(sent_over_a_change(true, compact(heights, moved)), heights) << "and took no place";
}

// What is on its way counts until it is acknowledged, whichever subscription it was of.
TEST_F(NetAcks, that_were_held_back_until_a_smaller_credit_let_the_stream_go_on) {
    subscribe(8);
    ASSERT_EQ(sent_of(4), 4u);
    subscribe(1);
    EXPECT_EQ(sent_of(2), 0u) << "four are in a window of one";
    acknowledge(line.streamed[0], {line.streamed[1], line.streamed[2]});
    EXPECT_EQ(line.streamed.size(), 4u);
    acknowledge(line.streamed[3]);
    EXPECT_EQ(line.streamed.size(), 5u);
    EXPECT_EQ(sent_of(2), 0u);
}

// There is no request that could be refused, and a place that nobody gives back would be lost for ever.
TEST_F(NetAcks, of_more_keyframes_than_may_be_named_end_the_session_by_name) {
    subscribe(8);
    ASSERT_EQ(sent_of(8), 8u);
    acknowledge(1, std::vector<std::uint64_t>(8));
    EXPECT_FALSE(session.ended());
    acknowledge(1, std::vector<std::uint64_t>(9));
    EXPECT_TRUE(session.ended());
    EXPECT_EQ(line.ended, wire::ErrorCode::bad_value);
    EXPECT_EQ(line.ended_why, "count of also is 9, allowed are 0 to 8");
}

// Naive: who holds the oldest keyframe is furthest behind, and what was not acknowledged is held.
TEST_F(NetAcks, that_have_not_come_make_nobody_a_slow_reader_who_has_taken_all) {
    subscribe(8);
    std::vector<std::weak_ptr<const server::EncodedKeyframe>> sent;
    for (int i = 0; i < 7; ++i) {
        const auto keyframe =
            *encoder.encode(*sea.keyframe(0, ++newest, sea.offered).keyframe,
                            std::vector<float>(sea.offered.size(), 0.1f), 0, sea.offered);
        auto streamed = std::make_shared<server::EncodedKeyframe>(*keyframe);
        streamed->place =
            core->memory->room(server::MemoryUse::streamed)->take_anyway(keyframe->bytes);
        sent.push_back(streamed);
        core->deliveries.add({std::move(streamed)});
    }
    ASSERT_EQ(line.streamed.size(), 7u);
    EXPECT_EQ(session.outbox().oldest_streamed().number, 0u);
    EXPECT_EQ(session.outbox().bytes_waiting(), 0u);
    EXPECT_EQ(session.outbox().counters().keyframes_awaiting_credit, 0u);
    EXPECT_TRUE(std::ranges::all_of(sent, [](const auto& one) { return one.expired(); }));
}

} // namespace
} // namespace seaway::tests
