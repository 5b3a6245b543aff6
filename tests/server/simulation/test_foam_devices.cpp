// SPDX-License-Identifier: Apache-2.0
// Foam where devices keep it: each is the history that this process would walk, at any time and in any steps.
#include "sea/native/native_runner.h"
#include "sea/scene/weather.h"
#include "server/device/vulkan_synthesizer.h"
#include "server/simulation/course_synthesis.h"
#include "server/simulation/foam_maps.h"
#include "tests/server/simulation/simulation_bench.h"
#include "tests/support/largest_difference.h"

namespace seaway::server {
namespace {

enum class On { native, vulkan, staged };

std::string name_of(const testing::TestParamInfo<On>& on) {
    return on.param == On::native ? "native" : on.param == On::vulkan ? "vulkan" : "vulkan_staged";
}

Result<std::unique_ptr<Synthesizer>> made_on(On on) {
    if (on == On::native)
        return std::unique_ptr<Synthesizer>(std::make_unique<NativeSynthesizer>(1));
    SEAWAY_TRY_LET(std::unique_ptr<VulkanSynthesizer> made,
                   make_vulkan_synthesizer({.validation = true, .staged = on == On::staged}));
    return std::unique_ptr<Synthesizer>(std::move(made));
}

class FoamOn : public testing::TestWithParam<On> {
  protected:
    /// Two tiles, a device that has them, and their foam.
    void set(const std::string& more) {
        sea_ = running_sea(more);
        course_ = std::make_shared<SeaCourse>(sea_);
        if (!device_)
            device_ = made_on(GetParam()).value();
        ASSERT_TRUE(device_->set_sea(sea_->realization, 1));
    }
    void TearDown() override {
        const auto* vulkan = dynamic_cast<const VulkanSynthesizer*>(device_.get());
        EXPECT_TRUE(vulkan == nullptr || vulkan->validation_messages().empty());
    }
    std::vector<float> map(FoamMaps& foam, int cascade, TimeUs time_us,
                           FieldSet fields = {Field::foam}) {
        const auto made = foam.synthesize(*device_, {{cascade, time_us, fields}});
        EXPECT_TRUE(made) << (made ? "" : made.error().message);
        const std::span<const float> plane = std::as_const(*made->front()).plane(Field::foam);
        return {plane.begin(), plane.end()};
    }
    /// The same by this process, from strains of its own.
    class Here {
      public:
        Here(const RunningSea& sea, int cascade)
            : sea_(sea), cascade_(cascade),
              transform_(
                  sea::NativeTransform::create(modes(), sea.realization->choppiness).value()),
              history_(sea.foam_law, cascade, modes().spec.size,
                       sea.budget.cascades[static_cast<std::size_t>(cascade)].interval_us) {}
        std::span<const float> map(TimeUs time_us) {
            EXPECT_TRUE(
                history_.advance_to(time_us, [this](TimeUs at_us) -> Result<sea::KeyframePtr> {
                    auto keyframe = std::make_shared<sea::Keyframe>();
                    keyframe->cascade = cascade_;
                    keyframe->size = modes().spec.size;
                    keyframe->fields = sea::foam_inputs;
                    keyframe->values.resize(3 * keyframe->plane_size());
                    const sea::NativeTask task{&transform_, sea_.realization->phase_time(at_us),
                                               sea::foam_inputs, keyframe->values};
                    runner_.run({&task, 1});
                    return sea::KeyframePtr(keyframe);
                }));
            return history_.ratios();
        }

      private:
        const sea::CascadeModes& modes() const {
            return sea_.realization->cascades[static_cast<std::size_t>(cascade_)];
        }
        const RunningSea& sea_;
        int cascade_;
        sea::NativeTransform transform_;
        sea::NativeRunner runner_{1};
        sea::FoamHistory history_;
    };

