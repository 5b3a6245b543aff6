// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "client/held/tile_assembly.h"
#include "protocol/limits.h"
#include "protocol/tile_codec.h"

namespace seaway::client {
namespace {

using protocol::TileHeader;
using sea::Field;
using sea::FieldSet;

constexpr double length_m = 100;
constexpr float bound = 0.01f;
constexpr FieldSet pair_fields{Field::height, Field::height_rate};
constexpr FieldSet three_fields{Field::height, Field::displacement_x, Field::height_rate};

float sample(Field field, int x, int y) {
    return static_cast<float>(std::sin(0.3 * x + 0.1 * y)) + static_cast<float>(field);
}

struct Part {
    TileHeader header;
    std::vector<std::uint8_t> payload;
};

/// Parts of `side` samples of one field of a map.
std::vector<Part> parts_of(Field field, int size, int side, std::uint64_t keyframe = 1,
                           sea::TimeUs time_us = 0) {
    std::vector<float> map;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
            map.push_back(sample(field, x, y));
    std::vector<Part> parts;
    const int per_axis = (size + side - 1) / side;
    for (int i = 0; i < per_axis * per_axis; ++i) {
        TileHeader header;
        header.keyframe = keyframe;
        header.field = field;
        header.time_us = time_us;
        header.size = size;
        header.x0 = i % per_axis * side;
        header.y0 = i / per_axis * side;
        header.width = std::min(side, size - header.x0);
        header.height = std::min(side, size - header.y0);
        header.part = i;
        header.parts = per_axis * per_axis;
        header.error = bound;
        const auto stride = static_cast<std::size_t>(size);
        const auto first =
            static_cast<std::size_t>(header.y0) * stride + static_cast<std::size_t>(header.x0);
        auto payload = protocol::encode_tile(std::span(map).subspan(first),
                                             {header.width, header.height}, stride, bound);
        EXPECT_TRUE(payload);
        parts.push_back({header, *payload});
    }
    return parts;
}

/// A cascade whose own grid the map of this part has.
protocol::CascadeInfo cascade_of(const Part& part) {
    return {.length_m = length_m, .size = part.header.size};
}

TileAssembly::Added add(TileAssembly& assembly, const Part& part, FieldSet streamed,
                        std::vector<FieldSet> requested = {}) {
    const auto added =
        assembly.add(part.header, part.payload, cascade_of(part), 0, streamed, requested);
    EXPECT_TRUE(added) << added.error().message;
    return added ? *added : TileAssembly::Added{};
}

TEST(TileAssembly, puts_parts_in_their_places_in_any_order_within_the_bound) {
    TileAssembly assembly;
    std::vector<Part> parts = parts_of(Field::height_rate, 40, 16);
    for (const Part& part : parts_of(Field::height, 40, 16))
        parts.push_back(part);
    std::reverse(parts.begin(), parts.end());
    HeldKeyframePtr complete;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const TileAssembly::Added added = add(assembly, parts[i], pair_fields);
        EXPECT_EQ(added.complete != nullptr, i + 1 == parts.size());
        EXPECT_EQ(added.acknowledge, i + 1 == parts.size());
        complete = added.complete;
    }
    ASSERT_TRUE(complete);
    EXPECT_EQ(complete->keyframe().fields, pair_fields);
    EXPECT_EQ(complete->keyframe().length_m, length_m);
    EXPECT_EQ(complete->error(Field::height), bound);
    EXPECT_EQ(complete->error(Field::foam), 0);
    for (const Field field : pair_fields)
        for (int y = 0; y < 40; ++y)
            for (int x = 0; x < 40; ++x)
                ASSERT_LE(std::abs(complete->keyframe().plane(
                                       field)[static_cast<std::size_t>(y * 40 + x)] -
                                   sample(field, x, y)),
                          bound);
    EXPECT_EQ(assembly.keyframes(), 0u);
    EXPECT_EQ(assembly.bytes(), 0u);
}

TEST(TileAssembly, a_maps_error_is_that_of_its_worst_part_wherever_that_stands) {
    for (const std::size_t worst : {0u, 1u, 2u, 3u}) {
        TileAssembly assembly;
        std::vector<Part> parts = parts_of(Field::height, 32, 16);
        ASSERT_EQ(parts.size(), 4u);
        HeldKeyframePtr complete;
        for (std::size_t i = 0; i < parts.size(); ++i) {
            parts[i].header.error = i == worst ? 3 * bound : bound;
            complete = add(assembly, parts[i], {Field::height}).complete;
        }
        ASSERT_TRUE(complete);
        EXPECT_EQ(complete->error(Field::height), 3 * bound) << "part " << worst;
    }
}

// A fetch and the stream may send the same keyframe at the same time, in turns.
TEST(TileAssembly, h2_mixed_copies_make_one_keyframe_and_are_both_acknowledged) {
    TileAssembly assembly;
    const Part height = parts_of(Field::height, 16, 16).front();
    const Part rate = parts_of(Field::height_rate, 16, 16).front();
    EXPECT_FALSE(add(assembly, height, pair_fields, {pair_fields}).complete);
    EXPECT_FALSE(add(assembly, height, pair_fields, {pair_fields}).complete);
    EXPECT_TRUE(add(assembly, rate, pair_fields, {pair_fields}).complete);
    // What is left of the other copy is another beginning, which the next end of a fetch bounds.
    EXPECT_FALSE(add(assembly, rate, pair_fields, {pair_fields}).complete);
    // A later copy that is whole is handed out, and acknowledged, again.
    EXPECT_TRUE(add(assembly, height, pair_fields).acknowledge);
}

// 300 orders by lot of the parts of two keyframes, each once to three times.
TEST(TileAssembly, h2_parts_in_any_order_and_twice_make_a_keyframe_when_the_last_has_come) {
    std::vector<std::pair<std::uint64_t, Part>> parts;
    for (const std::uint64_t keyframe : {1u, 2u})
        for (const Field field : pair_fields)
            for (const Part& part :
                 parts_of(field, 32, 16, keyframe, static_cast<sea::TimeUs>(keyframe) * 100'000))
                parts.emplace_back(keyframe, part);
    ASSERT_EQ(parts.size(), 16u);
    std::mt19937 random(3);
    for (int order = 0; order < 300; ++order) {
        std::vector<std::size_t> coming;
        for (std::size_t i = 0; i < parts.size(); ++i)
            coming.insert(coming.end(), 1 + random() % 3, i);
        std::shuffle(coming.begin(), coming.end(), random);
        TileAssembly assembly;
        std::map<std::uint64_t, std::set<std::size_t>> there; // since it was last whole
        int whole = 0;
        for (const std::size_t i : coming) {
            const auto& [keyframe, part] = parts[i];
            there[keyframe].insert(i);
            const HeldKeyframePtr complete = add(assembly, part, pair_fields).complete;
            ASSERT_EQ(complete != nullptr, there[keyframe].size() == 8) << "order " << order;
            if (!complete)
                continue;
            ++whole;
            there[keyframe].clear();
            ASSERT_EQ(complete->keyframe().time_us, static_cast<sea::TimeUs>(keyframe) * 100'000);
            for (const Field field : pair_fields)
                for (int at = 0; at < 32 * 32; at += 37)
                    ASSERT_LE(
                        std::abs(complete->keyframe().plane(field)[static_cast<std::size_t>(at)] -
                                 sample(field, at % 32, at / 32)),
                        bound);
        }
        ASSERT_GE(whole, 2);
    }
}

TEST(TileAssembly, a_request_for_more_fields_gets_them_though_the_stream_was_served_first) {
    TileAssembly assembly;
    const auto part = [](Field field) { return parts_of(field, 16, 16).front(); };
    add(assembly, part(Field::height), pair_fields, {three_fields});
    const auto streamed = add(assembly, part(Field::height_rate), pair_fields, {three_fields});
    ASSERT_TRUE(streamed.complete);
    EXPECT_EQ(streamed.complete->keyframe().fields, pair_fields);
    const auto requested = add(assembly, part(Field::displacement_x), pair_fields, {three_fields});
    ASSERT_TRUE(requested.complete);
    EXPECT_EQ(requested.complete->keyframe().fields, three_fields);
    EXPECT_EQ(assembly.keyframes(), 0u);
}

// Without this the server would wait for ever for the credit of the copy that it streams.
TEST(TileAssembly, a_streamed_copy_of_what_is_kept_for_a_request_is_acknowledged) {
    TileAssembly assembly;
    const Part height = parts_of(Field::height, 16, 16).front();
    const Part rate = parts_of(Field::height_rate, 16, 16).front();
    add(assembly, height, pair_fields, {three_fields});
    EXPECT_TRUE(add(assembly, rate, pair_fields, {three_fields}).acknowledge);
    EXPECT_TRUE(add(assembly, height, pair_fields, {three_fields}).acknowledge);
}

TEST(TileAssembly, the_end_of_a_request_hands_out_keyframes_that_lack_what_is_not_offered) {
    TileAssembly assembly;
    add(assembly, parts_of(Field::height, 16, 16).front(), {}, {three_fields});
    EXPECT_FALSE(
        add(assembly, parts_of(Field::height_rate, 16, 16).front(), {}, {three_fields}).complete);
    const std::vector<HeldKeyframePtr> rest = assembly.finish(pair_fields);
    ASSERT_EQ(rest.size(), 1u);
    EXPECT_EQ(rest.front()->keyframe().fields, pair_fields);
    EXPECT_EQ(assembly.keyframes(), 0u);
}

// Naive: what has been handed out to a request is forgotten with it, and what the stream still sends of it
// is acknowledged by nobody.
TEST(TileAssembly, what_the_stream_has_not_finished_outlives_the_request_that_had_enough) {
    TileAssembly assembly;
    const auto part = [](Field field) { return parts_of(field, 16, 16).front(); };
    add(assembly, part(Field::height), three_fields, {pair_fields});
    ASSERT_TRUE(add(assembly, part(Field::height_rate), three_fields, {pair_fields}).complete);
    EXPECT_TRUE(assembly.finish(pair_fields).empty()) << "it was handed out";
    const auto last = add(assembly, part(Field::displacement_x), three_fields);
    EXPECT_TRUE(last.acknowledge);
    ASSERT_TRUE(last.complete);
    EXPECT_EQ(last.complete->keyframe().fields, three_fields);
    EXPECT_EQ(assembly.keyframes(), 0u);
}

// Naive: all of it has been seen, and nothing is handed out. A client that lets pass what it did not know that it wants asks again.
TEST(TileAssembly, a_request_that_asks_again_gets_what_an_earlier_one_was_handed) {
    TileAssembly assembly;
    const auto part = [](Field field) { return parts_of(field, 16, 16).front(); };
    for (int request = 0; request < 3; ++request) {
        int complete = 0;
        for (const Field field : {Field::height, Field::height_rate})
            complete += add(assembly, part(field), three_fields, {pair_fields}).complete != nullptr;
        EXPECT_EQ(complete, 1) << request;
        EXPECT_FALSE(add(assembly, part(Field::height), three_fields, {pair_fields}).complete)
            << "a copy, while the request goes on";
        EXPECT_TRUE(assembly.finish(pair_fields).empty()) << request;
    }
    // The stream still gets its own.
    EXPECT_TRUE(add(assembly, part(Field::displacement_x), three_fields).acknowledge);
    EXPECT_EQ(assembly.keyframes(), 0u);
}

TEST(TileAssembly, parts_belong_together_by_number_epoch_cascade_and_time) {
    const std::vector<Part> parts = parts_of(Field::height, 32, 16);
    for (int differs = -1; differs < 4; ++differs) {
        TileAssembly assembly;
        HeldKeyframePtr complete;
        for (std::size_t i = 0; i < parts.size(); ++i) {
            Part part = parts[i];
            if (i == 2) {
                part.header.keyframe += differs == 0;
                part.header.epoch += differs == 1;
                part.header.cascade += differs == 2;
                part.header.time_us += differs == 3;
            }
            complete = add(assembly, part, {Field::height}).complete;
        }
        EXPECT_EQ(complete != nullptr, differs == -1) << differs;
        EXPECT_EQ(assembly.keyframes(), differs == -1 ? 0u : 2u) << differs;
    }
}

TEST(TileAssembly, a_keyframe_begun_under_an_earlier_grant_is_acknowledged_under_it) {
    TileAssembly assembly;
    add(assembly, parts_of(Field::height, 16, 16).front(), pair_fields);
    EXPECT_TRUE(
        add(assembly, parts_of(Field::height_rate, 16, 16).front(), three_fields).acknowledge);
}

TEST(TileAssembly, never_grows_beyond_its_limits) {
    TileAssembly assembly;
    for (std::uint64_t n = 1; n <= 1000; ++n)
        add(assembly, parts_of(Field::height, 16, 16, n).front(), pair_fields);
    EXPECT_EQ(assembly.keyframes(), TileAssembly::keyframes_max);
    EXPECT_EQ(assembly.bytes(), TileAssembly::keyframes_max * 16 * 16 * sizeof(float));
    EXPECT_EQ(assembly.dropped(), 1000 - TileAssembly::keyframes_max);
    assembly.finish(pair_fields);
    EXPECT_EQ(assembly.keyframes(), static_cast<std::size_t>(protocol::limits::credit_max));
    EXPECT_EQ(assembly.bytes(), assembly.keyframes() * 16 * 16 * sizeof(float));
}

TEST(TileAssembly, bytes_that_make_no_sense_are_errors) {
    const std::vector<Part> parts = parts_of(Field::height, 32, 16);
    const auto says = [&](Part part, const char* what) {
        TileAssembly assembly;
        ASSERT_TRUE(assembly.add(parts[0].header, parts[0].payload, cascade_of(parts[0]), 0,
                                 pair_fields, {}));
        const auto added =
            assembly.add(part.header, part.payload, cascade_of(parts[0]), 0, pair_fields, {});
        ASSERT_FALSE(added) << what;
        EXPECT_NE(added.error().message.find(what), std::string::npos) << added.error().message;
    };
    Part part = parts[1];
    part.header.size = 64;
    says(part, "size 64");
    part = parts[1];
    part.header.parts = 5;
    says(part, "5 parts");
    part = parts[1];
    part.header.time_us = INT64_MAX;
    says(part, "out of range");
    part = parts[1];
    part.payload.resize(part.payload.size() / 2);
    says(part, "tile of height");
    // Naive: what follows is looked at in the first part alone, and taken from the last: on a grid that nothing can be made of.
    part = parts[1];
    part.header.follows = {Field::displacement_x};
    says(part, "other fields follow");
}

TEST(TileAssembly, parts_that_leave_a_hole_or_overfill_the_map_are_errors) {
    std::vector<Part> parts = parts_of(Field::height, 32, 16);
    for (Part& part : parts)
        part.header.parts = 2;
    TileAssembly hole;
    ASSERT_TRUE(
        hole.add(parts[0].header, parts[0].payload, cascade_of(parts[0]), 0, pair_fields, {}));
    const auto added =
        hole.add(parts[1].header, parts[1].payload, cascade_of(parts[0]), 0, pair_fields, {});
    ASSERT_FALSE(added);
    EXPECT_NE(added.error().message.find("cover"), std::string::npos);

    TileAssembly overfull;
    for (int n = 0; n < 4; ++n) {
        parts[0].header.parts = 64;
        parts[0].header.part = n;
        ASSERT_TRUE(overfull.add(parts[0].header, parts[0].payload, cascade_of(parts[0]), 0,
                                 pair_fields, {}));
    }
    parts[0].header.part = 4;
    EXPECT_FALSE(
        overfull.add(parts[0].header, parts[0].payload, cascade_of(parts[0]), 0, pair_fields, {}));
}

} // namespace
} // namespace seaway::client
