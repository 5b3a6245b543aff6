// SPDX-License-Identifier: Apache-2.0
// The simulation with a real synthesizer (native) and a clock that the test turns.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <future>
#include <mutex>
#include <thread>

#include <gtest/gtest.h>

#include "server/device/native_synthesizer.h"
#include "server/simulation/simulation.h"

namespace seaway::server {
namespace {

using sea::Field;
using sea::FieldSet;
using sea::TimeUs;

constexpr const char* small_sea = R"(
[sea]
seed = 7
[[sea.system]]
type = "wind"
spectrum = "jonswap"
wind_speed_10m_mps = 9.0
from_deg = 250
fetch_m = 40e3
spreading = "hasselmann"
[[cascade]]
length_m = 301.0
size = 64
[[cascade]]
length_m = 43.0
size = 64
[accuracy]
height_error_m = 0.02
)";

RunningSeaPtr running_sea(const std::string& more = {}) {
    const Result<sea::Scene> scene = sea::parse_scene(small_sea + more, "small_sea", ".");
    EXPECT_TRUE(scene) << (scene ? "" : scene.error().message);
    return *make_running_sea(*scene, 1);
}

/// Fails the next `failures` calls, as a lost device does.
class FailingSynthesizer final : public Synthesizer {
  public:
    explicit FailingSynthesizer(std::shared_ptr<std::atomic<int>> failures)
        : failures_(std::move(failures)) {}
    std::string description() const override { return inner_.description(); }
    Result<void> set_sea(sea::RealizationPtr sea, std::uint32_t epoch) override {
        return inner_.set_sea(std::move(sea), epoch);
    }
    Result<std::vector<sea::KeyframePtr>>
    synthesize(std::span<const KeyframeRequest> requests) override {
        if (failures_->fetch_sub(1) > 0)
            return Error{"VK_ERROR_DEVICE_LOST"};
        return inner_.synthesize(requests);
    }
    SynthesisCounters counters() const override { return inner_.counters(); }

  private:
    std::shared_ptr<std::atomic<int>> failures_;
    NativeSynthesizer inner_{1};
};

/// A simulation, what it published, and its clock.
struct Bench {
    RunningSeaPtr sea;
    std::atomic<TimeUs> now_us = 0;
    std::shared_ptr<std::atomic<int>> failures = std::make_shared<std::atomic<int>>(0);
    std::mutex mutex;
    std::vector<sea::KeyframePtr> published;
    std::atomic<int> warnings = 0;
    std::promise<std::string> failed;
    std::unique_ptr<Simulation> simulation;

    explicit Bench(const std::string& more = {}) : sea(running_sea(more)) {
        Result<std::unique_ptr<Simulation>> started = Simulation::start(
            sea,
            [this]() -> Result<std::unique_ptr<Synthesizer>> {
                return std::unique_ptr<Synthesizer>(std::make_unique<FailingSynthesizer>(failures));
            },
            [this] { return now_us.load(); },
            {[this](const sea::KeyframePtr& keyframe) {
                 const std::scoped_lock lock(mutex);
                 published.push_back(keyframe);
             },
             [this](const std::string&) { ++warnings; },
             [this](const std::string& why) { failed.set_value(why); }});
        simulation = std::move(started).value();
    }

    std::vector<sea::Answer> answer(std::vector<sea::QueryPoint> points, bool exact = false) {
        std::promise<std::vector<sea::Answer>> promise;
        auto answers = promise.get_future();
        simulation->answer(std::move(points), exact,
                           [&](std::vector<sea::Answer> a) { promise.set_value(std::move(a)); });
        return answers.get();
    }

    std::vector<sea::KeyframePtr> fetch_current(Demand demand) {
        std::promise<std::vector<sea::KeyframePtr>> promise;
        auto keyframes = promise.get_future();
        simulation->fetch_current(
            demand, [&](std::vector<sea::KeyframePtr> k) { promise.set_value(std::move(k)); });
        return keyframes.get();
    }

    /// Lets the thread look at the clock and waits until what is due has been published.
    void settle() { fetch_current({0, {}}); }

    void advance(TimeUs us) {
        now_us += us;
        simulation->set_demand(999, {}); // nobody's; wakes the thread
        settle();
    }

