// SPDX-License-Identifier: Apache-2.0
// What the encoder makes of maps that are sent on a smaller grid.
#include <cmath>

#include <gtest/gtest.h>

#include "protocol/tile_codec.h"
#include "server/publish/encoder.h"
#include "tests/server/publish/tile_of.h"

namespace seaway::server {
namespace {

/// One wave of each field, which a grid of 9 points or more holds; foam holds more than that.
float wave_at(sea::Field field, double x, double y) {
    if (field == sea::Field::foam)
        return x < 0.5 ? 1.0f : 0.0f;
    return static_cast<float>(
        std::cos(2.0 * 3.14159265358979 * (3 * x - 2 * y) + static_cast<double>(field)));
}

sea::Keyframe wave_keyframe(int size, sea::FieldSet fields) {
    sea::Keyframe made;
    made.size = size;
    made.length_m = 100;
    made.fields = fields;
    made.values.resize(made.plane_size() * static_cast<std::size_t>(fields.size()));
    for (const sea::Field field : fields)
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x)
                made.plane(field)[static_cast<std::size_t>(y * size + x)] =
                    wave_at(field, 1.0 * x / size, 1.0 * y / size);
    return made;
}

// What an older client gets and a compact one: whole grids at one quality, at another the same waves at the smaller
// grid's points. What is no sum of waves keeps its own grid.
TEST(Encoder, compact_maps_are_the_same_waves_on_the_smaller_grid) {
    Encoder encoder;
    const sea::FieldSet fields{sea::Field::height, sea::Field::displacement_x,
                               sea::Field::height_rate, sea::Field::foam};
    const sea::Keyframe original = wave_keyframe(64, fields);
    const float bounds[] = {1e-3f, 2e-3f, 3e-3f, 4e-3f};
    const auto whole = encoder.encode(original, bounds, 0, fields);
    const auto compact =
        encoder.encode(original, bounds, 5, fields, {10, sea::following(sea::surface_fields)});
    ASSERT_TRUE(whole.has_value() && compact.has_value());
    EXPECT_NE((*whole)->number, (*compact)->number);
    for (const auto& [encoded, linear_size] : {std::pair(*whole, 64), {*compact, 10}})
        for (const EncodedField& map : encoded->maps) {
            ASSERT_EQ(map.parts.size(), 1u);
            const wire::Tile& tile = tile_of(map.parts[0]);
            const int size = map.field == sea::Field::foam ? 64 : linear_size;
            ASSERT_EQ(tile.size(), size);
            EXPECT_EQ(tile.follows(), encoded == *whole ? 0u : sea::following(map.field).bits());
            ASSERT_TRUE(protocol::check(tile).has_value());
            std::vector<float> back(static_cast<std::size_t>(size * size));
            ASSERT_TRUE(protocol::decode_tile({tile.payload()->data(), tile.payload()->size()},
                                              {size, size}, static_cast<std::size_t>(size), back)
                            .has_value());
            for (int y = 0; y < size; ++y)
                for (int x = 0; x < size; ++x)
                    ASSERT_NEAR(back[static_cast<std::size_t>(y * size + x)],
                                wave_at(map.field, 1.0 * x / size, 1.0 * y / size),
                                map.error + 4e-6f) // and single precision of a wave of 1
                        << sea::info(map.field).name;
        }
    const auto again =
        encoder.encode(original, bounds, 5, fields, {10, sea::following(sea::surface_fields)});
    EXPECT_EQ(*again, *compact) << "encoded once";
}

} // namespace
} // namespace seaway::server
