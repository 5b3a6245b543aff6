// SPDX-License-Identifier: Apache-2.0
// Maps that a device rounds on their way (--readback rounded), in every scene: each sample within what it may be off, tiles
// of every bound within theirs, answers within what they state. lavapipe, treated as a device with memory of its own.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <future>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "protocol/tile_codec.h"
#include "sea/scene/weather.h"
#include "server/device/vulkan_synthesizer.h"
#include "server/host/grant.h"
#include "server/publish/encoder.h"
#include "server/simulation/foam_maps.h"
#include "server/simulation/simulation.h"
#include "tests/server/publish/predicted_sea.h"
#include "tests/server/publish/tile_of.h"
#include "tests/server/simulation/simulation_bench.h"
#include "tests/support/largest_difference.h"

namespace seaway::server {
namespace {

using sea::Field;
using sea::FieldSet;

std::vector<std::string> scenes() {
    std::vector<std::string> found;
    for (const auto& entry : std::filesystem::directory_iterator(SEAWAY_SOURCE_DIR "/scenes"))
        if (entry.path().extension() == ".toml")
            found.push_back(entry.path().stem());
    std::ranges::sort(found);
    return found;
}

std::unique_ptr<VulkanSynthesizer> staged_device() {
    return make_vulkan_synthesizer({.validation = true, .staged = true}).value();
}

/// The map in its tiles, of so many points a side.
std::vector<float> decoded(const EncodedField& map, int size) {
    const auto stride = static_cast<std::size_t>(size);
    std::vector<float> back(stride * stride);
    for (const protocol::SharedBytes& bytes : map.parts) {
        const wire::Tile& tile = tile_of(bytes);
        EXPECT_TRUE(protocol::decode_tile({tile.payload()->data(), tile.payload()->size()},
                                          {tile.width(), tile.height()}, stride,
                                          std::span(back).subspan(tile.y0() * stride + tile.x0())));
    }
    return back;
}

class RoundedScene : public testing::TestWithParam<std::string> {
  protected:
    void SetUp() override {
        sea_ = make_running_sea(
                   sea::read_scene(SEAWAY_SOURCE_DIR "/scenes/" + GetParam() + ".toml").value(), 1)
                   .value();
        ASSERT_TRUE(device_->set_sea(sea_->realization, 1));
    }
    void TearDown() override { EXPECT_THAT(device_->validation_messages(), testing::IsEmpty()); }

    /// Of all cascades, without foam: here is no history that would fill it (RoundedFoam).
    std::vector<NewKeyframePtr> made(sea::TimeUs time_us, Readback readback) {
        std::vector<KeyframeRequest> requests;
        std::vector<std::vector<float>> bounds(sea_->budget.cascades.size());
        for (std::size_t c = 0; c < bounds.size(); ++c) {
            const int cascade = static_cast<int>(c);
            bounds[c] = rounding_bounds(sea_->budget, fields(), cascade, readback);
            requests.push_back({cascade, time_us, fields(), 1, nullptr, bounds[c]});
        }
        return device_->synthesize(requests).value();
    }
    bool has_waves(std::size_t cascade) const {
        return sea_->budget.cascades[cascade].codec_share > 0;
    }
    FieldSet fields() const { return sea_->offered.without({Field::foam}); }