    std::vector<TimeUs> times(int cascade) {
        const std::scoped_lock lock(mutex);
        std::vector<TimeUs> all;
        for (const sea::KeyframePtr& keyframe : published)
            if (keyframe->cascade == cascade)
                all.push_back(keyframe->time_us);
        return all;
    }
};

TEST(Simulation, without_demand_nothing_is_dispatched) {
    Bench bench;
    for (int i = 0; i < 20; ++i)
        bench.advance(100'000);
    const SimulationCounters counters = bench.simulation->counters();
    EXPECT_EQ(counters.synthesis.dispatches, 0u);
    EXPECT_EQ(counters.synthesis.transforms, 0u);
    EXPECT_EQ(counters.keyframes_published, 0u);
}

TEST(Simulation, a_stream_has_every_keyframe_once_and_ends_with_its_last_subscriber) {
    Bench bench;
    const TimeUs interval = bench.sea->budget.cascades[1].interval_us;
    bench.simulation->set_demand(1, {2u, sea::surface_fields}); // cascade 1 alone
    for (int i = 0; i < 60; ++i)
        bench.advance(interval / 3);
    std::vector<TimeUs> times = bench.times(1);
    ASSERT_GT(times.size(), 15u);
    for (std::size_t i = 1; i < times.size(); ++i)
        EXPECT_EQ(times[i] - times[i - 1], interval);
    // Ahead of the time it is needed: two keyframes around now are always out.
    EXPECT_GE(times.back(), bench.now_us + interval);
    EXPECT_TRUE(bench.times(0).empty()) << "nobody asked for cascade 0";

    bench.simulation->set_demand(1, {});
    const std::uint64_t before = bench.simulation->counters().synthesis.dispatches;
    for (int i = 0; i < 10; ++i)
        bench.advance(interval);
    EXPECT_EQ(bench.simulation->counters().synthesis.dispatches, before);
}

TEST(Simulation, a_late_wish_widens_the_keyframes_without_a_gap_for_others) {
    Bench bench;
    const TimeUs interval = bench.sea->budget.cascades[0].interval_us;
    const FieldSet height{Field::height, Field::height_rate};
    bench.simulation->set_demand(1, {1u, height});
    for (int i = 0; i < 8; ++i)
        bench.advance(interval / 2);
    EXPECT_EQ(bench.published.back()->fields, height);
    EXPECT_EQ(bench.simulation->plan().cascades[0].transforms, 2);
    bench.simulation->set_demand(2, {1u, {Field::slope_x, Field::slope_y}});
    for (int i = 0; i < 8; ++i)
        bench.advance(interval / 2);
    EXPECT_TRUE(bench.published.back()->fields.contains(Field::slope_x));
    EXPECT_EQ(bench.simulation->plan().cascades[0].transforms, 4);
    bench.simulation->set_demand(2, {});
    for (int i = 0; i < 8; ++i)
        bench.advance(interval / 2);
    EXPECT_EQ(bench.published.back()->fields, height) << "the last one leaving takes its cost away";
    const std::vector<TimeUs> times = bench.times(0);
    for (std::size_t i = 1; i < times.size(); ++i)
        EXPECT_EQ(times[i] - times[i - 1], interval);
}

TEST(Simulation, what_a_new_subscriber_fetches_and_the_stream_join_without_a_gap) {
    Bench bench;
    bench.advance(1'234'567);
    for (const bool others_watch : {false, true}) {
        if (others_watch) {
            bench.simulation->set_demand(7, {~0u, sea::surface_fields});
            bench.advance(100'000);
        }
        bench.published.clear();
        bench.simulation->set_demand(1, {~0u, sea::surface_fields});
        std::vector<sea::KeyframePtr> held = bench.fetch_current({~0u, sea::surface_fields});
        for (int i = 0; i < 30; ++i)
            bench.advance(50'000);
        for (int c = 0; c < 2; ++c) {
            std::vector<TimeUs> times = bench.times(c);
            for (const sea::KeyframePtr& keyframe : held)
                if (keyframe->cascade == c)
                    times.push_back(keyframe->time_us);
            std::sort(times.begin(), times.end());
            times.erase(std::unique(times.begin(), times.end()), times.end());
            const TimeUs interval =
                bench.sea->budget.cascades[static_cast<std::size_t>(c)].interval_us;
            for (std::size_t i = 1; i < times.size(); ++i)
                EXPECT_EQ(times[i] - times[i - 1], interval) << "cascade " << c;
        }
        bench.simulation->set_demand(1, {});
    }
}

TEST(Simulation, answers_agree_with_the_exact_sum_within_their_bound_at_any_time) {
    Bench bench;
    std::vector<sea::QueryPoint> points;
    for (int i = 0; i < 60; ++i)
        points.push_back({i * 997.0 - 3e4, i * -313.0, (i % 6 - 2) * 86'400'123'457});
    const std::vector<sea::Answer> fast = bench.answer(points);
    const std::vector<sea::Answer> exact = bench.answer(points, true);
    for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_LE(std::abs(fast[i].height_m - exact[i].height_m),
                  fast[i].error_m + exact[i].error_m);
        EXPECT_LE(fast[i].error_m, 0.04);
    }
    EXPECT_TRUE(bench.answer({}).empty());
}

TEST(Simulation, height_alone_costs_two_transforms_a_keyframe_and_its_sea_does_not_chop) {
    Bench bench("[effects]\ndisplacement = \"height\"\nslopes = false\nfoam = false\n");
    EXPECT_EQ(bench.sea->offered, (FieldSet{Field::height, Field::height_rate}));
    const std::vector<sea::QueryPoint> points{{10, 20, 500'000}, {-3000, 77, 500'000}};
    const std::vector<sea::Answer> fast = bench.answer(points);
    EXPECT_EQ(bench.simulation->counters().synthesis.transforms, 8u)
        << "height and its rate, 2 cascades, 2 times";
    const std::vector<sea::Answer> exact = bench.answer(points, true);
    for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_LE(std::abs(fast[i].height_m - exact[i].height_m), fast[i].error_m);
        EXPECT_EQ(exact[i].velocity_mps[0], 0.0);
    }
}

TEST(Simulation, foam_comes_with_the_stream_is_its_own_cost_and_the_same_after_a_restart) {
    const std::string stormy = "[foam]\nthreshold = 0.8\ndecay_s = 1.5\ngain_per_s = 3.0\n";
    Bench bench(stormy);
    ASSERT_GT(bench.sea->foam_law->mean_coverage, 1e-3) << "there must be foam to speak of";
    const Demand demand{1u, {Field::foam}};
    bench.simulation->set_demand(1, demand);
    const TimeUs interval = bench.sea->budget.cascades[0].interval_us;
    for (int i = 0; i < 12; ++i)
        bench.advance(interval);
    const sea::KeyframePtr last = bench.published.back();
    ASSERT_TRUE(last->fields.contains(Field::foam));
    double sum = 0;
    for (const float ratio : last->plane(Field::foam)) {
        ASSERT_TRUE(ratio >= 0.0f && std::isfinite(ratio));
        sum += static_cast<double>(ratio);
    }
    // A ratio to the mean; one tile of 301 m holds few breakers, whose scatter is some ten percent.
    EXPECT_NEAR(sum / static_cast<double>(last->plane_size()), 1.0, 0.5);

    // A server that starts now agrees with one that has run: the history is contractive, ten decay
    // times leave 5e-5 of what was before, and both tick at the same times.
    Bench restarted(stormy);
    restarted.now_us = bench.now_us.load();
    restarted.simulation->set_demand(1, demand);
    for (int i = 0; i < 2; ++i)
        restarted.advance(interval);
    for (int i = 0; i < 2; ++i)
        bench.advance(interval);
    const sea::KeyframePtr late = bench.published.back();
    const auto same = std::find_if(
        restarted.published.begin(), restarted.published.end(),
        [&](const sea::KeyframePtr& keyframe) { return keyframe->time_us == late->time_us; });
    ASSERT_NE(same, restarted.published.end());
    for (std::size_t i = 0; i < late->plane_size(); ++i)
        ASSERT_NEAR((*same)->plane(Field::foam)[i], late->plane(Field::foam)[i], 1e-3f);
    EXPECT_GT(bench.simulation->costs().cost(0, 4).keyframes, 0u);
    EXPECT_EQ(bench.simulation->costs().cost(1, 4).keyframes, 0u) << "nobody asked there";
}

TEST(Simulation, a_lost_device_is_rebuilt_and_nobody_notices) {
    Bench bench;
    *bench.failures = device_rebuilds_max;
    const std::vector<sea::Answer> answers = bench.answer({{1.0, 2.0, 0}});
    ASSERT_EQ(answers.size(), 1u);
    const std::vector<sea::Answer> exact = bench.answer({{1.0, 2.0, 0}}, true);
    EXPECT_NEAR(answers[0].height_m, exact[0].height_m, answers[0].error_m);
    EXPECT_EQ(bench.warnings, device_rebuilds_max);
    EXPECT_EQ(bench.simulation->counters().device_rebuilds,
              static_cast<std::uint64_t>(device_rebuilds_max));
    EXPECT_TRUE(bench.simulation->healthy());
}

TEST(Simulation, a_device_that_stays_lost_ends_it_with_its_reason) {
    Bench bench;
    *bench.failures = 1000;
    EXPECT_TRUE(bench.answer({{1.0, 2.0, 0}}).empty());
    EXPECT_NE(bench.failed.get_future().get().find("DEVICE_LOST"), std::string::npos);
    EXPECT_FALSE(bench.simulation->healthy());
}

TEST(Simulation, more_questions_than_may_wait_are_refused_at_once_and_the_rest_answered) {
    Bench bench;
    std::promise<void> gate;
    std::promise<void> entered;
    bench.simulation->fetch({}, {}, [&](std::vector<sea::KeyframePtr>) {
        entered.set_value();
        gate.get_future().wait(); // holds the simulation thread
    });
    entered.get_future().wait();
    std::atomic<int> answered = 0;
    std::atomic<int> refused = 0;
    const int asked = static_cast<int>(questions_waiting_max) + 50;
    for (int i = 0; i < asked; ++i)
        bench.simulation->answer({{1.0, 2.0, 0}}, false, [&](std::vector<sea::Answer> answers) {
            ++(answers.empty() ? refused : answered);
        });
    EXPECT_EQ(refused, 50);
    gate.set_value();
    while (answered + refused < asked)
        std::this_thread::yield();
    EXPECT_EQ(answered, static_cast<int>(questions_waiting_max));
}

TEST(KeyframeStore, memory_stays_below_its_limit_and_newest_use_stays) {
    const auto keyframe = [](TimeUs time_us) {
        auto made = std::make_shared<sea::Keyframe>();
        made->size = 64;
        made->length_m = 10;
        made->time_us = time_us;
        made->fields = {Field::height, Field::height_rate};
        made->values.assign(2 * made->plane_size(), 0.0f);
        return made;
    };
    const std::size_t one = 2 * 64 * 64 * sizeof(float);
    KeyframeStore store(4 * one);
    for (TimeUs t = 0; t < 100; ++t) {
        store.insert(keyframe(t));
        EXPECT_TRUE(store.find(0, 0, {Field::height})) << "used all the time, never dropped";
        EXPECT_LE(store.counters().bytes, 4 * one);
    }
    EXPECT_FALSE(store.find(0, 50, {Field::height}));
    EXPECT_FALSE(store.find(0, 0, {Field::slope_x})) << "held, but without this field";
}

TEST(EffectPlan, is_the_union_of_demand_within_what_the_scene_allows) {
    const RunningSeaPtr sea = running_sea();
    const FieldSet height{Field::height, Field::height_rate};
    const Demand demands[] = {{1u, height}, {3u, {Field::slope_x, Field::foam}}};
    const EffectPlan plan = plan_effects(height | FieldSet{Field::slope_x}, demands, sea->budget);
    EXPECT_EQ(plan.cascades[0].fields, (height | FieldSet{Field::slope_x}));
    EXPECT_EQ(plan.cascades[1].fields, (FieldSet{Field::slope_x})) << "foam is not allowed here";
    EXPECT_EQ(plan.cascades[0].transforms, 3);
    EXPECT_TRUE(plan_effects(height, {}, sea->budget).idle());
}

TEST(EffectPlan, each_real_field_is_one_transform_and_the_jacobian_takes_three) {
    EXPECT_EQ(transforms_for({}), 0);
    EXPECT_EQ(transforms_for({Field::height}), 1);
    EXPECT_EQ(transforms_for({Field::height, Field::height_rate}), 2);
    EXPECT_EQ(transforms_for(sea::surface_fields), 6);
    EXPECT_EQ(transforms_for({Field::jacobian}), 3) << "three strains";
    EXPECT_EQ(transforms_for({Field::jacobian, Field::strain_xx}), 3);
}

} // namespace
} // namespace seaway::server
