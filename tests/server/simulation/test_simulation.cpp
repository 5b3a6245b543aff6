// SPDX-License-Identifier: Apache-2.0
// The simulation with a real synthesizer (native) and a clock that the test turns.
#include <algorithm>
#include <cmath>
#include <thread>

#include "tests/server/simulation/simulation_bench.h"
#include "tests/support/eventually.h"

namespace seaway::server {
namespace {

TEST(Simulation, a_sea_is_uploaded_once_to_each_device_and_what_all_have_done_adds_up) {
    Bench bench;
    EXPECT_EQ(bench.uploads, 1);
    EXPECT_EQ(bench.answer({{1.0, 2.0, 0}}).size(), 1u);
    EXPECT_EQ(bench.simulation->counters().synthesis.keyframes, 4u) << "two of each cascade";
    EXPECT_EQ(bench.answer({{1.0, 2.0, 20'000'000}}).size(), 1u);
    EXPECT_EQ(bench.simulation->counters().synthesis.keyframes, 8u);
    EXPECT_EQ(bench.simulation->counters().synthesis.cascades, 2u)
        << "the waves of each were given to the device once, for all of its keyframes";
    *bench.failures = 1;
    EXPECT_EQ(bench.answer({{1.0, 2.0, 10'000'000}}).size(), 1u);
    EXPECT_EQ(bench.uploads, 2);
    EXPECT_EQ(bench.simulation->counters().synthesis.keyframes, 12u);
    EXPECT_EQ(bench.simulation->counters().synthesis.cascades, 4u);
    EXPECT_EQ(bench.simulation->counters().device_rebuilds, 1u);
}

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
    bench.subscriptions.set(1, {2u, sea::surface_fields}); // cascade 1 alone
    for (int i = 0; i < 60; ++i)
        bench.advance(interval / 3);
    std::vector<TimeUs> times = bench.times(1);
    ASSERT_GT(times.size(), 15u);
    for (std::size_t i = 1; i < times.size(); ++i)
        EXPECT_EQ(times[i] - times[i - 1], interval);
    // Ahead of the time it is needed: two keyframes around now are always out.
    EXPECT_GE(times.back(), bench.now_us + interval);
    EXPECT_TRUE(bench.times(0).empty()) << "nobody asked for cascade 0";

