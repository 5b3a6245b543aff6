// SPDX-License-Identifier: Apache-2.0
// Outbox, without sockets.
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "server/publish/outbox.h"
#include "tests/server/publish/made_keyframe.h"
#include "tests/server/publish/tile_of.h"

namespace seaway::server {
namespace {

namespace limits = protocol::limits;
using protocol::SharedBytes;

SharedBytes message(std::size_t bytes = 8) {
    return std::make_shared<const protocol::Bytes>(bytes);
}

/// A keyframe of `tiles` messages without meaning.
EncodedKeyframePtr parcel(std::uint64_t number, int cascade, int tiles = 1,
                          std::size_t bytes_each = 8) {
    auto made = std::make_shared<EncodedKeyframe>();
    made->number = number;
    made->cascade = cascade;
    made->fields = {sea::Field::height};
    made->maps.push_back({.field = sea::Field::height, .error = 0, .parts = {}});
    for (int i = 0; i < tiles; ++i)
        made->maps[0].parts.push_back(message(bytes_each));
    return made;
}

const sea::FieldSet height{sea::Field::height};

TEST(Outbox, replies_go_before_durable_messages_and_those_before_tiles) {
    Outbox outbox;
    const EncodedKeyframePtr tiles = parcel(1, 0, 2);
    const SharedBytes state = message();
    const SharedBytes pong = message();
    outbox.push_keyframe(tiles, height);
    EXPECT_EQ(outbox.next(), tiles->maps[0].parts[0]);
    ASSERT_TRUE(outbox.push_durable(state));
    outbox.push_reply(pong);
    EXPECT_EQ(outbox.next(), pong);
    EXPECT_EQ(outbox.next(), state);
    EXPECT_EQ(outbox.next(), tiles->maps[0].parts[1]);
    EXPECT_EQ(outbox.next(), nullptr);
}

TEST(Outbox, fetched_and_streamed_tiles_take_turns) {
    Outbox outbox;
    const EncodedKeyframePtr fetched = parcel(1, 0, 3);
    const EncodedKeyframePtr streamed = parcel(2, 0, 2);
    const SharedBytes done = message();
    ASSERT_TRUE(outbox.push_fetched(std::span(&fetched, 1), height, done));
    outbox.push_keyframe(streamed, height);
    std::vector<SharedBytes> order;
    while (SharedBytes next = outbox.next())
        order.push_back(next);
    const auto& f = fetched->maps[0].parts;
    const auto& s = streamed->maps[0].parts;
    EXPECT_EQ(order, (std::vector<SharedBytes>{s[0], f[0], s[1], f[1], f[2], done}));
    EXPECT_EQ(outbox.fetches_waiting(), 0);
}

// An encoded keyframe holds the maps of everybody; a session waits for its own.
TEST(Outbox, only_the_maps_that_will_be_sent_count_as_bytes_and_all_of_them_come_back) {
    Outbox outbox;
    auto both = std::make_shared<EncodedKeyframe>(*parcel(1, 0, 2, limits::fetch_bytes_max / 8));
    both->fields.insert(sea::Field::foam);
    both->maps.push_back({.field = sea::Field::foam, .error = 0, .parts = {}});
    both->maps[1].parts.assign(3, message(limits::fetch_bytes_max / 4));
    const EncodedKeyframePtr keyframe = both;
    for (int fetch = 0; fetch < 10; ++fetch) {
        ASSERT_TRUE(outbox.push_fetched(std::span(&keyframe, 1), height, message(8))) << fetch;
        EXPECT_EQ(outbox.bytes_waiting(), limits::fetch_bytes_max / 4 + 8);
        int messages = 0;
        while (outbox.next())
            ++messages;
        EXPECT_EQ(messages, 3);
        EXPECT_EQ(outbox.bytes_waiting(), 0u);
    }
    outbox.push_keyframe(keyframe, height);
    EXPECT_EQ(outbox.bytes_waiting(), limits::fetch_bytes_max / 4) << "streamed ones likewise";
}

TEST(Outbox, the_bytes_of_all_that_waits_are_counted_and_go_with_each_message) {
    Outbox outbox;
    EXPECT_EQ(outbox.bytes_waiting(), 0u);
    std::size_t bytes = 0;
    outbox.push_reply(message(1));
    EXPECT_EQ(outbox.bytes_waiting(), bytes += 1);
    ASSERT_TRUE(outbox.push_durable(message(10)));
    EXPECT_EQ(outbox.bytes_waiting(), bytes += 10);
    const EncodedKeyframePtr fetched = parcel(1, 0, 2, 100);
    ASSERT_TRUE(outbox.push_fetched(std::span(&fetched, 1), height, message(1000)));
    EXPECT_EQ(outbox.bytes_waiting(), bytes += 2 * 100 + 1000);
    outbox.push_keyframe(parcel(2, 0, 1, 30'000), height);
    outbox.push_keyframe(parcel(3, 1, 1, 70'000), height);
    EXPECT_EQ(outbox.bytes_waiting(), bytes += 100'000);
    outbox.push_keyframe(parcel(4, 1, 1, 50'000), height); // in the place of the one before
    EXPECT_EQ(outbox.bytes_waiting(), bytes -= 20'000);
    while (const SharedBytes next = outbox.next())
        EXPECT_EQ(outbox.bytes_waiting(), bytes -= next->size());
    EXPECT_EQ(bytes, 0u);
}

TEST(Outbox, a_waiting_keyframe_is_replaced_by_a_newer_one_of_its_cascade_only) {
    Outbox outbox;
    outbox.set_credit(1);
    outbox.push_keyframe(parcel(1, 0), height);
    ASSERT_NE(outbox.next(), nullptr); // the credit is used
    const EncodedKeyframePtr newest = parcel(4, 0);
    const EncodedKeyframePtr other = parcel(3, 1);
    outbox.push_keyframe(parcel(2, 0), height);
    outbox.push_keyframe(other, height);
    outbox.push_keyframe(newest, height);
    EXPECT_EQ(outbox.next(), nullptr);
    EXPECT_TRUE(outbox.acknowledge(1));
    EXPECT_EQ(outbox.next(), newest->maps[0].parts[0]) << "keeps the turn of what it replaced";
    EXPECT_TRUE(outbox.acknowledge(4));
    EXPECT_EQ(outbox.next(), other->maps[0].parts[0]);
    EXPECT_EQ(outbox.counters().keyframes_started, 3u);
    EXPECT_EQ(outbox.counters().keyframes_replaced, 1u);
}

// Naive: where one sea follows another, its first keyframe takes the place of the last one of the sea before.
TEST(Outbox, a_waiting_keyframe_is_not_replaced_by_one_of_another_sea) {
    Outbox outbox;
    outbox.set_credit(1);
    outbox.push_keyframe(parcel(1, 0), height);
    ASSERT_NE(outbox.next(), nullptr);
    auto of_next_sea = std::make_shared<EncodedKeyframe>(*parcel(3, 0));
    of_next_sea->epoch = parcel(2, 0)->epoch + 1;
    outbox.push_keyframe(parcel(2, 0), height);
    outbox.push_keyframe(of_next_sea, height);
    for (const std::uint64_t number : {1, 2}) {
        EXPECT_TRUE(outbox.acknowledge(number));
        EXPECT_NE(outbox.next(), nullptr);
    }
    EXPECT_EQ(outbox.counters().keyframes_replaced, 0u);
    // Of many seas two wait, however often the sea changes.
    for (std::uint32_t epoch = 10; epoch < 40; ++epoch) {
        auto later = std::make_shared<EncodedKeyframe>(*parcel(epoch, 0));
        later->epoch = epoch;
        outbox.push_keyframe(later, height);
    }
    EXPECT_EQ(outbox.counters().keyframes_replaced, 28u);
}

TEST(Outbox, a_keyframe_that_has_begun_is_finished_before_a_newer_one) {
    Outbox outbox;
    const EncodedKeyframePtr begun = parcel(1, 0, 2);
    const EncodedKeyframePtr newer = parcel(2, 0, 1);
    outbox.push_keyframe(begun, height);
    ASSERT_EQ(outbox.next(), begun->maps[0].parts[0]);
    outbox.push_keyframe(newer, height);
    outbox.stop_stream();
    outbox.push_keyframe(newer, height);
    EXPECT_EQ(outbox.next(), begun->maps[0].parts[1]);
    EXPECT_EQ(outbox.next(), newer->maps[0].parts[0]);
}

TEST(Outbox, acknowledgements_of_what_is_not_in_the_window_give_no_credit) {
    Outbox outbox;
    outbox.set_credit(1);
    outbox.push_keyframe(parcel(5, 0), height);
    ASSERT_NE(outbox.next(), nullptr);
    outbox.push_keyframe(parcel(6, 0), height);
    for (const std::uint64_t number : {0ull, 4ull, 6ull, ~0ull})
        EXPECT_FALSE(outbox.acknowledge(number));
    EXPECT_EQ(outbox.next(), nullptr);
    EXPECT_TRUE(outbox.acknowledge(5));
    EXPECT_FALSE(outbox.acknowledge(5));
    EXPECT_NE(outbox.next(), nullptr);
    outbox.push_keyframe(parcel(7, 0), height);
    EXPECT_EQ(outbox.next(), nullptr);
}

TEST(Outbox, only_granted_fields_are_handed_out) {
    Encoder encoder;
    const sea::Keyframe original = keyframe(300, {sea::Field::height, sea::Field::foam});
    const float bounds[] = {0.1f, 0.1f};
    Outbox outbox;
    outbox.push_keyframe(*encoder.encode(original, bounds, 0, original.fields), {sea::Field::foam});
    int tiles = 0;
    while (const SharedBytes bytes = outbox.next()) {
        EXPECT_EQ(tile_of(bytes).field(), wire::Field::foam);
        ++tiles;
    }
    EXPECT_EQ(tiles, 4);
}

TEST(Outbox, durable_messages_are_never_dropped_but_refused_when_they_do_not_fit) {
    Outbox outbox;
    std::vector<SharedBytes> states;
    for (std::size_t i = 0; i < limits::durable_waiting_max; ++i) {
        states.push_back(message());
        ASSERT_TRUE(outbox.push_durable(states.back()));
    }
    EXPECT_FALSE(outbox.push_durable(message()));
    for (const SharedBytes& state : states)
        EXPECT_EQ(outbox.next(), state);
}

TEST(Outbox, a_fetch_that_does_not_fit_is_refused_whole) {
    Outbox outbox;
    const EncodedKeyframePtr half = parcel(1, 0, 2, limits::fetch_bytes_max / 4);
    ASSERT_TRUE(outbox.push_fetched(std::span(&half, 1), height, message()));
    EXPECT_FALSE(outbox.push_fetched(std::span(&half, 1), height, message()));
    EXPECT_EQ(outbox.fetches_waiting(), 1);
    EXPECT_LE(outbox.bytes_waiting(), limits::fetch_bytes_max);
    while (outbox.next() != nullptr) {
    }
    EXPECT_EQ(outbox.bytes_waiting(), 0u);
    EXPECT_TRUE(outbox.push_fetched(std::span(&half, 1), height, message()));
}

TEST(Outbox, a_fetch_of_exactly_what_may_wait_fits_and_a_byte_more_does_not) {
    constexpr std::size_t done_bytes = 24;
    for (const std::size_t more : {0u, 1u}) {
        Outbox outbox;
        const EncodedKeyframePtr all = parcel(1, 0, 1, limits::fetch_bytes_max - done_bytes + more);
        EXPECT_EQ(outbox.push_fetched(std::span(&all, 1), height, message(done_bytes)), more == 0);
        EXPECT_EQ(outbox.bytes_waiting(), more == 0 ? limits::fetch_bytes_max : 0);
    }
}

TEST(Outbox, requests_are_accepted_until_enough_replies_wait) {
    Outbox outbox;
    for (std::size_t i = 0; i < limits::replies_waiting_max; ++i) {
        EXPECT_TRUE(outbox.accepts_requests());
        outbox.push_reply(message());
    }
    EXPECT_FALSE(outbox.accepts_requests());
    ASSERT_NE(outbox.next(), nullptr);
    EXPECT_TRUE(outbox.accepts_requests());
    outbox.push_reply(message(limits::replies_bytes_max));
    EXPECT_FALSE(outbox.accepts_requests());
}

TEST(Outbox, whatever_a_peer_does_the_window_and_the_bytes_stay_bounded) {
    // A random peer: acknowledges at random, takes messages at random. The model: no more than
    // `credit` keyframes begun and unacknowledged, at most one waiting a cascade.
    std::mt19937_64 numbers(11);
    for (int round = 0; round < 50; ++round) {
        Outbox outbox;
        const int credit = 1 + static_cast<int>(numbers() % limits::credit_max);
        outbox.set_credit(credit);
        std::map<SharedBytes, std::uint64_t> owner;
        std::set<std::uint64_t> unacknowledged;
        std::set<std::uint64_t> acknowledged; // some before their last part
        for (std::uint64_t number = 1; number < 300; ++number) {
            const int cascade = static_cast<int>(numbers() % 4);
            const EncodedKeyframePtr pushed =
                parcel(number, cascade, 1 + static_cast<int>(numbers() % 3));
            for (const SharedBytes& part : pushed->maps[0].parts)
                owner[part] = number;
            outbox.push_keyframe(pushed, height);
            for (std::uint64_t takes = numbers() % 4; takes > 0; --takes)
                if (const SharedBytes next = outbox.next();
                    next != nullptr && !acknowledged.contains(owner.at(next)))
                    unacknowledged.insert(owner.at(next));
            ASSERT_LE(unacknowledged.size(), static_cast<std::size_t>(credit));
            ASSERT_LE(outbox.bytes_waiting(), 4u * 3u * 8u);
            if (!unacknowledged.empty() && numbers() % 3 == 0) {
                const std::uint64_t oldest = *unacknowledged.begin();
                ASSERT_TRUE(outbox.acknowledge(oldest));
                unacknowledged.erase(oldest);
                acknowledged.insert(oldest);
            }
        }
    }
}

} // namespace
} // namespace seaway::server