    RunningSeaPtr sea_;
    std::unique_ptr<VulkanSynthesizer> device_ = staged_device();
};
INSTANTIATE_TEST_SUITE_P(Scenes, RoundedScene, testing::ValuesIn(scenes()), [](const auto& scene) {
    std::string name = scene.param;
    std::ranges::replace(name, '-', '_');
    return name;
});

TEST_P(RoundedScene, every_sample_is_within_what_it_may_be_off_and_half_the_bytes_travel) {
    std::size_t with_waves = 0; // a tile without them is sent exactly: it is zero
    for (std::size_t c = 0; c < sea_->budget.cascades.size(); ++c)
        with_waves += has_waves(c);
    for (const sea::TimeUs time_us : std::initializer_list<sea::TimeUs>{0, 86'400'000'000}) {
        const SynthesisCounters start = device_->counters();
        const auto exact = made(time_us, Readback::exact);
        const SynthesisCounters middle = device_->counters();
        const auto rounded = made(time_us, Readback::rounded);
        const SynthesisCounters as_it_is = middle - start, less = device_->counters() - middle;
        EXPECT_EQ(less.maps_rounded, with_waves * static_cast<std::size_t>(fields().size()))
            << "16 bits are enough for all";
        const double halved = static_cast<double>(with_waves) / static_cast<double>(exact.size());
        EXPECT_LE(static_cast<double>(less.readback_bytes),
                  (1.001 - 0.5 * halved) * static_cast<double>(as_it_is.readback_bytes));
        for (std::size_t c = 0; c < exact.size(); ++c)
            for (const Field field : fields()) {
                const sea::RoundedMap* map = rounded[c]->rounded_map(field);
                ASSERT_EQ(map != nullptr, has_waves(c)) << sea::info(field).name;
                double worst = 0;
                for (std::size_t i = 0; i < exact[c]->plane_size(); ++i)
                    worst =
                        std::max(worst, std::abs(static_cast<double>(rounded[c]->plane(field)[i]) -
                                                 static_cast<double>(exact[c]->plane(field)[i])));
                EXPECT_LE(worst, map ? static_cast<double>(map->error) : 0.0)
                    << sea::info(field).name;
            }
    }
}

// Of the best bound and of the widest, alone and as the base of predictions; those on smaller grids keep theirs in the
// mean square, as they do of exact maps.
TEST_P(RoundedScene, tiles_of_every_bound_are_within_it) {
    const auto exact = made(5'000'000, Readback::exact);
    const auto rounded = made(5'000'000, Readback::rounded);
    for (std::size_t codec = 0; codec < codec_rungs.size(); ++codec) {
        Encoder encoder;
        for (std::size_t c = 0; c < exact.size(); ++c) {
            const Quality quality = number_of({.codec = codec});
            const RungMaps maps =
                maps_of(sea_->budget, static_cast<int>(c), rounded[c]->fields, quality);
            const auto encoded =
                encoder.encode(*rounded[c], maps.codec_error, quality, rounded[c]->fields);
            ASSERT_TRUE(encoded) << encoded.error().message;
            for (const EncodedField& map : (*encoded)->maps) {
                const std::vector<float> back = decoded(map, exact[c]->size);
                double worst = 0;
                for (std::size_t i = 0; i < back.size(); ++i)
                    worst = std::max(worst,
                                     std::abs(static_cast<double>(back[i]) -
                                              static_cast<double>(exact[c]->plane(map.field)[i])));
                EXPECT_LE(worst, static_cast<double>(map.error))
                    << sea::info(map.field).name << " at " << codec_rungs[codec];
            }
        }
    }
}

// A keyframe can be sent at every quality that there is: what it was rounded by is less than each bound.
TEST_P(RoundedScene, every_quality_leaves_something_to_the_codec) {
    for (int c = 0; c < static_cast<int>(sea_->budget.cascades.size()); ++c) {
        const std::vector<float> off =
            rounding_bounds(sea_->budget, fields(), c, Readback::rounded);
        ASSERT_EQ(off.empty(), !has_waves(static_cast<std::size_t>(c)));
        for (Quality quality = 0; quality < quality_rungs; ++quality) {
            const RungMaps maps = maps_of(sea_->budget, c, fields(), quality);
            for (std::size_t i = 0; i < off.size(); ++i)
                ASSERT_LE(off[i], 1.001 * rounding_share * static_cast<double>(maps.codec_error[i]))
                    << "field " << i << ", " << quality;
        }
    }
    EXPECT_TRUE(rounding_bounds(sea_->budget, fields(), 0, Readback::exact).empty());
}

/// A simulation whose device rounds.
class RoundedAnswers {
  public:
    RoundedAnswers(RunningSeaPtr sea, Readback readback)
        : course_(std::make_shared<SeaCourse>(std::move(sea))) {
        simulation_ = Simulation::start(
                          course_,
                          [](const sea::RealizationPtr& realization, std::uint32_t epoch,
                             server::Making) -> Result<std::unique_ptr<Synthesizer>> {
                              std::unique_ptr<Synthesizer> made = staged_device();
                              SEAWAY_TRY(made->set_sea(realization, epoch));
                              return made;
                          },
                          subscriptions_, [] { return sea::TimeUs{0}; }, {}, {},
                          std::make_shared<Memory>(), 1, readback)
                          .value();
    }
    std::vector<sea::Answer> ask(std::vector<sea::QueryPoint> points, bool exact) {
        std::promise<Result<std::vector<sea::Answer>>> answered;
        simulation_->answer(
            std::move(points), exact,
            [&](Result<std::vector<sea::Answer>> answers) {
                answered.set_value(std::move(answers));
            },
            Asker::who_stays());
        return answered.get_future().get().value();
    }
    SynthesisCounters synthesis() const { return simulation_->counters().synthesis; }

  private:
    std::shared_ptr<SeaCourse> course_;
    Subscriptions subscriptions_;
    std::unique_ptr<Simulation> simulation_;
};

TEST_P(RoundedScene, answers_are_within_what_they_state_and_state_what_rounding_costs) {
    RoundedAnswers rounded(sea_, Readback::rounded), plain(sea_, Readback::exact);
    std::vector<sea::QueryPoint> points;
    for (int i = 0; i < 120; ++i)
        points.push_back({37.0 * i, 11.0 * i - 300.0, 2'000'000 + i % 6 * 70'000'000});
    const auto truth = plain.ask(points, true);
    const auto exact = plain.ask(points, false), off = rounded.ask(points, false);
    EXPECT_GT(rounded.synthesis().maps_rounded, 0u);
    EXPECT_EQ(plain.synthesis().maps_rounded, 0u);
    for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_LE(std::abs(off[i].height_m - truth[i].height_m), off[i].error_m + truth[i].error_m)
            << i;
        EXPECT_GT(off[i].error_m, exact[i].error_m) << "what is lost is said";
        // A fifth of what the codec may cost; a point is moved sideways, too, where the sea is steeper than the usual.
        EXPECT_LT(off[i].error_m, exact[i].error_m + 0.4 * sea_->budget.codec_error_m) << i;
    }
}

/// A sea that glides from 20 to 30 s, on a device that rounds.
class RoundedGlide : public testing::Test {
  protected:
    void SetUp() override {
        const RunningSeaPtr sea = running_sea();
        course_ = std::make_shared<SeaCourse>(sea);
        const TomlAssignment wind{"systems.0.wind_speed_10m_mps", "14.0"};
        ASSERT_TRUE(course_->add(sea::changed(sea->scene, {&wind, 1}).value(), 20 * second_us,
                                 30 * second_us));
        auto device = RebuiltSynthesizer::start(
            [](const sea::RealizationPtr& waves, std::uint32_t epoch,
               server::Making) -> Result<std::unique_ptr<Synthesizer>> {
                std::unique_ptr<Synthesizer> made = staged_device();
                SEAWAY_TRY(made->set_sea(waves, epoch));
                return made;
            },
            sea->realization, sea->epoch, {});
        synthesis_ = std::make_unique<CourseSynthesis>(course_, std::move(device).value());
    }
    NewKeyframePtr made(TimeUs time_us, std::span<const float> rounding) {
        const KeyframeRequest request{
            0, time_us, sea::surface_fields, course_->at(time_us)->epoch, nullptr, rounding};
        return synthesis_->synthesize({&request, 1}).value()[0];
    }

