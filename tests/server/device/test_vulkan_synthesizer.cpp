// SPDX-License-Identifier: Apache-2.0
// The Vulkan synthesizer against sums in double precision. Validation layers are on; one message of
// theirs fails the test.
#include "server/device/vulkan_synthesizer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "base/worse.h"
#include "tests/gpu/held_drivers.h"
#include "tests/server/device/random_sea.h"

namespace seaway::server {
namespace {

using sea::Field;
using sea::FieldSet;
using testing::HasSubstr;

const FieldSet all_linear = sea::linear_fields;

class VulkanSynthesizerTest : public testing::Test {
  protected:
    explicit VulkanSynthesizerTest(VulkanOptions options = {}) {
        options.validation = true;
        Result<std::unique_ptr<VulkanSynthesizer>> made = make_vulkan_synthesizer(options);
        EXPECT_TRUE(made) << made.error().message;
        synthesizer_ = std::move(*made);
    }
    void TearDown() override {
        EXPECT_THAT(synthesizer_->validation_messages(), testing::IsEmpty());
    }

    void set_sea(sea::RealizationPtr sea, std::uint32_t epoch) {
        const Result<void> done = synthesizer_->set_sea(std::move(sea), epoch);
        ASSERT_TRUE(done) << done.error().message;
    }

    sea::KeyframePtr keyframe(int cascade, sea::TimeUs time_us, FieldSet fields) {
        const KeyframeRequest request{cascade, time_us, fields};
        Result<std::vector<NewKeyframePtr>> made = synthesizer_->synthesize({&request, 1});
        EXPECT_TRUE(made) << made.error().message;
        return made ? made->front() : nullptr;
    }

    void compare_2048(const RandomSea& random, const sea::Choppiness& choppiness);

