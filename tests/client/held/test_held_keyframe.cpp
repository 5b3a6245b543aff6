// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include <gtest/gtest.h>

#include "client/held/keyframe_ring.h"

namespace seaway::client {
namespace {

using sea::Field;
using sea::FieldSet;
using sea::TimeUs;

constexpr TimeUs held_interval_us = 100'000;

/// Every value of it is another.
HeldKeyframePtr keyframe(TimeUs time_us, FieldSet fields, int size) {
    sea::Keyframe made{1, 0, time_us, size, 50, fields, {}};
    made.values.resize(made.plane_size() * static_cast<std::size_t>(fields.size()));
    float next = static_cast<float>(time_us) * 1e-6f;
    for (float& value : made.values)
        value = next += 1e-5f;
    HeldKeyframe::FieldErrors errors{};
    errors.fill(0.001f);
    return std::make_shared<const HeldKeyframe>(std::move(made), errors);
}

TEST(HeldKeyframe, as_spline_it_samples_the_same_and_holds_half_the_memory) {
    const FieldSet fields = sea::surface_fields | FieldSet{Field::foam, Field::slope_x};
    const HeldKeyframePtr whole = keyframe(7 * held_interval_us, fields, 256);
    KeyframeRing ring({.as_splines = true});
    ring.insert(whole);
    const std::optional<KeyframePair> pair =
        ring.around(0, 1, 7 * held_interval_us, held_interval_us, fields);
    ASSERT_TRUE(pair && pair->covers) << "what came is there to be sampled";
    const HeldKeyframe& held = *pair->before;
    EXPECT_EQ(held.fields(), fields);
    EXPECT_TRUE(std::ranges::equal(held.spline()->coefficients(), whole->spline()->coefficients()));
    EXPECT_EQ(held.error(Field::height), whole->error(Field::height));
    // What no spline stands for is kept as it came.
    EXPECT_EQ(held.keyframe().fields, (FieldSet{Field::foam, Field::slope_x}));
    for (const Field field : held.keyframe().fields)
        EXPECT_TRUE(
            std::ranges::equal(held.keyframe().plane(field), whole->keyframe().plane(field)));
    // Six planes of 256 KB less: of 4.4 MB 2.9 are left, 2.4 without the two others.
    EXPECT_EQ(whole->bytes() - held.bytes(), 6 * 256 * 256 * sizeof(float));
    EXPECT_EQ(ring.bytes(0), held.bytes());

    // Richer replaces poorer, and not the other way round, as where values are held.
    ring.insert(keyframe(7 * held_interval_us, {Field::height, Field::height_rate}, 256));
    EXPECT_EQ(ring.newest(0)->fields(), fields);
    // Foam alone has no spline: it stays as it is.
    const HeldKeyframePtr foam = keyframe(8 * held_interval_us, {Field::foam}, 16);
    ring.insert(foam);
    EXPECT_EQ(ring.newest(0), foam);
}

} // namespace
} // namespace seaway::client
