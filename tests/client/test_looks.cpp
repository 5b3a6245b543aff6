// SPDX-License-Identifier: Apache-2.0
// Looks: which cascades count for whom, and how foam is put together.
#include "client/looks.h"

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "client/held/keyframe_ring.h"
#include "client/link/connection.h"

namespace seaway {
namespace {

// Bands are half open, and a wave as long as was asked for counts.
TEST(Looks, cascades_all_of_whose_waves_are_shorter_are_not_felt) {
    client::SeaState state;
    for (const double longest_m : {0.0, 40.0, 8.0})
        state.cascades.push_back(
            {.k_lo_radpm = longest_m > 0 ? 2 * std::numbers::pi / longest_m : 0});
    EXPECT_EQ(client::felt_cascades(state, {}), 7u);
    EXPECT_EQ(client::felt_cascades(state, {.min_wavelength_m = 7.9}), 7u);
    EXPECT_EQ(client::felt_cascades(state, {.min_wavelength_m = 8.1}), 3u);
    EXPECT_EQ(client::felt_cascades(state, {.min_wavelength_m = 41}), 1u);
    EXPECT_EQ(client::felt_cascades(state, {.cascades = 6, .min_wavelength_m = 41}), 0u);
}

// Naive: k times the length that was told of it is more than 2 pi, of one k in twenty.
TEST(Looks, who_asks_for_waves_as_long_as_the_longest_of_a_cascade_feels_it) {
    for (int i = 1; i <= 10'000; ++i) {
        const double k_radpm = 1e-3 * i + 1e-7 * (i % 97);
        client::SeaState state;
        state.cascades.push_back({.k_lo_radpm = k_radpm});
        const double longest_m = 2 * std::numbers::pi / k_radpm;
        ASSERT_EQ(client::felt_cascades(state, {.min_wavelength_m = longest_m}), 1u) << k_radpm;
        ASSERT_EQ(client::felt_cascades(state, {.min_wavelength_m = 1.000001 * longest_m}), 0u);
    }
}

// Naive: what fades is not felt from the first moment of a glide on.
TEST(Looks, waves_of_either_end_of_a_glide_are_felt) {
    client::SeaState state;
    state.cascades.push_back({.k_lo_radpm = 0.2});
    const sea::Looking looking{.min_wavelength_m = 100};
    EXPECT_EQ(client::felt_cascades(state, looking), 0u);
    state.glide = protocol::GlideValues{};
    EXPECT_EQ(client::felt_cascades(state, looking), 0u) << "of a server that does not say";
    state.glide->k_lo_radpm = {0.03};
    EXPECT_EQ(client::felt_cascades(state, looking), 1u);
}

// Naive: to the last bit, and a server whose mathematics library was renewed runs another sea.
TEST(Looks, a_sea_is_the_same_one_where_its_probes_are_within_what_they_are_off_by) {
    client::SeaState state;
    state.probes = {{1, 2, 3'000'000, 4, 5, 6}};
    const auto with = [&](double off_m, double x_m) {
        client::SeaState other = state;
        other.probes[0].height_m += off_m;
        other.probes[0].displacement_y_m -= off_m;
        other.probes[0].x_m = x_m;
        return other;
    };
    EXPECT_TRUE(client::same_waves(state, with(1.9e-6, 1)));
    EXPECT_FALSE(client::same_waves(state, with(2.1e-6, 1)));
    EXPECT_FALSE(client::same_waves(state, with(0, 1.5)));
    client::SeaState glides = state;
    glides.glide = protocol::GlideValues{.leads_to = state.probes};
    EXPECT_FALSE(client::same_waves(state, glides));
    client::SeaState glides_too = glides;
    glides_too.glide->leads_to[0].height_m += 1e-6;
    EXPECT_TRUE(client::same_waves(glides, glides_too));
    glides_too.glide->leads_to[0].height_m += 1;
    EXPECT_FALSE(client::same_waves(glides, glides_too));
}

// docs/foam.md: mean (2 product (1 + ratio) / 2 - 1), clamped last; ratios are linear in space and time, over the edge of a tile
// as anywhere. Floats of some units: 1e-6.
TEST(Looks, foam_is_put_together_as_its_page_says) {
    client::SeaState state;
    state.foam_mean = 0.1;
    client::KeyframeRing ring;
    for (int cascade = 0; cascade < 2; ++cascade) {
        state.cascades.push_back({.length_m = 4, .size = 4, .interval_us = 100'000});
        for (const sea::TimeUs time_us : {0, 100'000}) {
            sea::Keyframe map{.epoch = 0,
                              .cascade = cascade,
                              .time_us = time_us,
                              .size = 4,
                              .length_m = 4,
                              .fields = {sea::Field::foam},
                              .values = std::vector<float>(16, cascade == 0 ? 1.0f : 3.0f)};
            if (cascade == 0) // to the east of the last column lies the first one
                for (std::size_t y = 0; y < 4; ++y)
                    map.values[4 * y] = time_us == 0 ? 5.0f : 9.0f;
            ring.insert(std::make_shared<client::HeldKeyframe>(
                std::move(map), client::HeldKeyframe::FieldErrors{}));
        }
    }
    const client::HeldFoam foam(state, ring, 25'000);
    const auto put_together = [](double first, double second) {
        return 0.1 * (2 * (1 + first) / 2 * (1 + second) / 2 - 1);
    };
    EXPECT_FALSE(foam.is_beyond());
    EXPECT_NEAR(foam.at({2, 1}), put_together(1, 3), 1e-6);
    EXPECT_NEAR(foam.at({3.25, 1.5}), put_together(0.75 * 1 + 0.25 * 6, 3), 1e-6);
    EXPECT_NEAR(foam.at({-0.75, -2.5}), foam.at({3.25, 1.5}), 1e-6);
    state.foam_mean = 0.5;
    EXPECT_EQ(client::HeldFoam(state, ring, 0).at({0, 0}), 1) << "no more than all of it";
    // Naive: a cascade whose keyframe is late says nothing, and its white water goes out.
    state.foam_mean = 0.1;
    for (const sea::TimeUs beyond_us : {100'001, 500'000, 50'000'000})
        EXPECT_NEAR(client::HeldFoam(state, ring, beyond_us).at({2, 1}), put_together(1, 3), 1e-6);
    EXPECT_TRUE(client::HeldFoam(state, ring, 500'000).is_beyond()) << "and is told apart";
    EXPECT_NEAR(client::HeldFoam(state, ring, 500'000).at({3.25, 1.5}),
                put_together(0.75 + 0.25 * 9, 3), 1e-6);
    state.epoch = 1;
    EXPECT_TRUE(std::isnan(client::HeldFoam(state, ring, 0).at({0, 0}))) << "none is held";
}
} // namespace
} // namespace seaway
