// SPDX-License-Identifier: Apache-2.0
// Encoder and outbox, without sockets.
#include <cmath>
#include <map>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "protocol/tile_codec.h"
#include "server/publish/encoder.h"
#include "server/publish/outbox.h"
#include "tests/server/publish/tile_of.h"

namespace seaway::server {
namespace {

namespace limits = protocol::limits;
using protocol::SharedBytes;

sea::Keyframe keyframe(int size, sea::FieldSet fields, int cascade = 0, sea::TimeUs time_us = 0) {
    sea::Keyframe made;
    made.cascade = cascade;
    made.time_us = time_us;
    made.size = size;
    made.length_m = 100;
    made.fields = fields;
    made.values.resize(made.plane_size() * static_cast<std::size_t>(fields.size()));
    for (std::size_t i = 0; i < made.values.size(); ++i)
        made.values[i] = static_cast<float>(
            std::sin(0.01 * static_cast<double>(i) + static_cast<double>(time_us)));
    return made;
}

// ---- encoder -------------------------------------------------------------------------------

TEST(Encoder, parts_cover_the_map_exactly_once_and_decode_within_the_bound) {
    Encoder encoder;
    const sea::Keyframe original = keyframe(600, {sea::Field::height});
    const float bounds[] = {1e-3f};
    const auto encoded = encoder.encode(original, bounds, 0, {sea::Field::height});
    ASSERT_TRUE(encoded.has_value());
    ASSERT_EQ((*encoded)->maps.size(), 1u);
    std::vector<float> back(original.plane_size(), std::nanf(""));
    std::vector<int> covered(original.plane_size(), 0);
    int part = 0;
    for (const SharedBytes& bytes : (*encoded)->maps[0].parts) {
        const wire::Tile& tile = tile_of(bytes);
        ASSERT_TRUE(protocol::check(tile).has_value());
        EXPECT_EQ(tile.part(), part++);
        EXPECT_EQ(tile.parts(), 9);
        EXPECT_EQ(tile.error(), 1e-3f);
        const std::size_t at = tile.y0() * std::size_t{600} + tile.x0();
        ASSERT_TRUE(protocol::decode_tile({tile.payload()->data(), tile.payload()->size()},
                                          {tile.width(), tile.height()}, 600,
                                          std::span(back).subspan(at))
                        .has_value());
        for (int y = 0; y < tile.height(); ++y)
            for (int x = 0; x < tile.width(); ++x)
                ++covered[at + static_cast<std::size_t>(y * 600 + x)];
    }
    for (std::size_t i = 0; i < back.size(); ++i) {
        ASSERT_EQ(covered[i], 1);
        ASSERT_LE(std::abs(back[i] - original.values[i]), 1e-3f);
    }
}

TEST(Encoder, only_what_is_wanted_is_encoded_and_nothing_twice) {
    Encoder encoder;
    const sea::FieldSet three{sea::Field::height, sea::Field::slope_x, sea::Field::foam};
    const sea::Keyframe original = keyframe(16, three);
    const float bounds[] = {0.1f, 0.2f, 0.3f};
    const auto first = encoder.encode(original, bounds, 0, {sea::Field::foam});
    const auto again = encoder.encode(original, bounds, 0, {sea::Field::foam});
    const auto more = encoder.encode(original, bounds, 0, {sea::Field::foam, sea::Field::height});
    ASSERT_TRUE(first && again && more);
    EXPECT_EQ((*first)->fields, (sea::FieldSet{sea::Field::foam}));
    EXPECT_EQ((*first)->maps[0].error, 0.3f);
    EXPECT_EQ(*first, *again);
    EXPECT_EQ((*more)->number, (*first)->number);
    EXPECT_EQ((*more)->maps[1].parts, (*first)->maps[0].parts) << "shared, not copied";
    EXPECT_EQ(encoder.counters().fields_encoded, 2u);
    EXPECT_EQ(encoder.counters().fields_reused, 2u);
}

TEST(Encoder, what_is_known_but_not_wanted_is_not_counted_as_reused) {
    Encoder encoder;
    const sea::Keyframe original =
        keyframe(16, {sea::Field::height, sea::Field::slope_x, sea::Field::foam});
    const float bounds[] = {0.1f, 0.2f, 0.3f};
    ASSERT_TRUE(encoder.encode(original, bounds, 0, {sea::Field::height, sea::Field::foam}));
    ASSERT_TRUE(encoder.encode(original, bounds, 0, {sea::Field::slope_x}));
    EXPECT_EQ(encoder.counters().fields_encoded, 3u);
    EXPECT_EQ(encoder.counters().fields_reused, 0u);
    EXPECT_EQ(encoder.counters().samples, 3u * 16 * 16);
}

TEST(Encoder, qualities_epochs_times_and_cascades_are_different_keyframes) {
    Encoder encoder;
    const float fine[] = {0.001f};
    const float coarse[] = {0.1f};
    std::set<std::uint64_t> numbers;
    sea::Keyframe one = keyframe(16, {sea::Field::height});
    const auto encode = [&](std::span<const float> bounds, Quality quality) {
        numbers.insert((*encoder.encode(one, bounds, quality, one.fields))->number);
    };
    encode(fine, 0);
    encode(coarse, 1);
    one.epoch = 1;
    encode(fine, 0);
    one.cascade = 1;
    encode(fine, 0);
    one.time_us = 1;
    encode(fine, 0);
    EXPECT_EQ(numbers, (std::set<std::uint64_t>{1, 2, 3, 4, 5}));
}

TEST(Encoder, the_memory_is_bounded_and_forgets_the_oldest) {
    // One lossless noisy keyframe is about 4 KB: the memory holds two or three of a hundred.
    Encoder encoder(server::Room::of(12'000));
    const float lossless[] = {0.0f};
    const auto encode = [&](sea::TimeUs time_us) {
        return encoder.encode(keyframe(32, {sea::Field::height}, 0, time_us), lossless, 0,
                              {sea::Field::height});
    };
    for (sea::TimeUs time_us = 0; time_us < 100; ++time_us)
        ASSERT_TRUE(encode(time_us).has_value());
    const std::uint64_t before = encoder.counters().fields_encoded;
    ASSERT_TRUE(encode(99).has_value());
    EXPECT_EQ(encoder.counters().fields_encoded, before) << "the newest is remembered";
    ASSERT_TRUE(encode(0).has_value());
    EXPECT_EQ(encoder.counters().fields_encoded, before + 1) << "the oldest is forgotten";
}

TEST(Encoder, any_mix_of_keyframes_leaves_the_count_equal_to_the_bytes_held_and_below_the_limit) {
    // What the encoder alone keeps alive is what it remembers.
    const sea::FieldSet all{sea::Field::height, sea::Field::slope_x, sea::Field::foam};
    const sea::FieldSet wishes[] = {
        {sea::Field::height}, {sea::Field::foam}, {sea::Field::height, sea::Field::slope_x}, all};
    const float bounds[2][3] = {{0.0f, 0.0f, 0.0f}, {0.1f, 0.1f, 0.1f}};
    std::mt19937_64 numbers(16);
    for (const std::size_t bytes_max : {500u, 5'000u, 40'000u}) {
        Encoder encoder(server::Room::of(bytes_max));
        std::vector<std::weak_ptr<const EncodedKeyframe>> made;
        for (int step = 0; step < 3000; ++step) {
            const sea::Keyframe original =
                keyframe(numbers() % 8 == 0 ? 32 : 8, all, static_cast<int>(numbers() % 2),
                         static_cast<sea::TimeUs>(numbers() % 16));
            const auto quality = static_cast<std::uint8_t>(numbers() % 2);
            {
                const auto encoded =
                    encoder.encode(original, bounds[quality], quality, wishes[numbers() % 4]);
                ASSERT_TRUE(encoded);
                std::size_t bytes = 0;
                for (const EncodedField& map : (*encoded)->maps)
                    for (const SharedBytes& part : map.parts)
                        bytes += part->size();
                ASSERT_EQ((*encoded)->bytes, bytes);
                made.push_back(*encoded);
            }
            std::set<EncodedKeyframePtr> held;
            for (const auto& one : made)
                if (const EncodedKeyframePtr alive = one.lock())
                    held.insert(alive);
            std::size_t bytes = 0;
            for (const EncodedKeyframePtr& one : held)
                bytes += one->bytes;
            ASSERT_EQ(encoder.remembered_bytes(), bytes) << "step " << step;
            ASSERT_LE(bytes, bytes_max);
            made.assign(held.begin(), held.end());
        }
        EXPECT_GT(encoder.counters().fields_reused, 0u);
    }
}

TEST(Encoder, a_map_that_is_not_finite_is_an_error_that_names_it) {
    Encoder encoder;
    sea::Keyframe broken = keyframe(16, {sea::Field::slope_y}, 2);
    broken.values[5] = std::nanf("");
    const float bounds[] = {0.1f};
    const auto encoded = encoder.encode(broken, bounds, 0, broken.fields);
    ASSERT_FALSE(encoded.has_value());
    EXPECT_NE(encoded.error().message.find("cascade 2"), std::string::npos);
    EXPECT_NE(encoded.error().message.find("slope_y"), std::string::npos);
}

// ---- outbox --------------------------------------------------------------------------------

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
