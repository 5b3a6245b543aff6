// SPDX-License-Identifier: Apache-2.0
// Encoder, without sockets.
#include <cmath>
#include <map>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "protocol/tile_codec.h"
#include "server/publish/encoder.h"
#include "tests/server/publish/made_keyframe.h"
#include "tests/server/publish/tile_of.h"

namespace seaway::server {
namespace {

namespace limits = protocol::limits;
using protocol::SharedBytes;

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

// Whoever fetched it before the stream came to it: held unread by a crowd it must count, or nobody is closed for it.
TEST(Encoder, what_was_made_for_a_fetch_has_a_place_among_what_is_streamed_once_it_is) {
    Encoder encoder;
    const auto streamed = server::Room::of(1'000'000);
    const sea::Keyframe original = keyframe(16, {sea::Field::height, sea::Field::foam});
    const float bounds[] = {0.1f, 0.3f};
    const auto fetched = encoder.encode(original, bounds, 0, original.fields);
    const auto published = encoder.encode(original, bounds, 0, original.fields, {}, streamed.get());
    ASSERT_TRUE(fetched && published);
    EXPECT_TRUE((*published)->place);
    EXPECT_EQ(streamed->held_bytes(), (*published)->bytes);
    EXPECT_EQ((*published)->number, (*fetched)->number);
    EXPECT_EQ((*published)->maps[0].parts, (*fetched)->maps[0].parts) << "shared, not copied";
    const auto again = encoder.encode(original, bounds, 0, original.fields, {}, streamed.get());
    EXPECT_EQ(*again, *published) << "one place is enough";
    EXPECT_EQ(encoder.counters().fields_encoded, 2u);
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

// Naive: what is remembered grows until its share is full, 20 MB, for minutes and for nobody.
TEST(Encoder, what_nobody_wants_is_forgotten_when_its_stream_has_gone_on) {
    Encoder encoder;
    const auto room = server::Room::of(1'000'000'000);
    const float bound[] = {0.001f};
    const auto encode = [&](int cascade, sea::TimeUs time_us, server::Room* streamed) {
        const std::uint64_t before = encoder.counters().fields_encoded;
        EXPECT_TRUE(encoder.encode(keyframe(16, {sea::Field::height}, cascade, time_us), bound, 0,
                                   {sea::Field::height}, {}, streamed));
        return encoder.counters().fields_encoded > before;
    };
    const auto stream = [&](int cascade, sea::TimeUs time_us) {
        EXPECT_TRUE(encode(cascade, time_us, room.get()));
    };
    const auto knows = [&](int cascade, sea::TimeUs time_us) {
        return !encode(cascade, time_us, nullptr);
    };
    EXPECT_FALSE(knows(0, -1000)) << "fetched once, and remembered";
    stream(1, 0); // of a slow cascade
    std::size_t early = 0;
    for (sea::TimeUs time_us = 0; time_us < 100; ++time_us) {
        stream(0, time_us);
        EXPECT_TRUE(knows(0, -1000)) << "who is asked for stays";
        if (time_us == 20)
            early = encoder.remembered_bytes();
    }
    EXPECT_LT(encoder.remembered_bytes(), early + early / 10) << "no more after 100 than after 20";
    EXPECT_TRUE(knows(1, 0)) << "nothing of its own stream has come since";
    for (sea::TimeUs time_us = 99; time_us > 99 - static_cast<int>(Encoder::unused_max); --time_us)
        EXPECT_TRUE(knows(0, time_us)) << time_us;
    EXPECT_FALSE(knows(0, 99 - static_cast<int>(Encoder::unused_max) - 1));
}

// Naive: what a flood has fetched has no stream that goes on, and is remembered for as long as the server runs.
TEST(Encoder, what_was_fetched_is_forgotten_in_time_and_what_was_streamed_later) {
    Encoder encoder;
    const auto room = server::Room::of(1'000'000'000);
    const float bound[] = {0.001f};
    const auto encodes = [&](sea::TimeUs time_us, server::Room* streamed = nullptr) {
        const std::uint64_t before = encoder.counters().fields_encoded;
        EXPECT_TRUE(encoder.encode(keyframe(16, {sea::Field::height}, 0, time_us), bound, 0,
                                   {sea::Field::height}, {}, streamed));
        return encoder.counters().fields_encoded > before;
    };
    EXPECT_FALSE(encoder.remembers());
    EXPECT_TRUE(encodes(1) && encodes(2) && encodes(3, room.get()));
    encoder.trim();
    EXPECT_FALSE(encodes(1)) << "somebody asks for it again";
    encoder.trim();
    EXPECT_FALSE(encodes(1));
    EXPECT_FALSE(encodes(3)) << "who begins to subscribe wants it";
    EXPECT_TRUE(encodes(2));
    for (std::uint64_t i = 0; i <= Encoder::streamed_trims; ++i) {
        EXPECT_TRUE(encoder.remembers());
        encoder.trim();
    }
    encoder.trim();
    EXPECT_FALSE(encoder.remembers());
    EXPECT_EQ(encoder.remembered_bytes(), 0u);
    EXPECT_EQ(room->held_bytes(), 0u);
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

} // namespace
} // namespace seaway::server
