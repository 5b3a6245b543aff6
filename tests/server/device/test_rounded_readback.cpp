// SPDX-License-Identifier: Apache-2.0
// Maps that travel as whole steps of 16 bits: within the bound that was asked for, the integers that this side would have
// come to, half the bytes; and fields for which 16 bits are too few travel as they are. lavapipe, treated as a device
// whose memory the CPU cannot read.
#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/worse.h"
#include "gpu/call.h"
#include "server/device/vulkan_synthesizer.h"
#include "tests/gpu/held_drivers.h"
#include "tests/gpu/read_in_place.h"
#include "tests/server/device/random_sea.h"
#include "tests/support/largest_difference.h"

namespace seaway::server {
namespace {

using sea::Field;
using sea::FieldSet;

const FieldSet rounded_fields{Field::height, Field::displacement_x, Field::slope_y,
                              Field::jacobian};
/// In table order, in the fields' units: of waves of 3 m and slopes of 0.1 some thousand steps.
const std::vector<float> bounds{0.001f, 0.002f, 0.0005f, 0.0003f};
constexpr std::size_t map_points = 64 * 64;

class RoundedReadback : public testing::Test {
  protected:
    void SetUp() override {
        device_ = make_vulkan_synthesizer({.validation = true, .staged = true}).value();
        ASSERT_TRUE(device_->set_sea(random_.realization(), 1));
    }
    void TearDown() override {
        gpu::fault::disarm();
        EXPECT_THAT(device_->validation_messages(), testing::IsEmpty());
    }
    std::vector<KeyframeRequest> requests(int count, std::span<const float> rounding) const {
        std::vector<KeyframeRequest> all;
        for (int i = 0; i < count; ++i)
            all.push_back({0, i * 700'000, rounded_fields, 1, nullptr, rounding});
        return all;
    }
    std::vector<NewKeyframePtr> made(int count, std::span<const float> rounding) {
        return device_->synthesize(requests(count, rounding)).value();
    }
    SynthesisCounters spent(int count, std::span<const float> rounding) {
        const SynthesisCounters before = device_->counters();
        made(count, rounding);
        return device_->counters() - before;
    }

    /// Of a history of its own, whose ticks add so many times what breaks; the last is shown as it is.
    std::vector<NewKeyframePtr> with_foam(float source, std::span<const float> rounding) {
        const FoamMapPtr map = device_->open_foam(64, nullptr).value();
        sea::FoamTick tick = some_tick;
        tick.source = source;
        const FoamTurn turn{map.get(), tick, {sea::FoamTick::without_strains(1.0f, 0.0f), 1.0f}};
        std::vector<KeyframeRequest> all;
        for (int i = 0; i < 6; ++i)
            all.push_back({0, i * 700'000, FieldSet{Field::height, Field::foam}, 1, &turn,
                           i < 5 ? rounding : std::span<const float>()});
        return device_->synthesize(all).value();
    }

    RandomSea random_{64, 200.0, 1, {1.1, 0.9}};
    std::unique_ptr<VulkanSynthesizer> device_;
};

// A device divides by a product with the inverse, in single precision: of n steps that is off by n 2^-23 of one, a 256th
// at most, so that where a sample lies as near to the middle of two steps it may come to the other one. Its bound has room
// for that.
TEST_F(RoundedReadback,
       samples_are_whole_steps_within_the_bound_and_those_that_this_side_would_take) {
    const std::vector<NewKeyframePtr> exact = made(7, {}), rounded = made(7, bounds);
    double worst = 0;
    std::size_t other = 0, samples = 0;
    for (std::size_t i = 0; i < exact.size(); ++i) {
        EXPECT_TRUE(exact[i]->rounded.empty());
        ASSERT_EQ(rounded[i]->rounded.size(), bounds.size());
        std::size_t place = 0;
        for (const Field field : rounded_fields) {
            const sea::RoundedMap& map = *rounded[i]->rounded_map(field);
            EXPECT_EQ(map.error, bounds[place]);
            EXPECT_GT(map.step, 1.97f * bounds[place]) << "no finer than it has to be";
            ++place;
            ASSERT_EQ(map.steps.size(), map_points);
            for (std::size_t p = 0; p < map_points; ++p) {
                const auto value = static_cast<double>(exact[i]->plane(field)[p]);
                const auto read = static_cast<double>(rounded[i]->plane(field)[p]);
                const auto step = static_cast<double>(map.step);
                ASSERT_EQ(rounded[i]->plane(field)[p], static_cast<float>(map.steps[p] * step));
                worst = worse(worst, std::abs(read - value) / static_cast<double>(map.error));
                const auto here = static_cast<int>(std::lround(value / step));
                ASSERT_LE(std::abs(map.steps[p] - here), 1);
                other += map.steps[p] != here;
                ++samples;
            }
        }
    }
    EXPECT_LE(worst, 1.0);
    EXPECT_GT(worst, 0.98) << "steps are as wide as the bound allows";
    // Two in 256 lie so near to a middle where all are at 32767 steps; here they are at some thousand.
    EXPECT_LT(static_cast<double>(other), 0.002 * static_cast<double>(samples));
}

TEST_F(RoundedReadback, half_the_bytes_travel) {
    const SynthesisCounters exact = spent(7, {}), rounded = spent(7, bounds);
    constexpr std::uint64_t maps = 7 * 4;
    EXPECT_EQ(exact.readback_bytes, maps * map_points * sizeof(float))
        << "the Jacobian's three strains stay where they are";
    EXPECT_EQ(rounded.readback_bytes, maps * (map_points * sizeof(std::int16_t) + 4))
        << "and of each map whether it fits";
    EXPECT_EQ(exact.maps_rounded, 0u);
    EXPECT_EQ(rounded.maps_rounded, maps);
    EXPECT_EQ(rounded.copies, 7u);
}

TEST_F(RoundedReadback, what_16_bits_are_too_few_for_travels_as_it_is_and_is_counted_by_its_name) {
    std::vector<float> fine = bounds;
    fine[0] = 1e-6f; // 3 m of waves are a million of these
    const std::vector<NewKeyframePtr> exact = made(7, {}), usual = made(7, bounds);
    const SynthesisCounters before = device_->counters();
    const std::vector<NewKeyframePtr> mixed = made(7, fine);
    const SynthesisCounters counts = device_->counters() - before;
    EXPECT_EQ(counts.maps_rounded, 7u * 3);
    EXPECT_EQ(counts.readback_bytes,
              7 * (4 * (map_points * sizeof(std::int16_t) + 4) + map_points * sizeof(float)))
        << "heights a second time, nothing else";
    for (const sea::FieldInfo& row : sea::field_table)
        EXPECT_EQ(counts.maps_too_large[static_cast<std::size_t>(row.field)],
                  row.field == Field::height ? 7u : 0u)
            << row.name;
    for (std::size_t i = 0; i < mixed.size(); ++i) {
        EXPECT_EQ(mixed[i]->rounded_map(Field::height), nullptr);
        EXPECT_TRUE(
            std::ranges::equal(mixed[i]->plane(Field::height), exact[i]->plane(Field::height)));
        EXPECT_EQ(mixed[i]->rounded.size(), 3u);
        for (const Field field : {Field::displacement_x, Field::slope_y, Field::jacobian})
            EXPECT_TRUE(std::ranges::equal(mixed[i]->plane(field), usual[i]->plane(field)));
    }
}

// Nothing is between them: 32767 steps fit, and one more does not.
TEST_F(RoundedReadback, the_largest_sample_that_fits_has_32767_steps) {
    const auto exact = made(1, {});
    float most = 0;
    for (const float sample : exact[0]->plane(Field::height))
        most = std::max(most, std::abs(sample));
    const auto steps_of = [&](double steps) {
        std::vector<float> own = bounds;
        own[0] = static_cast<float>(static_cast<double>(most) / steps * 0.50586);
        return made(1, own)[0];
    };
    const auto fits = steps_of(32740); // the step is up to a 4096th smaller than the bound allows
    ASSERT_NE(fits->rounded_map(Field::height), nullptr);
    const auto& steps = fits->rounded_map(Field::height)->steps;
    EXPECT_GT(std::max(std::abs(*std::ranges::max_element(steps)),
                       std::abs(*std::ranges::min_element(steps))),
              32700);
    EXPECT_EQ(steps_of(32780)->rounded_map(Field::height), nullptr);
}

TEST_F(RoundedReadback, a_request_alone_and_in_company_of_others_is_the_same) {
    std::vector<KeyframeRequest> mixed;
    for (int i = 0; i < 24;
         ++i) // rounded ones and exact ones, of other lists of fields, on the ring
        mixed.push_back(
            {0, i * 300'000, i % 3 == 0 ? rounded_fields : FieldSet{Field::height_rate}, 1, nullptr,
             i % 2 == 0 ? std::span(bounds).first(i % 3 == 0 ? 4 : 1) : std::span<const float>()});
    const auto together = device_->synthesize(mixed).value();
    for (std::size_t i = 0; i < mixed.size(); ++i) {
        const auto alone = device_->synthesize({&mixed[i], 1}).value()[0];
        EXPECT_EQ(together[i]->values, alone->values) << i;
        EXPECT_EQ(together[i]->rounded.empty(), mixed[i].rounding.empty()) << i;
    }
    EXPECT_GT(device_->counters().readbacks_beside, 3u);
}

TEST_F(RoundedReadback, foam_that_the_caller_fills_is_not_looked_at) {
    const std::vector<float> two{0.001f, 0.01f};
    const KeyframeRequest request{0, 0, {Field::height, Field::foam}, 1, nullptr, two};
    const auto keyframe = device_->synthesize({&request, 1}).value()[0];
    EXPECT_NE(keyframe->rounded_map(Field::height), nullptr);
    EXPECT_EQ(keyframe->rounded_map(Field::foam), nullptr);
    EXPECT_EQ(keyframe->plane(Field::foam).size(), map_points);
    EXPECT_EQ(device_->counters().maps_too_large[static_cast<std::size_t>(Field::foam)], 0u);
}

// Ratios reach some hundreds, which 16 bits are too few for at the bound that servers ask for. What a device keeps is never
// rounded: else every tick would add to what is lost.
TEST_F(RoundedReadback, foam_of_a_turn_is_within_its_bound_or_exact_and_goes_on_unrounded) {
    const std::vector<float> two{0.001f, 0.0008f};
    for (const float source : {1.0f, 1000.0f}) {
        const bool fits = source == 1.0f;
        const auto exact = with_foam(source, {});
        const SynthesisCounters before = device_->counters();
        const auto rounded = with_foam(source, two);
        const SynthesisCounters counts = device_->counters() - before;
        EXPECT_EQ(counts.maps_rounded, fits ? 10u : 5u);
        EXPECT_EQ(counts.maps_too_large[static_cast<std::size_t>(Field::foam)], fits ? 0u : 5u);
        for (std::size_t i = 0; i < 5; ++i) {
            const std::span<const float> ratios = exact[i]->plane(Field::foam);
            EXPECT_EQ(*std::ranges::max_element(ratios) < 2 * 32767 * two[1], fits) << i;
            const sea::RoundedMap* map = rounded[i]->rounded_map(Field::foam);
            ASSERT_EQ(map != nullptr, fits) << source << ", " << i;
            const double off = tests::largest_difference(rounded[i]->plane(Field::foam), ratios);
            EXPECT_LE(off, map ? static_cast<double>(map->error) : 0.0) << source << ", " << i;
            EXPECT_EQ(off > 0, fits) << "it was rounded";
        }
        EXPECT_TRUE(rounded[5]->rounded.empty());
        EXPECT_EQ(rounded[5]->values, exact[5]->values) << source;
    }
}

TEST_F(RoundedReadback, where_memory_is_read_in_place_nothing_is_rounded) {
    if (!gpu::reads_in_place())
        GTEST_SKIP() << gpu::not_in_place;
    const auto plain = make_vulkan_synthesizer({.validation = true}).value();
    ASSERT_TRUE(plain->set_sea(random_.realization(), 1));
    const auto keyframe = plain->synthesize(requests(1, bounds)).value()[0];
    EXPECT_TRUE(keyframe->rounded.empty());
    EXPECT_EQ(keyframe->values, made(1, {})[0]->values);
    EXPECT_THAT(plain->validation_messages(), testing::IsEmpty());
}

TEST_F(RoundedReadback, after_any_call_that_fails_once_the_next_keyframes_are_right) {
    std::vector<float> fine = bounds;
    fine[0] = 1e-6f; // so that some travel again
    const auto right = made(9, fine);
    const std::uint64_t before = gpu::fault::calls();
    made(9, fine);
    const std::uint64_t calls = gpu::fault::calls() - before;
    ASSERT_GT(calls, 20u);
    for (std::uint64_t n = 1; n <= calls; ++n) {
        gpu::fault::arm(n, VK_ERROR_OUT_OF_HOST_MEMORY);
        EXPECT_FALSE(device_->synthesize(requests(9, fine))) << "call " << n << " of " << calls;
        gpu::fault::disarm();
        const auto again = made(9, fine);
        for (std::size_t i = 0; i < right.size(); ++i)
            EXPECT_EQ(again[i]->values, right[i]->values) << i << ", after call " << n;
    }
}

} // namespace
} // namespace seaway::server