    std::unique_ptr<VulkanSynthesizer> synthesizer_;
};

/// Every kernel that there is: each size, for seas made from spectra (0.6 of Nyquist) and for any
/// modes, in the fastest design and in the one for all devices, on memory as it is and as a
/// discrete GPU has it.
struct Variant {
    int size;
    double share_of_nyquist;
    VulkanOptions options;
};

std::vector<Variant> all_variants() {
    std::vector<Variant> variants;
    for (const int size : {64, 128, 256, 512, 1024})
        for (const double share : {0.6, 2.0})
            for (const bool any_device : {false, true}) {
                if ((size == 64 || size == 1024) && !any_device)
                    continue; // there are no others of these sizes
                variants.push_back(
                    {size, share, {.staged = size == 64, .any_device_kernels = any_device}});
            }
    variants.push_back({128, 0.6, {.staged = true}});
    return variants;
}

std::string name_of(const testing::TestParamInfo<Variant>& variant) {
    return std::to_string(variant.param.size) +
           (variant.param.share_of_nyquist < 1 ? "_band" : "_all_modes") +
           (variant.param.options.any_device_kernels ? "_any_device" : "_fastest") +
           (variant.param.options.staged ? "_staged" : "");
}

class AllKernels : public VulkanSynthesizerTest, public testing::WithParamInterface<Variant> {
  protected:
    AllKernels() : VulkanSynthesizerTest(GetParam().options) {}
    /// The sums of the largest maps take seconds; sizes of which another design was looked at
    /// closely get fewer.
    int nodes() const {
        return GetParam().size == 64 || !GetParam().options.any_device_kernels ? 200 : 10;
    }
    /// What was meant to be tested was: W, or the first that fits.
    void TearDown() override {
        VulkanSynthesizerTest::TearDown();
        const Variant& v = GetParam();
        const std::string first(
            fitting_transforms(gpu::tested_device_info(), v.size, v.share_of_nyquist < 1)
                .front()
                ->design);
        EXPECT_THAT(synthesizer_->description(),
                    HasSubstr(" " + (v.options.any_device_kernels ? "W" : first) + ":" +
                              std::to_string(v.size)));
        EXPECT_THAT(synthesizer_->description(), testing::Not(HasSubstr("refused")));
    }
    RandomSea random_sea(unsigned seed, sea::Choppiness choppiness = {}) const {
        return RandomSea(GetParam().size, 500.0, seed, choppiness, GetParam().share_of_nyquist);
    }
};
INSTANTIATE_TEST_SUITE_P(Kernels, AllKernels, testing::ValuesIn(all_variants()), name_of);

// 1e-5 Hs: floats carry 6e-8, a transform of a million points loses a few of them, the sine 1e-7.
TEST_P(AllKernels, B4_height_matches_the_direct_sum_within_1e5_of_hs_at_all_times) {
    const RandomSea random = random_sea(1);
    set_sea(random.realization(), 7);
    const std::vector<GridNode> looked_at = random_nodes(GetParam().size, nodes());
    for (const double t_s : {0.0, 12.34, 86'400.0, 1e6, 1e9, -3600.5}) {
        const sea::TimeUs time_us = sea::us_from_seconds(t_s);
        const sea::KeyframePtr map = keyframe(0, time_us, {Field::height});
        const FieldSums truth(random.cascade(), {Field::height}, time_us, looked_at);
        double worst = 0;
        for (std::size_t i = 0; i < looked_at.size(); ++i)
            worst = worse(worst, std::abs(truth.at(Field::height, i) -
                                          map->plane(Field::height)[node(*map, looked_at[i])]));
        EXPECT_LE(worst, 1e-5 * 4 * truth.rms(Field::height)) << "t = " << t_s;
        EXPECT_EQ(map->epoch, 7u);
        EXPECT_EQ(map->time_us, time_us);
    }
}

// Same bound for every field, in units of four times its own rms: no other field is in its
// transform.
TEST_P(AllKernels, every_field_matches_the_direct_sum) {
    const RandomSea random = random_sea(2);
    set_sea(random.realization(), 1);
    const sea::TimeUs time_us = 1'234'567'891;
    const sea::KeyframePtr map = keyframe(0, time_us, all_linear);
    const std::vector<GridNode> looked_at = random_nodes(GetParam().size, nodes() / 10);
    const FieldSums truth(random.cascade(), all_linear, time_us, looked_at);
    for (const Field field : all_linear) {
        double worst = 0;
        for (std::size_t i = 0; i < looked_at.size(); ++i)
            worst = worse(
                worst, std::abs(truth.at(field, i) - map->plane(field)[node(*map, looked_at[i])]));
        EXPECT_LE(worst, 1e-5 * 4 * truth.rms(field)) << sea::info(field).name;
    }
}

TEST_P(AllKernels, jacobian_is_the_determinant_of_the_strains) {
    const RandomSea random = random_sea(3, {1.4, 0.6});
    set_sea(random.realization(), 1);
    const FieldSet strains{Field::strain_xx, Field::strain_yy, Field::strain_xy, Field::jacobian};
    const sea::KeyframePtr map = keyframe(0, 5'000'000, strains);
    const sea::KeyframePtr alone = keyframe(0, 5'000'000, {Field::jacobian});
    double lowest = 1;
    for (std::size_t i = 0; i < map->plane_size(); ++i) {
        const double xx = map->plane(Field::strain_xx)[i], yy = map->plane(Field::strain_yy)[i],
                     xy = map->plane(Field::strain_xy)[i];
        const double expected = (1 + 1.4 * xx) * (1 + 0.6 * yy) - 1.4 * 0.6 * xy * xy;
        lowest = std::min(lowest, expected);
        // Three products of numbers near 1 in float.
        ASSERT_NEAR(map->plane(Field::jacobian)[i], expected, 1e-6);
        ASSERT_EQ(alone->plane(Field::jacobian)[i], map->plane(Field::jacobian)[i]);
    }
    EXPECT_LT(lowest, 0.95) << "the sea is too flat to tell anything";
}

TEST_P(AllKernels, variance_of_the_map_is_the_energy_of_its_modes) {
    const RandomSea random = random_sea(4);
    set_sea(random.realization(), 1);
    const sea::KeyframePtr map = keyframe(0, 77'000'000, {Field::height});
    double sum = 0;
    for (const float value : map->plane(Field::height))
        sum += static_cast<double>(value) * static_cast<double>(value);
    const double rms = FieldSums(random.cascade(), {Field::height}, 77'000'000).rms(Field::height);
    // Rounding errors of the points are independent: the sum is far better than one of them.
    EXPECT_NEAR(sum / static_cast<double>(map->plane_size()), rms * rms, 1e-6 * rms * rms);
}

void VulkanSynthesizerTest::compare_2048(const RandomSea& random,
                                         const sea::Choppiness& choppiness) {
    const sea::TimeUs time_us = 86'400'000'000;
    const FieldSet all = all_linear | FieldSet{Field::jacobian};
    const sea::KeyframePtr map = keyframe(0, time_us, all);
    ASSERT_TRUE(map);
    EXPECT_EQ(map->fields, all);
    const std::vector<GridNode> looked_at = random_nodes(2048, 3);
    const FieldSums truth(random.cascade(), all_linear, time_us, looked_at);
    for (const Field field : all_linear)
        for (std::size_t i = 0; i < looked_at.size(); ++i)
            EXPECT_NEAR(map->plane(field)[node(*map, looked_at[i])], truth.at(field, i),
                        1e-5 * 4 * truth.rms(field))
                << sea::info(field).name;
    for (const auto& there : random_nodes(2048, 500)) {
        const std::size_t index = node(*map, there.first, there.second);
        const auto at = [&](Field field) { return static_cast<double>(map->plane(field)[index]); };
        const double xy = at(Field::strain_xy), along = 1 + choppiness.x * at(Field::strain_xx),
                     across = 1 + choppiness.y * at(Field::strain_yy);
        const double shear = choppiness.x * choppiness.y * xy * xy;
        // Three products of numbers near 1 in float.
        EXPECT_NEAR(at(Field::jacobian), along * across - shear, 1e-6);
    }
}

// All fields of 2048 points a side are more than a device binds at once: they are made in parts, and no one notices. Sums
// of a million modes are long, and of few nodes. A band read what nobody had written beyond its last line.
TEST_F(VulkanSynthesizerTest, maps_of_2048_points_match_the_direct_sum_also_those_made_in_parts) {
    const sea::Choppiness choppiness{1.2, 0.8};
    for (const double share_of_nyquist : {2.0, 0.6}) { // any modes, then a band, in the same memory
        const RandomSea random(2048, 500.0, 9, choppiness, share_of_nyquist);
        set_sea(random.realization(), 1);
        compare_2048(random, choppiness);
    }
    EXPECT_EQ(synthesizer_->counters().keyframes, 2u);
}

// Naive: what stands between the passes is made of all fields at once, which is more than a device binds.
TEST_F(VulkanSynthesizerTest, stages_of_2048_points_are_made_in_parts_as_well_each_once) {
    const RandomSea random(2048, 500.0, 9, {1.2, 0.8}, 0.6);
    set_sea(random.realization(), 1);
    FieldSet all = FieldSet{Field::jacobian};
    for (const sea::FieldInfo& field : sea::field_table)
        if (sea::is_linear(field.field))
            all |= FieldSet{field.field};
    const auto stages = synthesizer_->stages({0, 1'000'000, all});
    ASSERT_TRUE(stages) << stages.error().message;
    std::map<std::string, int> made;
    for (const SynthesisStage& stage : *stages)
        EXPECT_EQ(++made[stage.pass + ": " + stage.name], 1) << stage.pass << ": " << stage.name;
    for (const Field field : all& sea::linear_fields)
        EXPECT_TRUE(std::ranges::any_of(*stages, [&](const SynthesisStage& stage) {
            return stage.name == sea::info(field).name;
        })) << sea::info(field).name;
}

TEST_F(VulkanSynthesizerTest, one_wave_travels_along_its_wavenumber_and_has_its_amplitude) {
    const int n = 128;
    const double omega = 1.7;
    const OneWave wave(n, 64.0, 3, 1, 0.5, omega);
    set_sea(wave.realization(), 1);
    for (const sea::TimeUs time_us : {0, 250'000, 500'000, 750'000}) {
        const sea::KeyframePtr map = keyframe(0, time_us, {Field::height});
        for (int y = 0; y < n; y += 5)
            for (int x = 0; x < n; ++x) {
                const double phase = 2 * std::numbers::pi * (3 * x + y) / n -
                                     sea::phase_rad(sea::rate_from_omega(omega), time_us);
                ASSERT_NEAR(map->plane(Field::height)[node(*map, x, y)], 0.5 * std::cos(phase),
                            1e-6);
            }
    }
}

// Kernels leave out what the band cannot hold, and mirror what has kx < 0: a wave alone, of every sign,
// at the edges of what they take together (4, 8, 16, the end of the band) and next to Nyquist, is the
// direct sum. Random seas fill every quadrant and do not see one that is lost.
TEST_F(VulkanSynthesizerTest, one_wave_of_every_sign_is_the_direct_sum_at_every_edge) {
    for (const int n : {64, 128}) {
        const int band_end = static_cast<int>(0.6 * n / 2);
        const int edges[] = {1, 3, 4, 7, 8, 15, 16, band_end, band_end + 1, n / 2 - 1};
        for (std::size_t i = 0; i < std::size(edges); ++i) {
            const int kx = edges[i], ky = edges[(i * 3 + 2) % std::size(edges)];
            for (const auto& [nx, ny] : {std::pair{kx, ky},
                                         {kx, -ky},
                                         {-kx, ky},
                                         {-kx, -ky},
                                         {kx, 0},
                                         {-kx, 0},
                                         {0, kx},
                                         {0, -kx}}) {
                const OneWave wave(n, 64.0, nx, ny, 0.5, 1.7);
                set_sea(wave.realization(), 1);
                const sea::TimeUs time_us = 12'340'000;
                const sea::KeyframePtr map = keyframe(0, time_us, {Field::height, Field::slope_y});
                const double phase = sea::phase_rad(sea::rate_from_omega(1.7), time_us);
                const double ky_radpm = 2 * std::numbers::pi * ny / 64.0;
                for (const auto& [x, y] : random_nodes(n, 200)) {
                    const double angle = 2 * std::numbers::pi * ((nx * x + ny * y) % n) / n - phase;
                    ASSERT_NEAR(map->plane(Field::height)[node(*map, x, y)], 0.5 * std::cos(angle),
                                1e-6)
                        << nx << ", " << ny << " of " << n;
                    ASSERT_NEAR(map->plane(Field::slope_y)[node(*map, x, y)],
                                -0.5 * ky_radpm * std::sin(angle), 2e-6 * std::abs(ky_radpm))
                        << nx << ", " << ny << " of " << n;
                }
            }
        }
    }
}

// D points at the crest from both sides and the surface is squeezed there (hard case T27).
TEST_F(VulkanSynthesizerTest, one_wave_is_sharpened_at_its_crest) {
    const int n = 64;
    const OneWave wave(n, 64.0, 2, 0, 1.0, 1.0);
    set_sea(wave.realization(), 1);
    const sea::KeyframePtr map =
        keyframe(0, 0, {Field::height, Field::displacement_x, Field::jacobian});
    const int crest = 0, trough = n / 4; // 2 waves on n points
    EXPECT_GT(map->plane(Field::height)[crest], 0.99);
    EXPECT_LT(map->plane(Field::height)[trough], -0.99);
    EXPECT_LT(map->plane(Field::displacement_x)[node(*map, 4, 0)], 0) << "behind the crest: back";
    EXPECT_GT(map->plane(Field::displacement_x)[node(*map, n - 4, 0)], 0) << "before it: on";
    EXPECT_LT(map->plane(Field::jacobian)[crest], map->plane(Field::jacobian)[trough]);
}

TEST_F(VulkanSynthesizerTest, any_number_of_fields_together_gives_the_same_bits) {
    const RandomSea random(128, 200.0, 5);
    set_sea(random.realization(), 1);
    const sea::KeyframePtr all = keyframe(0, 1'000'000, all_linear);
    const auto compare = [&](FieldSet fields) {
        const sea::KeyframePtr some = keyframe(0, 1'000'000, fields);
        ASSERT_EQ(some->fields, fields);
        ASSERT_EQ(some->values.size(),
                  some->plane_size() * static_cast<std::size_t>(fields.size()));
        for (const Field field : fields)
            for (std::size_t i = 0; i < all->plane_size(); ++i)
                ASSERT_EQ(some->plane(field)[i], all->plane(field)[i])
                    << sea::info(field).name << " among " << fields.size();
    };
    FieldSet more;
    for (const Field field : all_linear) {
        more.insert(field);
        compare(more);
        compare({field});
    }
}

TEST_F(VulkanSynthesizerTest, cost_follows_the_demand) {
    const RandomSea random(128, 200.0, 6);
    set_sea(random.realization(), 1);
    SynthesisCounters before = synthesizer_->counters();
    ASSERT_TRUE(synthesizer_->synthesize({}));
    keyframe(0, 0, {});
    EXPECT_EQ(synthesizer_->counters().dispatches, before.dispatches);
    keyframe(0, 0, {Field::height});
    EXPECT_EQ(synthesizer_->counters().transforms - before.transforms, 1u);
    EXPECT_LE(synthesizer_->counters().dispatches - before.dispatches, 4u);
    before = synthesizer_->counters();
    keyframe(0, 0, all_linear);
    EXPECT_EQ(synthesizer_->counters().transforms - before.transforms, 11u);
    EXPECT_GT(synthesizer_->counters().device_seconds, before.device_seconds);
    // The Jacobian is one dispatch more than the strains that it is made of, and no transform.
    const auto growth = [&](FieldSet fields) {
        const SynthesisCounters start = synthesizer_->counters();
        keyframe(0, 0, fields);
        return synthesizer_->counters() - start;
    };
    const SynthesisCounters strains =
        growth({Field::strain_xx, Field::strain_yy, Field::strain_xy});
    const SynthesisCounters jacobian = growth({Field::jacobian});
    EXPECT_EQ(jacobian.dispatches, strains.dispatches + 1);
    EXPECT_EQ(jacobian.transforms, 3u);
}

// More and fewer tiles of a size that was there before: each is what it is alone.
TEST_F(VulkanSynthesizerTest, a_sea_of_another_number_of_tiles_is_the_one_that_was_set) {
    const RandomSea tiles[] = {{64, 400.0, 7}, {64, 90.0, 8}, {64, 31.0, 9}};
    const std::vector<GridNode> looked_at = random_nodes(64, 5);
    for (const std::size_t count : {1u, 3u, 2u}) {
        auto sea = std::make_shared<sea::Realization>();
        for (std::size_t c = 0; c < count; ++c)
            sea->cascades.push_back(tiles[c].cascade());
        set_sea(sea, 1);
        std::vector<sea::KeyframePtr> together;
        for (std::size_t c = 0; c < count; ++c)
            together.push_back(keyframe(static_cast<int>(c), 1'000'000, {Field::height}));
        for (std::size_t c = 0; c < count; ++c) {
            const FieldSums sums(tiles[c].cascade(), {Field::height}, 1'000'000, looked_at);
            const sea::Keyframe& map = *together[c];
            for (std::size_t i = 0; i < looked_at.size(); ++i)
                EXPECT_NEAR(static_cast<double>(map.plane(Field::height)[node(map, looked_at[i])]),
                            sums.at(Field::height, i), 1e-4 * sums.rms(Field::height))
                    << count << ' ' << c;
        }
    }
}

TEST_F(VulkanSynthesizerTest, the_same_time_gives_the_same_bits_alone_and_in_company) {
    const RandomSea first(64, 400.0, 7), second(128, 90.0, 8), third(64, 31.0, 9);
    auto sea = std::make_shared<sea::Realization>();
    sea->cascades = {first.cascade(), second.cascade(), third.cascade()};
    set_sea(sea, 1);
    std::vector<KeyframeRequest> requests;
    for (int i = 0; i < 40; ++i)
        requests.push_back(
            {i % 3, 1'000'000 * i / 3,
             i % 5 == 0 ? FieldSet{Field::height, Field::jacobian} : sea::surface_fields});
    const Result<std::vector<NewKeyframePtr>> together = synthesizer_->synthesize(requests);
    ASSERT_TRUE(together) << together.error().message;
    for (std::size_t i = 0; i < requests.size(); ++i) {
        const sea::KeyframePtr alone =
            keyframe(requests[i].cascade, requests[i].time_us, requests[i].fields);
        EXPECT_EQ((*together)[i]->cascade, requests[i].cascade);
        EXPECT_EQ((*together)[i]->size, alone->size);
        EXPECT_EQ((*together)[i]->values, alone->values) << "request " << i;
    }
}

TEST_F(VulkanSynthesizerTest, a_sea_with_a_loop_period_repeats_to_the_bit) {
    const RandomSea random(64, 200.0, 10);
    auto sea = std::make_shared<sea::Realization>(*random.realization());
    sea->loop_period_us = 30'000'000;
    set_sea(sea, 1);
    const sea::KeyframePtr early = keyframe(0, 11'000'000, {Field::height});
    for (const sea::TimeUs turns : {1, 1000, -7})
        EXPECT_EQ(keyframe(0, 11'000'000 + turns * 30'000'000, {Field::height})->values,
                  early->values);
}

TEST_F(VulkanSynthesizerTest, a_new_sea_replaces_the_old_one) {
    const RandomSea first(64, 200.0, 11), second(64, 200.0, 12);
    set_sea(first.realization(), 1);
    const sea::KeyframePtr before = keyframe(0, 0, {Field::height});
    set_sea(second.realization(), 2);
    const sea::KeyframePtr after = keyframe(0, 0, {Field::height});
    EXPECT_EQ(after->epoch, 2u);
    EXPECT_NE(before->values, after->values);
    set_sea(first.realization(), 3);
    EXPECT_EQ(keyframe(0, 0, {Field::height})->values, before->values);
}

TEST_F(VulkanSynthesizerTest, a_size_without_kernels_is_an_error_that_lists_the_sizes) {
    const RandomSea random(32, 200.0, 13);
    const Result<void> refused = synthesizer_->set_sea(random.realization(), 1);
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().message, HasSubstr("64, 128, 256, 512, 1024, 2048"));
    const KeyframeRequest request{0, 0, {Field::height}};
    EXPECT_FALSE(synthesizer_->synthesize({&request, 1})) << "there is no sea";
}

TEST(VulkanSynthesizer, an_unknown_device_is_an_error_that_lists_the_devices) {
    const auto made = make_vulkan_synthesizer({.device = "no such device"});
    ASSERT_FALSE(made);
    EXPECT_THAT(made.error().message, HasSubstr("0 = "));
}

} // namespace
} // namespace seaway::server