    std::shared_ptr<SeaCourse> course_;
    std::unique_ptr<CourseSynthesis> synthesis_;
};

// What rates have of the growth is added here, exactly: they are no whole steps any more, and no further off than before.
TEST_F(RoundedGlide, rates_have_what_the_sea_grows_by_and_are_no_further_off) {
    const TimeUs time_us = 24 * second_us;
    const std::vector<float> bounds =
        rounding_bounds(course_->at(time_us)->budget, sea::surface_fields, 0, Readback::rounded);
    ASSERT_FALSE(bounds.empty());
    const NewKeyframePtr exact = made(time_us, {}), rounded = made(time_us, bounds);
    for (const Field field : sea::surface_fields) {
        const sea::RoundedMap* map = rounded->rounded_map(field);
        ASSERT_NE(map, nullptr) << sea::info(field).name;
        EXPECT_EQ(map->steps.empty(), sea::info(field).time_rate) << sea::info(field).name;
        // A rate has the sum of two floats, rounded once: 2^-24 of 10 m/s.
        EXPECT_LE(tests::largest_difference(exact->plane(field), rounded->plane(field)),
                  static_cast<double>(map->error) + 1e-6)
            << sea::info(field).name;
    }
}

// Where half of the sea breaks no ratio is large, and 16 bits are enough.
TEST(RoundedFoam, tiles_of_every_bound_are_within_it) {
    const RunningSeaPtr sea = running_sea("[foam]\nthreshold = 1.0\ndecay_s = 3\n");
    const std::unique_ptr<VulkanSynthesizer> device = staged_device();
    ASSERT_TRUE(device->set_sea(sea->realization, 1));
    const FieldSet fields{Field::height, Field::foam};
    const auto made = [&](Readback readback) {
        const std::vector<float> bounds = rounding_bounds(sea->budget, fields, 0, readback);
        FoamMaps foam(std::make_shared<SeaCourse>(sea));
        return foam.synthesize(*device, {{0, 5 * second_us, fields, 1, nullptr, bounds}})
            .value()[0];
    };
    const NewKeyframePtr exact = made(Readback::exact), rounded = made(Readback::rounded);
    const std::span<const float> ratios = exact->plane(Field::foam);
    const sea::RoundedMap* foam = rounded->rounded_map(Field::foam);
    ASSERT_NE(foam, nullptr);
    EXPECT_LE(tests::largest_difference(rounded->plane(Field::foam), ratios),
              static_cast<double>(foam->error));
    for (std::size_t codec = 0; codec < codec_rungs.size(); ++codec) {
        Encoder encoder;
        const Quality quality = number_of({.codec = codec});
        const RungMaps maps = maps_of(sea->budget, 0, fields, quality);
        const auto encoded = encoder.encode(*rounded, maps.codec_error, quality, fields);
        ASSERT_TRUE(encoded) << encoded.error().message;
        ASSERT_EQ((*encoded)->maps.size(), 2u);
        for (const EncodedField& map : (*encoded)->maps)
            EXPECT_LE(tests::largest_difference(decoded(map, exact->size), exact->plane(map.field)),
                      static_cast<double>(map.error))
                << sea::info(map.field).name << " at " << codec_rungs[codec];
    }
    EXPECT_TRUE(device->validation_messages().empty());
}

TEST(RoundedKeyframe, counts_its_steps_and_hands_on_what_it_was_rounded_by) {
    sea::Keyframe one{1, 0, 0, 2, 10.0, {Field::height, Field::foam}};
    one.values.assign(8, 0.5f);
    EXPECT_EQ(one.bytes(), 8 * sizeof(float));
    one.rounded = {{Field::height, 0.25f, 0.13f, {2, 2, 2, 2}},
                   {Field::foam, 0.5f, 0.3f, {1, 1, 1, 1}}};
    EXPECT_EQ(one.bytes(), 8 * sizeof(float) + 8 * sizeof(std::int16_t));
    sea::Keyframe other{1, 0, 7, 2, 10.0, {Field::foam}};
    other.values.assign(4, 0.0f);
    sea::copy_map(one, Field::foam, other);
    EXPECT_EQ(other.plane(Field::foam)[3], 0.5f);
    ASSERT_NE(other.rounded_map(Field::foam), nullptr);
    EXPECT_EQ(other.rounded_map(Field::foam)->error, 0.3f);
    one.forget_steps({Field::height});
    EXPECT_EQ(one.rounded_map(Field::height)->error, 0.13f) << "its samples are off as before";
    EXPECT_TRUE(one.rounded_map(Field::height)->steps.empty());
    EXPECT_FALSE(one.rounded_map(Field::foam)->steps.empty());
    one.rounded.clear();
    sea::copy_map(one, Field::foam, other);
    EXPECT_EQ(other.rounded_map(Field::foam), nullptr) << "exact again";
}

// The second of two keyframes, of which the whole form and the difference come to the same.
TEST_P(RoundedScene, predicted_heights_are_within_the_bound) {
    Encoder encoder;
    const Quality quality = number_of({.compact = true, .predicted = true});
    constexpr FieldSet both{Field::height, Field::height_rate};
    for (const sea::TimeUs time_us : std::initializer_list<sea::TimeUs>{0, 400'000}) {
        const auto exact = made(time_us, Readback::exact),
                   rounded = made(time_us, Readback::rounded);
        const RungMaps maps = maps_of(sea_->budget, 0, fields(), number_of({}));
        const auto encoded =
            encoder.encode(*rounded[0], maps.codec_error, quality, both, {.law = predicted_law});
        ASSERT_TRUE(encoded) << encoded.error().message;
        for (const EncodedField& map : (*encoded)->maps) {
            const std::vector<float> back = decoded(map, exact[0]->size);
            EXPECT_LE(tests::largest_difference(back, exact[0]->plane(map.field)),
                      static_cast<double>(map.error))
                << sea::info(map.field).name << " at " << time_us;
        }
    }
}

} // namespace
} // namespace seaway::server