    bench.subscriptions.set(1, {});
    const std::uint64_t before = bench.simulation->counters().synthesis.dispatches;
    for (int i = 0; i < 10; ++i)
        bench.advance(interval);
    EXPECT_EQ(bench.simulation->counters().synthesis.dispatches, before);
}

// Counters by effect and cascade, as in /metrics: those of what was asked for grow, by one transform a
// field, and no other does.
TEST(Simulation, what_nobody_asks_for_has_no_transforms_and_no_time) {
    Bench bench;
    bench.subscriptions.set(1, {2u, {Field::height, Field::height_rate}}); // of cascade 1 alone
    for (int i = 0; i < 40; ++i)
        bench.advance(100'000);
    const EffectCosts costs = bench.simulation->costs();
    for (std::size_t c = 0; c < bench.sea->budget.cascades.size(); ++c)
        for (std::size_t e = 0; e < effect_table().size(); ++e) {
            const EffectCost& cost = costs.cost(c, e);
            const bool asked = c == 1 && effect_table()[e].name == "height";
            EXPECT_EQ(cost.keyframes > 0, asked) << c << ' ' << effect_table()[e].name;
            EXPECT_DOUBLE_EQ(cost.transforms, asked ? 2.0 * static_cast<double>(cost.keyframes) : 0)
                << c << ' ' << effect_table()[e].name;
            EXPECT_EQ(cost.device_seconds > 0, asked) << c << ' ' << effect_table()[e].name;
        }
}

TEST(Simulation, a_late_wish_widens_the_keyframes_without_a_gap_for_others) {
    Bench bench;
    const TimeUs interval = bench.sea->budget.cascades[0].interval_us;
    const FieldSet height{Field::height, Field::height_rate};
    bench.subscriptions.set(1, {1u, height});
    for (int i = 0; i < 8; ++i)
        bench.advance(interval / 2);
    EXPECT_EQ(bench.published.back()->fields, height);
    EXPECT_EQ(bench.simulation->plan().cascades[0].transforms, 2);
    bench.subscriptions.set(2, {1u, {Field::slope_x, Field::slope_y}});
    for (int i = 0; i < 8; ++i)
        bench.advance(interval / 2);
    EXPECT_TRUE(bench.published.back()->fields.contains(Field::slope_x));
    EXPECT_EQ(bench.simulation->plan().cascades[0].transforms, 4);
    bench.subscriptions.set(2, {});
    for (int i = 0; i < 8; ++i)
        bench.advance(interval / 2);
    EXPECT_EQ(bench.published.back()->fields, height) << "the last one leaving takes its cost away";
    const std::vector<TimeUs> times = bench.times(0);
    for (std::size_t i = 1; i < times.size(); ++i)
        EXPECT_EQ(times[i] - times[i - 1], interval);
}

// Naive: the keyframe that is computed for new fields takes the place of the one that is held.
TEST(Simulation, fields_asked_for_one_after_the_other_are_held_together) {
    Bench bench;
    const FieldSet heights{Field::height, Field::height_rate};
    const FieldSet slopes{Field::slope_x, Field::slope_y};
    ASSERT_TRUE(bench.fetch({0}, {1u, heights}));
    ASSERT_TRUE(bench.fetch({0}, {1u, slopes}));
    const std::uint64_t transforms = bench.simulation->counters().synthesis.transforms;
    const auto both = bench.fetch({0}, {1u, heights | slopes});
    ASSERT_TRUE(both);
    for (const sea::KeyframePtr& keyframe : *both)
        EXPECT_TRUE(keyframe->fields.contains(heights | slopes));
    EXPECT_EQ(bench.simulation->counters().synthesis.transforms, transforms);
}

TEST(Simulation, what_a_new_subscriber_fetches_and_the_stream_join_without_a_gap) {
    Bench bench;
    bench.advance(1'234'567);
    for (const bool others_watch : {false, true}) {
        if (others_watch) {
            bench.subscriptions.set(7, {~0u, sea::surface_fields});
            bench.advance(100'000);
        }
        bench.published.clear();
        bench.subscriptions.set(1, {~0u, sea::surface_fields});
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
        bench.subscriptions.set(1, {});
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
        // The water moves all the same. Maps of heights alone know its vertical part and say so.
        EXPECT_NE(exact[i].velocity_mps[0], 0.0);
        EXPECT_EQ(fast[i].velocity_mps[0], 0.0);
        EXPECT_NEAR(fast[i].velocity_mps[2], exact[i].velocity_mps[2], 0.05);
        EXPECT_TRUE(fast[i].flags & sea::answer_vertical_velocity);
        EXPECT_FALSE(exact[i].flags & sea::answer_vertical_velocity);
    }
}

TEST(Simulation, foam_comes_with_the_stream_is_its_own_cost_and_the_same_after_a_restart) {
    const std::string stormy = "[foam]\nthreshold = 0.8\ndecay_s = 1.5\ngain_per_s = 3.0\n";
    Bench bench(stormy);
    ASSERT_GT(bench.sea->foam_law->mean_coverage, 1e-3) << "there must be foam to speak of";
    const Demand demand{1u, {Field::foam}};
    bench.subscriptions.set(1, demand);
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
    restarted.subscriptions.set(1, demand);
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
    const Result<std::vector<sea::Answer>> answers = bench.try_answer({{1.0, 2.0, 0}});
    ASSERT_FALSE(answers);
    EXPECT_TRUE(answers.error().is(Refusal::gone));
    EXPECT_NE(answers.error().message.find("DEVICE_LOST"), std::string::npos) << "the true reason";
    EXPECT_EQ(*bench.failures, 1000 - 1 - device_rebuilds_max) << "tried, rebuilt, and no more";
    EXPECT_NE(bench.failed.get_future().get().find("DEVICE_LOST"), std::string::npos);
    EXPECT_FALSE(bench.simulation->healthy());
    // Whoever asks afterwards is told the same, at once, instead of waiting for ever.
    EXPECT_TRUE(bench.try_answer({{1.0, 2.0, 0}}, true).error().is(Refusal::gone));
    EXPECT_TRUE(bench.fetch({0}, {~0u, sea::surface_fields}).error().is(Refusal::gone));
    EXPECT_TRUE(bench.surface(0).error().is(Refusal::gone));
}

// Naive: what is thrown leaves its thread, which ends the process.
TEST(Simulation, its_end_is_told_though_there_is_no_memory_to_say_so_at_first) {
    Bench bench;
    bench.speechless = 2;
    *bench.failures = 1000;
    EXPECT_FALSE(bench.try_answer({{1.0, 2.0, 0}}));
    EXPECT_NE(bench.failed.get_future().get().find("DEVICE_LOST"), std::string::npos);
}

TEST(Simulation, questions_that_wait_when_it_ends_are_refused_with_the_reason) {
    std::promise<void> gate;
    std::promise<void> entered;
    std::mutex mutex;
    std::vector<Error> refusals;
    const auto note = [&](const Result<std::vector<sea::Answer>>& answers) {
        const std::scoped_lock lock(mutex);
        if (!answers)
            refusals.push_back(answers.error());
    };
    {
        Bench bench;
        bench.simulation->fetch(
            {}, {},
            [&](const auto&) {
                entered.set_value();
                gate.get_future().wait();
            },
            someone);
        entered.get_future().wait();
        *bench.failures = 1000;
        for (int i = 1; i <= 3; ++i) // of times whose keyframes are not there
            bench.simulation->answer({{1.0, 2.0, i * 3'600'000'000}}, false, note, someone);
        bench.simulation->answer({{1.0, 2.0, 0}}, false, note, someone);
        gate.set_value();
        bench.failed.get_future().wait();
    }
    ASSERT_EQ(refusals.size(), 4u);
    for (const Error& refusal : refusals) {
        EXPECT_TRUE(refusal.is(Refusal::gone));
        EXPECT_NE(refusal.message.find("DEVICE_LOST"), std::string::npos) << refusal.message;
    }
}

TEST(Simulation, after_a_leap_of_the_clock_it_goes_on_with_the_keyframe_of_now) {
    Bench bench;
    const TimeUs interval = bench.sea->budget.cascades[0].interval_us;
    const FieldSet height{Field::height, Field::height_rate};
    bench.subscriptions.set(1, {1u, height});
    for (int i = 0; i < 6; ++i)
        bench.advance(interval / 2);
    const std::size_t before = bench.times(0).size();
    const TimeUs last = bench.times(0).back();
    const SimulationCounters counters = bench.simulation->counters();
    ASSERT_EQ(counters.keyframes_skipped, 0u);

    bench.advance(10'000'000); // the process was stopped, say
    const std::vector<TimeUs> times = bench.times(0);
    ASSERT_GT(times.size(), before);
    const TimeUs first = times[before];
    EXPECT_LE(first, bench.now_us) << "the two around now are out again";
    EXPECT_GT(first, bench.now_us - interval) << "and nothing older was made";
    for (std::size_t i = before + 1; i < times.size(); ++i)
        EXPECT_EQ(times[i] - times[i - 1], interval);
    EXPECT_GT(times.back(), bench.now_us + publish_lead_us);
    const SimulationCounters after = bench.simulation->counters();
    EXPECT_EQ(after.keyframes_skipped, static_cast<std::uint64_t>((first - last) / interval - 1))
        << "every one that was left out is counted";
    EXPECT_EQ(after.synthesis.keyframes - counters.synthesis.keyframes, times.size() - before)
        << "what is not published is not computed";
}

TEST(Simulation, more_questions_than_may_wait_are_refused_at_once_and_the_rest_answered) {
    Bench bench;
    std::promise<void> gate;
    std::promise<void> entered;
    bench.simulation->fetch(
        {}, {},
        [&](const auto&) {
            entered.set_value();
            gate.get_future().wait(); // holds the simulation thread
        },
        someone);
    entered.get_future().wait();
    std::atomic<int> answered = 0;
    std::atomic<int> refused = 0;
    // All are asked by those who have asked before: who asks for the first time finds room.
    std::vector<std::shared_ptr<const void>> crowd(questions_waiting_max / 2);
    for (auto& here : crowd)
        here = std::make_shared<char>();
    const int asked = static_cast<int>(questions_waiting_max) + 50;
    for (int i = 0; i < asked; ++i)
        bench.simulation->answer(
            {{1.0, 2.0, 0}}, false,
            [&](const Result<std::vector<sea::Answer>>& answers) {
                if (!answers) {
                    EXPECT_TRUE(answers.error().is(Refusal::busy));
                }
                ++(answers ? answered : refused);
            },
            Asker(crowd[static_cast<std::size_t>(i) % crowd.size()]));
    EXPECT_EQ(refused, 51) << "the one that is worked on has a place, too";
    gate.set_value();
    while (answered + refused < asked)
        std::this_thread::yield();
    EXPECT_EQ(answered, static_cast<int>(questions_waiting_max) - 1);
}

TEST(EffectCosts, time_beside_the_transforms_is_that_of_one_effect_of_one_cascade) {
    EffectCosts costs({64, 32, 16});
    const FoamTurn turn{};
    const KeyframeRequest foam{1, 0, {}, 1, &turn}, other{0, 0, {}};
    const KeyframeRequest both[] = {other, foam};
    costs.add({&foam, 1}, {.foam_seconds = 0.5});
    costs.add(both, {.foam_seconds = 0.25});
    for (std::size_t cascade = 0; cascade < 3; ++cascade)
        for (std::size_t effect = 0; effect < effect_table().size(); ++effect)
            EXPECT_EQ(costs.cost(cascade, effect).device_seconds,
                      cascade == 1 && effect_table()[effect].name == "foam" ? 0.75 : 0.0)
                << cascade << ' ' << effect_table()[effect].name;
}

TEST(EffectPlan, is_the_union_of_demand_within_what_the_scene_allows) {
    const RunningSeaPtr sea = running_sea();
    const FieldSet height{Field::height, Field::height_rate};
    Subscriptions subscriptions;
    subscriptions.set(1, {1u, height});
    subscriptions.set(2, {3u, {Field::slope_x, Field::foam}});
    const EffectPlan plan =
        plan_effects(height | FieldSet{Field::slope_x}, subscriptions, sea->budget);
    EXPECT_EQ(plan.cascades[0].fields, (height | FieldSet{Field::slope_x}));
    EXPECT_EQ(plan.cascades[1].fields, (FieldSet{Field::slope_x})) << "foam is not allowed here";
    EXPECT_EQ(plan.cascades[0].transforms, 3);
    EXPECT_TRUE(plan_effects(height, Subscriptions(), sea->budget).idle());
}

TEST(EffectPlan, each_real_field_is_one_transform_and_the_jacobian_takes_three) {
    EXPECT_EQ(transforms_for({}), 0);
    EXPECT_EQ(transforms_for({Field::height}), 1);
    EXPECT_EQ(transforms_for({Field::height, Field::height_rate}), 2);
    EXPECT_EQ(transforms_for(sea::surface_fields), 6);
    EXPECT_EQ(transforms_for({Field::jacobian}), 3) << "three strains";
    EXPECT_EQ(transforms_for({Field::jacobian, Field::strain_xx}), 3);
    EXPECT_EQ(transforms_for({Field::foam}), 3) << "it breaks where the Jacobian says";
    EXPECT_EQ(transforms_for({Field::foam, Field::jacobian, Field::strain_xy}), 3);
    EXPECT_EQ(transforms_for({Field::foam, Field::height, Field::slope_y}), 5);
    Subscriptions subscriptions;
    subscriptions.set(1, {2u, {Field::foam, Field::slope_x}});
    const FieldSet all = sea::surface_fields | FieldSet{Field::foam, Field::slope_x};
    const EffectPlan plan = plan_effects(all, subscriptions, running_sea()->budget);
    EXPECT_EQ(plan.cascades[0].transforms, 0);
    EXPECT_EQ(plan.cascades[1].transforms, 4);
    EXPECT_EQ(
        plan_effects({Field::slope_x}, subscriptions, running_sea()->budget).cascades[1].transforms,
        1)
        << "foam that the scene does not allow takes none";
}

// The publisher hangs as long as the test holds its lock: the slice does not end, and that shows from outside.
TEST(Simulation, a_slice_that_does_not_end_shows_and_sleep_does_not) {
    Bench bench;
    using std::chrono::milliseconds;
    EXPECT_TRUE(tests::eventually([&] { return bench.simulation->turn() == milliseconds(0); }));
    {
        const std::scoped_lock hold(bench.mutex);
        bench.subscriptions.set(1, {.cascades = 1, .fields = {Field::height}});
        EXPECT_TRUE(
            tests::eventually([&] { return bench.simulation->turn() > milliseconds(400); }));
        EXPECT_TRUE(bench.simulation->healthy()) << "nothing has failed, it only hangs";
    }
    bench.subscriptions.erase(1);
    EXPECT_TRUE(tests::eventually([&] { return bench.simulation->turn() == milliseconds(0); }));
}

} // namespace
} // namespace seaway::server
