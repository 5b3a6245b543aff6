// SPDX-License-Identifier: Apache-2.0
// The native synthesizer as the server sees it, and against the Vulkan one: two implementations
// that share nothing but the field table and the codelets.
#include "server/device/native_synthesizer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/worse.h"
#include "sea/foam/foam.h"
#include "sea/waves/sine_waves.h"
#include "server/device/vulkan_synthesizer.h"
#include "tests/server/device/random_sea.h"
#include "tests/support/largest_difference.h"

namespace seaway::server {
namespace {

using sea::Field;
using sea::FieldSet;

sea::KeyframePtr keyframe(Synthesizer& synthesizer, FieldSet fields, sea::TimeUs time_us) {
    const KeyframeRequest request{0, time_us, fields};
    auto made = synthesizer.synthesize({&request, 1});
    EXPECT_TRUE(made) << made.error().message;
    return made ? made->front() : nullptr;
}

double rms(std::span<const float> values) {
    double sum = 0;
    for (float v : values)
        sum += double{v} * double{v};
    return std::sqrt(sum / static_cast<double>(values.size()));
}

class AgainstVulkan : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Sizes, AgainstVulkan, testing::Values(64, 128, 256, 512, 1024),
                         [](const auto& size) { return std::to_string(size.param); });

// Both are single precision with the same exact phases. 1e-6 of four times the rms (for the height:
// of Hs) is four times the rounding error of one of them; Vulkan packs two fields into one complex
// transform, so the scale is the larger of the fields asked for together. The Jacobian is a product
// of 1 + strain: its errors are those of the strains.
TEST_P(AgainstVulkan, every_list_of_fields_agrees_within_1e6_of_hs) {
    auto vulkan = make_vulkan_synthesizer({});
    ASSERT_TRUE(vulkan) << vulkan.error().message;
    NativeSynthesizer native;
    const RandomSea random(GetParam(), 500.0, 3, {1.2, 0.8});
    const Result<void> taken = (*vulkan)->set_sea(random.realization(), 1);
    ASSERT_TRUE(taken) << taken.error().message;
    ASSERT_TRUE(native.set_sea(random.realization(), 1));
    FieldSet fields;
    for (const Field added : sea::linear_fields | FieldSet{Field::jacobian}) {
        fields.insert(added);
        const int count = fields.size();
        const sea::TimeUs time_us = 1'000'000'007LL * count;
        const auto ours = keyframe(native, fields, time_us);
        const auto theirs = keyframe(**vulkan, fields, time_us);
        double scale = 0;
        for (Field field : fields)
            if (sea::is_linear(field))
                scale = worse(scale, 4 * rms(ours->plane(field)));
        for (Field field : fields)
            EXPECT_LE(tests::largest_difference(ours->plane(field), theirs->plane(field)),
                      1e-6 * scale)
                << sea::info(field).name << " in a list of " << count;
        EXPECT_LE(
            tests::largest_difference(ours->plane(Field::height), theirs->plane(Field::height)),
            1e-6 * 4 * rms(ours->plane(Field::height)));
    }
}

TEST(NativeSynthesizer, keyframes_carry_what_was_asked_in_order) {
    const RandomSea random(64, 500.0, 4);
    NativeSynthesizer native(2);
    ASSERT_TRUE(native.set_sea(random.realization(), 9));
    const KeyframeRequest requests[] = {{0, 1'000'000, {Field::height, Field::jacobian}},
                                        {0, 2'000'000, sea::surface_fields}};
    const auto made = native.synthesize(requests);
    ASSERT_TRUE(made);
    ASSERT_EQ(made->size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
        const sea::Keyframe& map = *(*made)[i];
        EXPECT_EQ(map.epoch, 9u);
        EXPECT_EQ(map.time_us, requests[i].time_us);
        EXPECT_EQ(map.fields, requests[i].fields);
        EXPECT_EQ(map.size, 64);
        EXPECT_EQ(map.length_m, 500.0);
        EXPECT_EQ(map.values.size(),
                  map.plane_size() * static_cast<std::size_t>(map.fields.size()));
    }
    // Height and the three strains of the Jacobian, then six fields.
    EXPECT_EQ(native.counters().transforms, 10u);
    EXPECT_EQ(native.counters().keyframes, 2u);
}

TEST(NativeSynthesizer, keyframes_of_several_cascades_in_one_call_are_those_of_each_alone) {
    auto sea = std::make_shared<sea::Realization>(*RandomSea(64, 500.0, 4).realization());
    sea->cascades.push_back(RandomSea(32, 123.0, 5).cascade());
    sea->cascades.push_back(RandomSea(64, 77.0, 6).cascade());
    const int sizes[] = {64, 32, 64};
    const double lengths_m[] = {500, 123, 77};
    for (const std::size_t c : {1, 2}) { // one crosses the tile askew, another way in each
        sea::SineField& field = sea->cascades[c].sines.emplace_back();
        field.length_m = lengths_m[c];
        field.sharpness = 2.0;
        const double step = 2 * M_PI / lengths_m[c], omega = 0.6;
        field.waves.push_back(
            {2 * step, (c == 1 ? -1 : 3) * step, 1.5, 0.4, sea::rate_from_omega(omega), omega});
    }
    NativeSynthesizer together(2);
    ASSERT_TRUE(together.set_sea(sea, 3));
    const KeyframeRequest requests[] = {{2, 1'000'000, {Field::height}},
                                        {0, 2'000'000, sea::surface_fields},
                                        {1, 1'000'000, {Field::slope_x, Field::slope_y}},
                                        {0, 1'000'000, {Field::height, Field::height_rate}}};
    const auto made = together.synthesize(requests);
    ASSERT_TRUE(made);
    ASSERT_EQ(made->size(), 4u);
    for (std::size_t i = 0; i < 4; ++i) {
        const sea::Keyframe& map = *(*made)[i];
        const auto c = static_cast<std::size_t>(requests[i].cascade);
        EXPECT_EQ(map.cascade, requests[i].cascade);
        EXPECT_EQ(map.time_us, requests[i].time_us);
        EXPECT_EQ(map.size, sizes[c]);
        EXPECT_EQ(map.length_m, lengths_m[c]);
        NativeSynthesizer alone(1);
        ASSERT_TRUE(alone.set_sea(sea, 3));
        const auto one = alone.synthesize({&requests[i], 1});
        ASSERT_TRUE(one);
        EXPECT_EQ(map.values, one->front()->values) << i;
    }
    EXPECT_EQ(together.counters().keyframes, 4u);
    EXPECT_EQ(together.counters().dispatches, 8u) << "two passes each";
    EXPECT_EQ(together.counters().transforms, 1u + 6 + 2 + 2);
}

TEST(NativeSynthesizer, nothing_asked_is_nothing_done) {
    const RandomSea random(64, 500.0, 5);
    NativeSynthesizer native;
    ASSERT_TRUE(native.set_sea(random.realization(), 1));
    const auto made = native.synthesize({});
    ASSERT_TRUE(made);
    EXPECT_TRUE(made->empty());
    EXPECT_EQ(native.counters().dispatches, 0u);
    EXPECT_EQ(native.counters().transforms, 0u);
}

TEST(NativeSynthesizer, a_held_keyframe_never_changes_while_others_are_made) {
    const RandomSea random(128, 500.0, 6);
    NativeSynthesizer native;
    ASSERT_TRUE(native.set_sea(random.realization(), 1));
    const auto held = keyframe(native, sea::surface_fields, 1'000'000);
    const sea::MapValues before = held->values;
    for (int i = 0; i < 20; ++i)
        keyframe(native, sea::surface_fields, 2'000'000 + i);
    EXPECT_EQ(held->values, before);
    EXPECT_EQ(keyframe(native, sea::surface_fields, 1'000'000)->values, before);
}

// Naive: threads that share the strains of the first, or a row that none takes.
TEST(NativeSynthesizer, foam_has_the_same_bits_with_any_number_of_threads) {
    const RandomSea random(128, 500.0, 6);
    const auto foam_with = [&](int threads) {
        NativeSynthesizer native(threads);
        EXPECT_TRUE(native.set_sea(random.realization(), 1));
        const FoamMapPtr map = native.open_foam(128, nullptr).value();
        sea::FoamTick tick{};
        tick.threshold = 1.1f;
        tick.choppiness_x = tick.choppiness_y = tick.choppiness_xy = 1;
        tick.variance = 0.01f;
        tick.constant_rest = 1e-10f;
        tick.remains = 0.6f;
        tick.source = 2;
        const FoamTurn turn{map.get(), tick, {tick, 0.9f}};
        sea::FoamRatios whole(128);
        std::vector<float> shown(128 * 128);
        for (sea::TimeUs time_us : {1'000'000, 1'500'000, 2'000'000}) {
            const FieldSet fields = sea::foam_inputs | FieldSet{Field::foam};
            const KeyframeRequest request{0, time_us, fields, 1, &turn};
            const sea::KeyframePtr made = native.synthesize({&request, 1}).value().front();
            whole.take(tick, made.get());
            whole.show(turn.shown, made.get(), shown);
            EXPECT_TRUE(std::ranges::equal(made->plane(Field::foam), shown)) << time_us;
        }
        EXPECT_EQ(native.counters().foam_ticks, 6u);
        return shown;
    };
    const std::vector<float> one = foam_with(1);
    EXPECT_NE(*std::ranges::min_element(one), *std::ranges::max_element(one));
    for (const int threads : {2, 5})
        EXPECT_EQ(foam_with(threads), one) << threads;
}

TEST(NativeSynthesizer, a_loop_comes_back_to_the_bit) {
    const RandomSea random(64, 500.0, 7);
    auto looping = std::make_shared<sea::Realization>(*random.realization());
    looping->loop_period_us = 60'000'000;
    NativeSynthesizer native;
    ASSERT_TRUE(native.set_sea(looping, 1));
    EXPECT_EQ(keyframe(native, {Field::height}, 7'000'000)->values,
              keyframe(native, {Field::height}, 7'000'000 + 1'000'000 * 60'000'000LL)->values);
}

TEST(NativeSynthesizer, stylised_waves_are_added_to_the_modes) {
    const RandomSea random(64, 500.0, 8);
    auto stylised = std::make_shared<sea::Realization>(*random.realization());
    sea::SineField& field = stylised->cascades[0].sines.emplace_back();
    field.length_m = 500.0;
    field.sharpness = 2.0;
    const double step = 2 * M_PI / 500.0, omega = 0.6;
    field.waves.push_back({3 * step, -2 * step, 1.5, 0.4, sea::rate_from_omega(omega), omega});
    NativeSynthesizer native;
    ASSERT_TRUE(native.set_sea(random.realization(), 1));
    const auto plain = keyframe(native, sea::linear_fields, 5'000'000);
    ASSERT_TRUE(native.set_sea(stylised, 2));
    const auto both = keyframe(native, sea::linear_fields, 5'000'000);
    EXPECT_EQ(native.counters().stylised_sums, 64u * 64);
    for (const auto& [x, y] : random_nodes(64, 200)) {
        const auto point = sea::sines_at(field, x * 500.0 / 64, y * 500.0 / 64, 5'000'000);
        for (const Field of : sea::linear_fields) {
            const std::size_t at = node(*both, x, y);
            // One float addition of heights of a few metres, and of slopes below one.
            const bool is_slope = of == Field::slope_x || of == Field::slope_y;
            EXPECT_NEAR(both->plane(of)[at] - plain->plane(of)[at], sea::value_of(point, of),
                        is_slope ? 2e-7 : 2e-6)
                << sea::info(of).name;
        }
    }
}

TEST(NativeSynthesizer, a_size_it_cannot_do_is_an_error_that_names_it) {
    const RandomSea random(64, 500.0, 9);
    auto large = std::make_shared<sea::Realization>(*random.realization());
    large->cascades[0].spec.size = 2048;
    NativeSynthesizer native;
    const auto refused = native.set_sea(large, 1);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("2048"), std::string::npos);
}

} // namespace
} // namespace seaway::server