    RunningSeaPtr sea_;
    SeaCoursePtr course_;
    std::unique_ptr<Synthesizer> device_;
};
INSTANTIATE_TEST_SUITE_P(Devices, FoamOn, testing::Values(On::native, On::vulkan, On::staged),
                         name_of);

const std::string steady = "[foam]\nthreshold = 0.8\ndecay_s = 3\n";
const std::string calm_law = "[foam]\nthreshold = -0.9\ndecay_s = 3\n";
const std::string three_sharp_waves = "[[sea.system]]\ntype = \"sines\"\nshape = \"exponential\"\n"
                                      "length_m = 301.0\ncount = 3\namplitude_m = 0.2\n"
                                      "wavelength_m = 60.0\nfrom_deg = 230\n";

// Strains of two devices differ by some 1e-6 of theirs, which are around one; breaking goes as the gradients of its
// Gaussian tail, some hundred times as steep at the smallest of these means. A wrong term is wrong by tenths.
constexpr double same_ratio = 2e-3;

TEST_P(FoamOn, every_law_gives_the_history_that_this_process_walks_at_any_time) {
    for (const std::string& law :
         {steady, std::string("[foam]\nthreshold = 0.6\nbias = 0.3\ndecay_s = 1.5\n"),
          std::string("[foam]\nthreshold = 0.8\ndecay_s = 0\n"),  // where waves break now
          std::string("[foam]\nthreshold = 0.8\ndecay_s = 60\n"), // longer than can be walked
          calm_law, std::string("[sea]\nloop_period_s = 9.1\n") + steady}) {
        const bool loops = law.starts_with("[sea]");
        if (loops) {
            sea::Scene scene = running_sea(steady)->scene;
            scene.sea.loop_period_s = 9.1;
            sea_ = *make_running_sea(scene, 1);
            course_ = std::make_shared<SeaCourse>(sea_);
            ASSERT_TRUE(device_->set_sea(sea_->realization, 1));
        } else {
            set(law);
        }
        for (const int cascade : {0, 1}) {
            FoamMaps foam(course_);
            Here here(*sea_, cascade);
            for (const TimeUs time_us :
                 {TimeUs{40'000'000}, TimeUs{40'200'000}, TimeUs{40'333'333}, TimeUs{43'000'001},
                  TimeUs{-7'000'000}, TimeUs{86'400'000'000}})
                EXPECT_LT(tests::largest_difference(map(foam, cascade, time_us), here.map(time_us)),
                          same_ratio)
                    << law << cascade << " at " << time_us;
        }
    }
}

TEST_P(FoamOn, is_bounded_and_one_on_average) {
    set(steady);
    FoamMaps foam(course_);
    double sum = 0;
    constexpr int moments = 20;
    for (int i = 0; i < moments; ++i)
        for (const float ratio : map(foam, 1, 5'000'000 * i)) {
            ASSERT_TRUE(std::isfinite(ratio) && ratio >= 0);
            sum += double{ratio} / 4096;
        }
    // Moments 5 s apart of a tile of 43 m: a deviation of 0.06 over seeds.
    EXPECT_NEAR(sum / moments, 1.0, 0.2);
}

TEST_P(FoamOn, neither_ticks_nor_a_pause_nor_the_way_there_make_a_difference) {
    set(steady);
    FoamMaps often(course_), late(course_), sliced(course_);
    const TimeUs interval_us = sea_->budget.cascades[0].interval_us;
    const TimeUs end_us = 100 * interval_us;
    for (TimeUs t = 0; t <= end_us; t += interval_us)
        (void)map(often, 0, t);
    // What a history that began elsewhere may differ by: 1e-3 (docs/foam.md).
    const std::vector<float> at_once = map(late, 0, end_us);
    EXPECT_LT(tests::largest_difference(map(often, 0, end_us), at_once), 1e-3);
    int slices = 0;
    for (bool there = false; !there; ++slices)
        there = sliced.walk_towards(*device_, 0, end_us, 7).value();
    EXPECT_GT(slices, 3);
    EXPECT_EQ(map(sliced, 0, end_us), at_once) << "to the bit: the same steps";
    const TimeUs day_us = 86'400'000'000;
    FoamMaps fresh(course_);
    EXPECT_EQ(map(often, 0, end_us + day_us), map(fresh, 0, end_us + day_us)) << "after a pause";
}

TEST_P(FoamOn, a_copy_stands_still_while_the_other_goes_on) {
    set(steady);
    FoamMaps first(course_);
    const std::vector<float> before = map(first, 0, 20'000'000);
    FoamMaps copy = first;
    (void)map(first, 0, 25'000'000);
    EXPECT_EQ(copy.ticks_to(0, 20'000'000), 0);
    EXPECT_EQ(map(copy, 0, 20'000'000), before);
    FoamMaps other(course_);
    other.take_over(0, first);
    EXPECT_EQ(other.ticks_to(0, 25'000'000), 0);
    EXPECT_EQ(map(other, 0, 25'000'000), map(first, 0, 25'000'000));
    EXPECT_EQ(map(other, 0, 26'000'000), map(first, 0, 26'000'000)) << "both go on";
}

TEST_P(FoamOn, the_foam_of_a_keyframe_is_the_same_beside_other_fields_and_cascades) {
    set(steady);
    FoamMaps alone(course_), beside(course_);
    const TimeUs time_us = 30'000'000;
    const FieldSet all = sea::linear_fields | FieldSet{Field::jacobian, Field::foam};
    const auto both = beside.synthesize(
        *device_, {{1, time_us, {Field::height, Field::foam}}, {0, time_us, all}});
    ASSERT_TRUE(both) << both.error().message;
    for (const NewKeyframePtr& keyframe : *both) {
        const std::span<const float> plane = std::as_const(*keyframe).plane(Field::foam);
        EXPECT_EQ(map(alone, keyframe->cascade, time_us),
                  std::vector<float>(plane.begin(), plane.end()));
    }
    // The maps beside it are those that are made without it.
    const KeyframeRequest without{0, time_us, all.without({Field::foam})};
    const NewKeyframePtr plain = device_->synthesize({&without, 1}).value()[0];
    for (const Field field : plain->fields)
        EXPECT_TRUE(std::ranges::equal(plain->plane(field), (*both)[1]->plane(field)))
            << sea::info(field).name;
}

TEST_P(FoamOn, nothing_is_computed_that_nobody_asked_for) {
    set(steady);
    FoamMaps foam(course_);
    const auto growth = [&](const auto& work) {
        const SynthesisCounters before = device_->counters();
        work();
        return device_->counters() - before;
    };
    const SynthesisCounters height = growth([&] {
        (void)foam.synthesize(*device_, {{0, 50'000'000, {Field::height}}});
    });
    EXPECT_EQ(height.transforms, 1u);
    EXPECT_EQ(height.foam_ticks, 0u) << "no foam, no history";
    const int start = foam.ticks_to(0, 50'000'000);
    const SynthesisCounters first = growth([&] { (void)map(foam, 0, 50'000'000); });
    const TimeUs interval_us = sea_->budget.cascades[0].interval_us;
    const bool on_tick = 50'000'000 % interval_us == 0;
    EXPECT_EQ(first.foam_ticks, static_cast<std::uint64_t>(start) + !on_tick);
    EXPECT_EQ(first.transforms, 3 * first.foam_ticks) << "three strains a tick, and no other map";
    EXPECT_GT(start, 3) << "it is a walk";
    if (GetParam() == On::staged) {
        EXPECT_EQ(first.readback_bytes, 64 * 64 * sizeof(float))
            << "the map that is shown travels, and nothing of the way there";
    }
    EXPECT_EQ(growth([&] { (void)map(foam, 0, 50'000'000); }).foam_ticks, on_tick ? 0u : 1u);
    // A calm sea looks at no strains, and has no ticks.
    set(calm_law);
    FoamMaps calm(course_);
    const SynthesisCounters of_calm = growth([&] {
        for (const float ratio : map(calm, 0, 50'000'000))
            ASSERT_EQ(ratio, 1.0f);
    });
    EXPECT_EQ(of_calm.transforms, 0u);
    EXPECT_EQ(of_calm.foam_ticks, 0u);
}

// Naive: waves that have no strains are summed at every point of every tick, and no counter shows it.
TEST_P(FoamOn, a_tick_costs_in_a_sea_with_stylised_waves_what_it_costs_without) {
    const auto costs = [&](const std::string& more, FieldSet fields) {
        set(steady + more);
        FoamMaps foam(course_);
        const SynthesisCounters before = device_->counters();
        EXPECT_TRUE(foam.synthesize(*device_, {{0, 50'000'000, fields}}));
        return device_->counters() - before;
    };
    const SynthesisCounters with = costs(three_sharp_waves, {Field::foam}),
                            without = costs("", {Field::foam});
    EXPECT_EQ(with.stylised_sums, 0u);
    EXPECT_EQ(with.foam_ticks, without.foam_ticks);
    EXPECT_EQ(with.transforms, without.transforms);
    EXPECT_EQ(with.dispatches, without.dispatches);
    EXPECT_EQ(with.keyframes, 1u) << "one was asked for: ticks are none";
    // They move up and down alone, and each has a sum a point however many fields there are of it.
    const std::uint64_t sums = 3 * 64 * 64;
    const FieldSet sideways{Field::displacement_x, Field::displacement_y_rate, Field::jacobian};
    EXPECT_EQ(costs(three_sharp_waves, sideways).stylised_sums, 0u);
    EXPECT_EQ(costs(three_sharp_waves, {Field::slope_y}).stylised_sums, sums);
    EXPECT_EQ(costs(three_sharp_waves, sea::surface_fields | FieldSet{Field::foam}).stylised_sums,
              sums);
    EXPECT_EQ(costs("", sea::surface_fields).stylised_sums, 0u);
}

// Naive: strains that foam looked at stay in a keyframe, and are made again with whatever it is asked for later.
TEST_P(FoamOn, a_keyframe_has_the_fields_that_were_asked_for_and_no_other) {
    set(steady);
    FoamMaps foam(course_);
    for (const FieldSet& fields : {FieldSet{Field::foam}, FieldSet{Field::height, Field::foam},
                                   FieldSet{Field::strain_xy, Field::jacobian, Field::foam}}) {
        const auto made = foam.synthesize(*device_, {{0, 50'000'000, fields}});
        ASSERT_TRUE(made);
        EXPECT_EQ(made->front()->fields, fields);
        EXPECT_EQ(made->front()->values.size(),
                  made->front()->plane_size() * static_cast<std::size_t>(fields.size()));
    }
}

TEST_P(FoamOn, a_calm_sea_has_ticks_from_when_a_change_makes_it_break) {
    const TimeUs storm_us = 100 * second_us;
    set(calm_law);
    const TomlAssignment breaks{"foam.threshold", "0.8"};
    const sea::Scene storm = *sea::changed(sea_->scene, {&breaks, 1});
    const auto course = std::make_shared<SeaCourse>(sea_);
    FoamMaps before(course);
    (void)map(before, 0, storm_us - second_us);
    ASSERT_TRUE(course->add(storm, storm_us, storm_us + second_us));
    before.follow_changes();
    FoamMaps later(course);
    const SynthesisCounters at_first = device_->counters();
    (void)map(later, 0, storm_us - second_us);
    EXPECT_EQ((device_->counters() - at_first).foam_ticks, 0u) << "it is calm until then";
    const TimeUs tick_us =
        sea::foam_ticks(3, sea_->budget.cascades[0].interval_us, 0).after(storm_us) - storm_us;
    for (const TimeUs t_us : {storm_us + tick_us, storm_us + 10 * second_us}) {
        const std::vector<float> gone_on = map(before, 0, t_us);
        EXPECT_EQ(gone_on, map(later, 0, t_us));
        EXPECT_GT(*std::ranges::max_element(gone_on), 1.1f) << "it breaks";
    }
    // Back where it was calm a map that has foam is not what is shown.
    for (const float ratio : map(before, 0, storm_us - 50 * second_us))
        ASSERT_EQ(ratio, 1.0f);
}

// Naive: who is near without a history has hundreds of ticks before it once a change is added, between two looks.
TEST_P(FoamOn, a_change_that_is_added_between_walk_and_turn_leaves_what_was_near_so) {
    set(calm_law);
    const TomlAssignment breaks{"foam.threshold", "0.8"};
    const auto course = std::make_shared<SeaCourse>(sea_);
    FoamMaps maps(course);
    constexpr TimeUs now_us = 50 * second_us;
    ASSERT_TRUE(maps.walk_near(*device_, 0, now_us, 1).value());
    ASSERT_TRUE(course->add(*sea::changed(sea_->scene, {&breaks, 1}), 2 * now_us, 3 * now_us));
    ASSERT_TRUE(maps.is_near(0, now_us));
    ASSERT_TRUE(maps.turn(*device_, 0, now_us));
    maps.look_for_changes(0);
    EXPECT_GT(maps.ticks_to(0, now_us), 0) << "from the next walk on it counts";
}

// Strains stay where they are: they travel only to who asked for them.
TEST(FoamOnVulkan, keyframes_hold_what_was_asked_and_all_cascades_of_a_size_share_a_dispatch) {
    const RunningSeaPtr sea = running_sea(steady);
    const std::unique_ptr<VulkanSynthesizer> device = make_vulkan_synthesizer({}).value();
    ASSERT_TRUE(device->set_sea(sea->realization, 1));
    FoamMaps foam(std::make_shared<SeaCourse>(sea));
    const FieldSet asked{Field::height, Field::foam};
    const auto both_at = [&](TimeUs time_us) {
        return foam.synthesize(*device, {{0, time_us, asked}, {1, time_us, asked}}).value();
    };
    (void)both_at(0);
    const std::uint64_t before = device->counters().dispatches;
    const KeyframeRequest heights[] = {{0, 0, {Field::height}}, {1, 0, {Field::height}}};
    ASSERT_TRUE(device->synthesize(heights));
    const std::uint64_t of_height = device->counters().dispatches - before;
    const std::uint64_t before_both = device->counters().dispatches;
    // Whole seconds are ticks of both cascades, whose interval is not longer, or are not: then there is a step that is
    // shown alone, in the same dispatch.
    for (const NewKeyframePtr& keyframe : both_at(100'000))
        EXPECT_EQ(keyframe->fields, asked);
    EXPECT_EQ(device->counters().dispatches - before_both, of_height + 1)
        << "the passes of both, and one step of foam for both";
    // Of a tick what is kept is what is shown, in one step.
    const sea::FoamTicks ticks =
        sea::foam_ticks(sea->scene.foam.decay_s, sea->budget.cascades[0].interval_us, 0);
    const TimeUs tick_us = ticks.after(ticks.at_or_before(100'000));
    const std::uint64_t before_tick = device->counters().dispatches;
    ASSERT_TRUE(foam.synthesize(*device, {{0, tick_us, asked}}));
    EXPECT_EQ(device->counters().dispatches - before_tick, of_height + 1);
}

TEST_P(FoamOn, follows_a_sea_that_glides_to_another) {
    set(steady);
    auto course = std::make_shared<SeaCourse>(sea_);
    const TomlAssignment wind{"systems.0.wind_speed_10m_mps", "14.0"};
    ASSERT_TRUE(
        course->add(*sea::changed(sea_->scene, {&wind, 1}), 20 * second_us, 30 * second_us));
    const auto of = [&](On on) {
        Result<std::unique_ptr<RebuiltSynthesizer>> device = RebuiltSynthesizer::start(
            [&](const sea::RealizationPtr& waves, std::uint32_t epoch,
                server::Making) -> Result<std::unique_ptr<Synthesizer>> {
                SEAWAY_TRY_LET(std::unique_ptr<Synthesizer> one, made_on(on));
                SEAWAY_TRY(one->set_sea(waves, epoch));
                return one;
            },
            sea_->realization, 1, {});
        CourseSynthesis synthesis(course, std::move(device).value());
        FoamMaps foam(course);
        std::vector<std::vector<float>> maps;
        for (TimeUs t = 18 * second_us; t <= 34 * second_us; t += 4 * second_us) {
            const auto made =
                foam.synthesize(synthesis, {{0, t, {Field::foam}, course->window_at(t).epoch}});
            EXPECT_TRUE(made) << (made ? "" : made.error().message);
            const std::span<const float> plane = std::as_const(*made->front()).plane(Field::foam);
            maps.emplace_back(plane.begin(), plane.end());
        }
        return maps;
    };
    const auto here = of(On::native), there = of(GetParam());
    for (std::size_t i = 0; i < here.size(); ++i)
        EXPECT_LT(tests::largest_difference(there[i], here[i]), same_ratio) << i;
}

} // namespace
} // namespace seaway::server
