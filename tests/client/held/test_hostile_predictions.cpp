// SPDX-License-Identifier: Apache-2.0
// Differences from a server that is no friend: what they name is not there, or is another map than it seems.
#include <gtest/gtest.h>

#include "client/held/tile_assembly.h"
#include "protocol/limits.h"
#include "protocol/tile_codec.h"

namespace seaway::client {
namespace {

using sea::Field;

constexpr sea::FieldSet two_fields{Field::height, Field::height_rate};

struct Sent {
    std::uint64_t keyframe = 1;
    int cascade = 0;
    Field field = Field::height;
    int size = 32;
    sea::TimeUs time_us = 0;
    int width = 32; ///< of its last part
    int parts = 1;
    bool differs = false;
};

/// All of one map of keyframe 1, or the last part of one of another keyframe as a difference to that.
Result<TileAssembly::Added> add(TileAssembly& assembly, const Sent& sent) {
    const auto points = static_cast<std::size_t>(sent.width * sent.width);
    std::vector<float> samples(points), expected(points, 0.25f), decoded(points);
    for (std::size_t i = 0; i < points; ++i)
        samples[i] = 0.25f + 0.01f * static_cast<float>(i % 7);
    const protocol::TileShape shape{sent.width, sent.width};
    const auto stride = static_cast<std::size_t>(sent.width);
    const auto forms =
        protocol::encode_tile_forms(samples, shape, stride, 0.01f, expected, decoded);
    EXPECT_TRUE(forms);
    const protocol::TileHeader header{.keyframe = sent.keyframe,
                                      .epoch = 1,
                                      .cascade = sent.cascade,
                                      .field = sent.field,
                                      .time_us = sent.time_us,
                                      .size = sent.size,
                                      .x0 = sent.size - sent.width,
                                      .y0 = sent.size - sent.width,
                                      .width = sent.width,
                                      .height = sent.width,
                                      .part = sent.parts - 1,
                                      .parts = sent.parts,
                                      .error = 0.01f,
                                      .base = 1};
    const protocol::CascadeInfo cascade{
        .length_m = 100, .size = sent.cascade == 0 ? sent.size : 2048, .interval_us = 100'000};
    return assembly.add(header, sent.differs ? forms->difference : forms->whole, cascade, 0,
                        two_fields, {}, sea::WaveLaw{});
}

void add_base(TileAssembly& assembly, int size, sea::TimeUs time_us = 0) {
    for (const Field field : two_fields)
        ASSERT_TRUE(
            add(assembly, {.field = field, .size = size, .time_us = time_us, .width = size}));
}

TEST(HostilePredictions, the_numbers_of_another_cascade_do_not_make_its_map_the_base) {
    for (const int size : {512, 1600, 2000}) {
        TileAssembly assembly;
        add_base(assembly, 32);
        const auto first = add(assembly, {.keyframe = 2, .time_us = 100'000, .differs = true});
        ASSERT_TRUE(first); // what it expects is known from here on
        const int per_axis =
            (size + protocol::limits::tile_side_max - 1) / protocol::limits::tile_side_max;
        const auto other =
            add(assembly, {.keyframe = 2,
                           .cascade = 1,
                           .size = size,
                           .time_us = 100'000,
                           .width = size - (per_axis - 1) * protocol::limits::tile_side_max,
                           .parts = per_axis * per_axis,
                           .differs = true});
        ASSERT_TRUE(other) << other.error().message;
        EXPECT_TRUE(other->unpredicted);
        const auto later = add(assembly, {.keyframe = 2, .time_us = 200'000, .differs = true});
        ASSERT_TRUE(later);
    }
}

// Grids that nothing is predicted on are no bases, whoever says so.
TEST(HostilePredictions, a_map_on_a_grid_that_nothing_is_predicted_on_is_no_base) {
    for (const int size : {7, 22}) {
        TileAssembly assembly;
        add_base(assembly, size);
        const auto next =
            add(assembly,
                {.keyframe = 2, .size = size, .time_us = 100'000, .width = size, .differs = true});
        ASSERT_TRUE(next) << next.error().message;
        EXPECT_TRUE(next->unpredicted) << size;
    }
}

TEST(HostilePredictions, times_at_both_ends_have_a_difference) {
    constexpr sea::TimeUs end_us = (sea::TimeUs{1} << 62) - 1;
    TileAssembly assembly;
    add_base(assembly, 32, -end_us);
    EXPECT_TRUE(add(assembly, {.keyframe = 2, .time_us = end_us, .differs = true}));
    EXPECT_FALSE(add(assembly, {.keyframe = 3, .time_us = end_us + 1, .differs = true}));
}

} // namespace
} // namespace seaway::client
