// SPDX-License-Identifier: Apache-2.0
// What `seaway-bench compare` says of two keyframes.
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "tools/bench/map_difference.h"

namespace seaway::bench {
namespace {

using sea::Field;

/// Heights of +-1 and slopes of +-0.1.
sea::Keyframe waves() {
    sea::Keyframe map;
    map.size = 8;
    map.fields = {Field::height, Field::slope_x};
    map.values.resize(2 * map.plane_size());
    for (std::size_t i = 0; i < map.plane_size(); ++i) {
        map.plane(Field::height)[i] = i % 2 == 0 ? 1.0f : -1.0f;
        map.plane(Field::slope_x)[i] = i % 2 == 0 ? 0.1f : -0.1f;
    }
    return map;
}

/// Of either beside the other.
void expect_difference(const sea::Keyframe& a, const sea::Keyframe& b, double share,
                       std::string_view field) {
    for (const auto& [first, second] : {std::pair(&a, &b), std::pair(&b, &a)}) {
        const MapDifference found = largest_difference(*first, *second);
        EXPECT_EQ(found.field, field);
        if (std::isinf(share))
            EXPECT_EQ(found.share, share);
        else
            EXPECT_NEAR(found.share, share, 1e-6); // floats
    }
}

TEST(MapDifference, is_a_share_of_four_times_the_rms_of_the_field_where_it_is_largest) {
    sea::Keyframe other = waves();
    expect_difference(waves(), other, 0, "none");
    other.plane(Field::height)[5] += 0.02f;
    expect_difference(waves(), other, 0.005, "height");
    other.plane(Field::slope_x)[7] += 0.004f;
    expect_difference(waves(), other, 0.01, "slope_x");
}

TEST(MapDifference, of_what_is_no_number_on_either_side_is_infinite) {
    for (const float nothing :
         {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        sea::Keyframe other = waves();
        other.plane(Field::slope_x)[3] = nothing;
        expect_difference(waves(), other, std::numeric_limits<double>::infinity(), "slope_x");
    }
}

TEST(MapDifference, of_a_field_that_is_flat_on_one_side_is_seen) {
    sea::Keyframe flat = waves();
    for (float& height : flat.plane(Field::height))
        height = 0;
    expect_difference(waves(), flat, 0.25, "height");
}

} // namespace
} // namespace seaway::bench
