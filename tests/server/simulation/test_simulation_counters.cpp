// SPDX-License-Identifier: Apache-2.0
// What the simulation counts, after a known run of questions: each counter is what happened.
#include <fmt/format.h>

#include "sea/basics/constants.h"
#include "sea/scene/scene_warnings.h"
#include "sea/surface/below.h"
#include "tests/server/simulation/simulation_bench.h"
#include "tests/support/eventually.h"

namespace seaway::server {
namespace {

// Two cascades of 64 points a side: around a time that is four keyframes, of six fields for a sampler.
constexpr std::uint64_t around = 4, fields = 6, passes = 2, samples = 64 * 64;

TEST(SimulationCounters, are_what_a_known_run_of_questions_has_made) {
    Bench bench;
    const auto expect = [&](std::uint64_t made, std::uint64_t held, std::uint64_t hits,
                            std::uint64_t questions, const char* when) {
        const SimulationCounters c = bench.simulation->counters();
        EXPECT_EQ(c.synthesis.keyframes, made * around) << when;
        EXPECT_EQ(c.synthesis.transforms, made * around * fields) << when;
        EXPECT_EQ(c.synthesis.dispatches, made * around * passes) << when;
        EXPECT_EQ(c.synthesis.device_seconds > 0, made > 0) << when;
        EXPECT_EQ(c.store.keyframes, held * around) << when;
        EXPECT_EQ(c.store.misses, made * around) << when;
        EXPECT_EQ(c.store.hits, hits * around) << when;
        EXPECT_EQ(c.questions, questions) << when;
        EXPECT_EQ(c.keyframes_published, 0u) << when;
        EXPECT_EQ(c.keyframes_skipped, 0u) << when;
        EXPECT_EQ(c.stream_slices, 0u) << when;
        EXPECT_EQ(c.device_rebuilds, 0u) << when;
    };
    expect(0, 0, 0, 0, "before");
    bench.answer({{1, 2, 1'000'001}});
    expect(1, 1, 0, 1, "the first of its time");
    bench.answer({{7, -2, 1'000'002}, {9, 3, 1'000'002}});
    expect(1, 1, 1, 2, "another place at that time");
    const std::size_t raw = around * fields * samples * sizeof(float);
    EXPECT_EQ(bench.simulation->counters().store.bytes, around * sea::SplineMap::bytes_of(64))
        << "from which points are answered";
    EXPECT_EQ(bench.simulation->counters().fetch_bytes_most, 0u) << "no fetch";
    {
        const auto fetched = bench.fetch({1'000'001}, {~0u, sea::surface_fields});
        ASSERT_TRUE(fetched);
        expect(2, 1, 1, 3, "a fetch of the same has maps made, which nobody held");
        EXPECT_EQ(bench.simulation->counters().fetch_bytes, raw);
    }
    // Nobody holds it any more, as soon as the thread that handed it over has let it go.
    while (bench.simulation->counters().fetch_bytes > 0)
        std::this_thread::yield();
    EXPECT_EQ(bench.simulation->counters().fetch_bytes_most, raw);
    ASSERT_TRUE(bench.fetch({1'000'002}, {~0u, sea::surface_fields}));
    expect(2, 1, 2, 4, "and another has the same");
    bench.answer({{3, 2, 1'000'003}});
    expect(2, 1, 3, 5, "splines stay where maps come back");
    bench.answer({{1, 2, 50'000'001}});
    expect(3, 2, 3, 6, "another time");
    bench.answer({{1, 2, 70'000'001}}, true);
    expect(3, 2, 3, 7, "an exact question takes no keyframes");
}

/// One answer each, and its water.
PointsAnswered looked(Bench& bench, PointsAsked asked) {
    std::promise<PointsAnswered> answered;
    bench.simulation->answer(
        std::move(asked),
        [&](Result<PointsAnswered> found) { answered.set_value(std::move(found).value()); },
        someone);
    return answered.get_future().get();
}

// Naive: by the band of the spectra, which waves given by hand do not keep to.
TEST(SimulationCounters, a_wave_given_by_hand_is_felt_by_who_feels_its_length) {
    const double length_m = Bench().sea->realization->cascades[1].spec.length_m;
    const RunningSeaPtr sea =
        running_sea(fmt::format("[[sea.system]]\ntype = \"modes\"\nlength_m = {}\ndata = "
                                "'''\nnx,ny,amplitude_m,phase_rad\n1,0,2,0\n'''\n",
                                length_m));
    const sea::CascadeModes& tile = sea->realization->cascades[1];
    ASSERT_LT(tile.longest_radpm(), 0.9 * tile.band.k_lo_radpm);
    EXPECT_NEAR(tile.longest_radpm(), sea::two_pi / length_m, 1e-12);
    EXPECT_TRUE(felt_cascades(*sea->realization, {.min_wavelength_m = 0.99 * length_m}) & 2u);
    EXPECT_FALSE(felt_cascades(*sea->realization, {.min_wavelength_m = 1.01 * length_m}) & 2u);
}

// Naive: by the sea that the course began with.
TEST(SimulationCounters, waves_that_a_change_gives_by_hand_are_felt_by_who_feels_their_length) {
    Bench bench;
    const double length_m = bench.sea->realization->cascades[1].spec.length_m;
    const sea::Looking looking{.min_wavelength_m = 0.99 * length_m};
    const sea::TimeUs start_us = 10 * second_us;
    const std::vector<sea::QueryPoint> before{{0, 0, start_us - 1}},
        from{{0, 0, 0}, {0, 0, start_us}};
    EXPECT_FALSE(felt_cascades(*bench.course, from, looking) & 2u);
    sea::SineRamps sines;
    sines.length_m = length_m;
    sines.count = 1;
    sines.wavelength_m = length_m;
    const sea::ExplicitModes modes{.length_m = length_m, .modes = {{1, 0, 2.0, 0.0}}};
    sea::SineRamps sharp = sines;
    sharp.kind = sea::SineKind::exponential;
    for (const sea::WaveSystem& system :
         {sea::WaveSystem(modes), sea::WaveSystem(sines), sea::WaveSystem(sharp)}) {
        const Bench other;
        sea::Scene given = other.sea->scene;
        given.sea.systems.push_back(system);
        ASSERT_TRUE(other.course->add(given, start_us, 20 * second_us));
        EXPECT_TRUE(felt_cascades(*other.course, from, looking) & 2u) << system.index();
        EXPECT_FALSE(felt_cascades(*other.course, before, looking) & 2u)
            << "a change of tomorrow, and today more is felt: " << system.index();
        EXPECT_EQ(felt_cascades(*other.course, from, {.cascades = 1, .min_wavelength_m = 1.0}), 1u)
            << "of which others were told to be left out stay so";
    }
}

TEST(SimulationCounters,
     waves_that_nobody_feels_are_not_made_and_two_filters_share_what_they_feel) {
    Bench bench;
    const sea::Band& fine = bench.sea->realization->cascades[1].band;
    PointsAsked asked({{1, 2, 1'000'001}, {50, -20, 1'000'001}});
    asked.looking.min_wavelength_m = 1.001 * sea::two_pi / fine.k_lo_radpm;
    const auto made = [&] { return bench.simulation->counters().synthesis.keyframes; };
    const PointsAnswered longer = looked(bench, asked);
    EXPECT_EQ(made(), 2u) << "before and after, of the cascade of long waves";
    PointsAsked exactly = asked;
    exactly.exact = true;
    const PointsAnswered exact = looked(bench, exactly);
    const std::vector<sea::Answer> whole = bench.answer(asked.points);
    EXPECT_EQ(made(), 4u) << "what two filters feel is made once";
    for (std::size_t i = 0; i < asked.points.size(); ++i) {
        EXPECT_LE(std::abs(longer.answers[i].height_m - exact.answers[i].height_m),
                  longer.answers[i].error_m + exact.answers[i].error_m);
        EXPECT_LT(longer.answers[i].error_m, whole[i].error_m) << "what is not there is not lost";
        EXPECT_GT(std::abs(longer.answers[i].height_m - whole[i].height_m), 1e-3);
    }
    const Result<SurfacePtr> in_use = bench.surface(1'000'001);
    ASSERT_TRUE(in_use);
    EXPECT_EQ(looked(bench, asked).answers[0].height_m, longer.answers[0].height_m)
        << "whoever holds a surface of all waves";
    asked.looking = {.cascades = 2};
    looked(bench, asked);
    EXPECT_EQ(made(), 4u) << "held";
    EXPECT_EQ(felt_cascades(*bench.sea->realization, {.min_wavelength_m = 1e-3}), sea::all_cascades)
        << "who feels all waves shares with those who asked for no less";
    asked.looking = {.cascades = 4};
    const PointsAnswered nothing = looked(bench, asked);
    EXPECT_EQ(nothing.answers[0].height_m, 0) << "there is no third cascade";
    EXPECT_EQ(nothing.answers[0].error_m, 0);
    EXPECT_EQ(made(), 4u);
}

TEST(SimulationCounters, the_water_below_is_the_direct_sums_and_takes_no_keyframes) {
    Bench bench;
    PointsAsked asked({{1, 2, 70'000'001}, {3, 4, 10'000'001}, {5, 6, 70'000'001}});
    asked.z_m = {-1.5, -20, 50};
    const PointsAnswered found = looked(bench, asked);
    ASSERT_EQ(found.below.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) {
        const sea::QueryPoint& point = asked.points[i];
        sea::WaterBelow water;
        const sea::Answer answer = sea::water_at(
            point, asked.z_m[i],
            {bench.sea->realization->choppiness, 1e-9, fold_search(bench.sea->budget)},
            bench.sea->truth->at_time(point.time_us), water);
        EXPECT_EQ(found.answers[i].height_m, answer.height_m);
        EXPECT_EQ(found.answers[i].flags, answer.flags | sea::answer_exact);
        EXPECT_EQ(found.below[i].pressure_m2ps2, water.pressure_m2ps2) << "in order of points";
        EXPECT_EQ(found.below[i].velocity_mps[0], water.velocity_mps[0]);
    }
    EXPECT_NE(found.below[0].pressure_m2ps2, 0);
    EXPECT_TRUE(found.answers[2].flags & sea::answer_dry);
    EXPECT_EQ(bench.simulation->counters().synthesis.keyframes, 0u);
}

TEST(SimulationCounters, count_each_keyframe_of_every_cascade_that_was_published) {
    Bench bench;
    bench.subscriptions.set(1, {3u, {Field::height, Field::height_rate}});
    bench.settle();
    for (int i = 0; i < 3; ++i)
        bench.advance(bench.sea->budget.cascades[0].interval_us);
    const std::scoped_lock lock(bench.mutex);
    EXPECT_GT(bench.published.size(), 6u);
    EXPECT_EQ(bench.simulation->counters().keyframes_published, bench.published.size());
}

// Shares of what was measured add up to it, whatever was asked for together; each effect has those of its
// own fields: what is counted by transforms, time by what they weigh. The Jacobian has three strains.
TEST(SimulationCounters, shares_of_effects_follow_the_transforms_and_add_up_to_the_whole) {
    EffectCosts costs({64, 32, 16});
    const double weights[] = {64.0 * 64 * 6, 32.0 * 32 * 5, 16.0 * 16 * 4};
    struct Row {
        KeyframeRequest request;
        double height, choppy, slopes, gradient; ///< transforms
    };
    const Row rows[] = {
        {{0, 1, {Field::height, Field::height_rate, Field::slope_x}}, 2, 0, 1, 0},
        {{2, 1, {Field::displacement_x, Field::slope_y, Field::jacobian}}, 0, 1, 1, 3},
        {{1, 1, {Field::height, Field::displacement_y, Field::displacement_y_rate}}, 1, 2, 0, 0},
        {{2, 2, {Field::strain_xx, Field::strain_xy, Field::slope_y}}, 0, 0, 1, 2}};
    std::vector<KeyframeRequest> requests;
    double whole = 0, transforms = 0;
    for (const Row& row : rows) {
        requests.push_back(row.request);
        const double own = row.height + row.choppy + row.slopes + row.gradient;
        transforms += own;
        whole += own * weights[row.request.cascade];
    }
    ASSERT_EQ(transforms, 14);
    EXPECT_EQ(costs.predicted_seconds(1, 0, {Field::height}), 0) << "nothing was measured yet";
    costs.add(requests, {.dispatches = 8, .transforms = 14, .keyframes = 4, .device_seconds = 3});
    costs.add({}, {.dispatches = 99, .transforms = 99, .keyframes = 99, .device_seconds = 99});
    for (std::size_t c = 0; c < 3; ++c) {
        double own[4] = {}, keyframes[4] = {};
        for (const Row& row : rows)
            if (row.request.cascade == static_cast<int>(c)) {
                const double of[] = {row.height, row.choppy, row.slopes, row.gradient};
                for (std::size_t e = 0; e < 4; ++e) {
                    own[e] += of[e];
                    keyframes[e] += of[e] > 0;
                }
            }
        for (std::size_t e = 0; e < 4; ++e) {
            const EffectCost& cost = costs.cost(c, e);
            EXPECT_NEAR(cost.dispatches, 8 * own[e] / 14, 1e-12) << c << ' ' << e;
            EXPECT_NEAR(cost.transforms, own[e], 1e-12) << "of small tiles, too" << c << ' ' << e;
            EXPECT_NEAR(cost.device_seconds, 3 * own[e] * weights[c] / whole, 1e-12)
                << c << ' ' << e;
            EXPECT_EQ(static_cast<double>(cost.keyframes), keyframes[e]) << c << ' ' << e;
        }
        const FieldSet both{Field::jacobian, Field::slope_x};
        EXPECT_NEAR(costs.predicted_seconds(c, 2, both), weights[c] * 3 / whole, 1e-12);
        EXPECT_NEAR(costs.predicted_seconds(c, 3, both), 3 * weights[c] * 3 / whole, 1e-12);
    }
}

// Naive: strains are charged for the gradient, for its Jacobian and for foam, and others have a smaller share the more
// there is of that.
TEST(SimulationCounters, strains_are_transformed_once_and_shared_by_those_who_stand_on_them) {
    const FieldSet height{Field::height, Field::height_rate};
    const FieldSet gradient = sea::strain_fields | FieldSet{Field::jacobian};
    sea::FoamTick tick{};
    tick.source = 1; // it looks at strains
    const FoamTurn turn{nullptr, tick, {}};
    const auto transforms = [&](FieldSet fields, const FoamTurn* foam) {
        EffectCosts costs({64});
        const KeyframeRequest request{0, 0, fields, 1, foam};
        const auto all = static_cast<std::uint64_t>(
            transforms_for(foam && foam->looks(fields) ? fields | FieldSet{Field::foam} : fields));
        costs.add({&request, 1}, {.transforms = all});
        std::vector<double> each;
        for (std::size_t e = 0; e < effect_table().size(); ++e)
            each.push_back(costs.cost(0, e).transforms);
        return each;
    };
    using Each = std::vector<double>; // height, choppy, slopes, gradient, foam
    const FieldSet foam{Field::foam};
    EXPECT_EQ(transforms(height | gradient, nullptr), (Each{2, 0, 0, 3, 0}));
    EXPECT_EQ(transforms(height | foam, &turn), (Each{2, 0, 0, 0, 3}));
    EXPECT_EQ(transforms(height | gradient | foam, &turn), (Each{2, 0, 0, 1.5, 1.5}));
    EXPECT_EQ(transforms(height | FieldSet{Field::strain_xx} | foam, &turn),
              (Each{2, 0, 0, 0.5, 2.5}));
    EXPECT_EQ(transforms({}, &turn), (Each{0, 0, 0, 0, 3})) << "a tick alone";
    const FoamTurn calm{};
    EXPECT_EQ(transforms(height, &calm), (Each{2, 0, 0, 0, 0}));
}

TEST(SimulationCounters, a_keyframe_of_foam_is_predicted_with_its_step_and_a_tick_is_none) {
    EffectCosts costs({64, 32});
    sea::FoamTick tick{};
    tick.source = 1;
    const FoamTurn looks{nullptr, tick, {}}, calm{};
    const FieldSet fields{Field::height, Field::foam};
    const KeyframeRequest keyframe{0, 1, fields, 1, &looks}, ticked{0, 0, {}, 1, &looks};
    // Twice a step of 64 x 64 and seven transforms of them.
    const KeyframeRequest both[] = {ticked, keyframe};
    costs.add(both, {.transforms = 7, .device_seconds = 7, .foam_seconds = 2});
    constexpr std::size_t height_effect = 0, foam_effect = 4;
    EXPECT_EQ(costs.cost(0, foam_effect).keyframes, 1u);
    EXPECT_DOUBLE_EQ(costs.cost(0, foam_effect).device_seconds, 6 + 2);
    EXPECT_DOUBLE_EQ(costs.predicted_seconds(0, height_effect, fields), 1);
    EXPECT_DOUBLE_EQ(costs.predicted_seconds(0, foam_effect, fields), 3 + 1);
    // A quarter of the points, and five sixths of that for transforms.
    EXPECT_DOUBLE_EQ(costs.predicted_seconds(1, foam_effect, fields), 3 * 0.25 * 5 / 6 + 0.25);
    // Where it has been calm so far it looks at nothing.
    const KeyframeRequest of_calm{1, 1, fields, 1, &calm};
    costs.add({&of_calm, 1}, {});
    EXPECT_EQ(costs.cost(1, foam_effect).keyframes, 1u);
    EXPECT_EQ(costs.cost(1, foam_effect).transforms, 0);
    EXPECT_DOUBLE_EQ(costs.predicted_seconds(1, foam_effect, fields),
                     2.0 / (2 * 64 * 64 + 32 * 32) * 32 * 32);
}

// Naive: a question about now makes again what the stream has just made.
TEST(SimulationCounters, a_question_about_now_makes_what_the_stream_has_not) {
    Bench bench("[foam]\nthreshold = 0.8\ndecay_s = 1\n");
    const FieldSet streamed{Field::height, Field::height_rate, Field::slope_x, Field::slope_y,
                            Field::foam};
    bench.subscriptions.set(1, {3u, streamed});
    const auto counted = [&] { return bench.simulation->counters().synthesis; };
    while (bench.times(0).empty() || !bench.published.back()->fields.contains(Field::foam))
        bench.advance(bench.sea->budget.cascades[1].interval_us);
    bench.settle();
    for (const sea::KeyframePtr& keyframe : bench.published)
        EXPECT_TRUE(streamed.contains(keyframe->fields)) << "no strains that foam looked at";
    (void)bench.fetch({bench.now_us}, {3u, streamed}); // whatever foam started with
    const SynthesisCounters before = counted();
    const TimeUs now_us = bench.now_us;
    (void)bench.answer({{1.0, 2.0, now_us}});
    // Height and its rate are there: four maps of sideways motion for each of the two keyframes of two cascades.
    EXPECT_EQ(counted().transforms - before.transforms, 4u * 2 * 2);
    EXPECT_EQ(counted().foam_ticks, before.foam_ticks);
    const auto joined = bench.fetch({now_us}, {3u, streamed | sea::surface_fields});
    ASSERT_TRUE(joined);
    EXPECT_EQ(counted().transforms - before.transforms, 4u * 2 * 2) << "all of it is held";
    Bench alone;
    const auto made =
        alone.fetch({now_us}, {3u, streamed.without({Field::foam}) | sea::surface_fields});
    ASSERT_TRUE(made);
    for (std::size_t i = 0; i < made->size(); ++i)
        for (const Field field : (*made)[i]->fields)
            EXPECT_TRUE(std::ranges::equal((*joined)[i]->plane(field), (*made)[i]->plane(field)))
                << sea::info(field).name;
}

TEST(SimulationCounters, a_plan_is_not_idle_while_what_a_question_made_is_held) {
    Bench bench({}, {}, 2, std::chrono::seconds(2));
    EXPECT_TRUE(bench.simulation->plan().idle());
    (void)bench.answer({{1.0, 2.0, 0}});
    EXPECT_FALSE(bench.simulation->plan().idle());
    EXPECT_TRUE(tests::eventually([&] { return bench.simulation->plan().idle(); }))
        << "nobody has asked since";
}

// The thread sleeps until the first keyframe of any cascade is due, not until the last.
TEST(ScheduleOfAll, the_next_that_is_due_is_the_first_of_all_cascades_that_somebody_wants) {
    sea::ErrorBudget budget;
    budget.cascades.resize(3);
    const TimeUs intervals_us[] = {700'000, 90'000, 400'000};
    for (std::size_t c = 0; c < 3; ++c)
        budget.cascades[c].interval_us = intervals_us[c];
    const FieldSet height{Field::height};
    RunningSea sea{};
    sea.epoch = 1;
    sea.budget = budget;
    const SeaCoursePtr course = steady_course(std::make_shared<const RunningSea>(std::move(sea)));
    for (unsigned wanted = 1; wanted < 8; ++wanted) {
        Schedule schedule(*course);
        EffectPlan plan;
        for (std::size_t c = 0; c < 3; ++c)
            plan.cascades.push_back({(wanted >> c) & 1u ? height : FieldSet{}, intervals_us[c], 0});
        for (TimeUs now_us = -1'000'000; now_us < 1'000'000; now_us += 37'000) {
            while (!schedule.take_due(plan, now_us).keyframes.empty())
                continue;
            // One microsecond before it nothing is due, and at it something is.
            const TimeUs due_us = *schedule.next_due_us(plan);
            Schedule early = schedule, late = schedule;
            EXPECT_TRUE(early.take_due(plan, due_us - 1).keyframes.empty()) << wanted;
            EXPECT_FALSE(late.take_due(plan, due_us).keyframes.empty()) << wanted;
        }
    }
}

TEST(QuestionLimits, as_many_of_one_asker_wait_as_may_and_one_more_is_refused) {
    Bench bench;
    std::atomic<std::size_t> answered = 0, refused = 0;
    const auto here = std::make_shared<char>();
    const auto ask = [&](const Asker& asker) {
        bench.simulation->answer(
            {{1, 2, 0}}, false,
            [&](const Result<std::vector<sea::Answer>>& answers) {
                ++(answers ? answered : refused);
            },
            asker);
    };
    {
        const Gate gate(bench);
        for (std::size_t i = 0; i < questions_of_one_max; ++i)
            ask(Asker(here));
        EXPECT_EQ(refused, 0u);
        ask(Asker(here));
        EXPECT_EQ(refused, 1u);
        ask(someone);
        EXPECT_EQ(refused, 1u) << "others have places of their own";
    }
    while (answered + refused < questions_of_one_max + 2)
        std::this_thread::yield();
    EXPECT_EQ(answered, questions_of_one_max + 1);
    ask(Asker(here));
    while (answered < questions_of_one_max + 2)
        std::this_thread::yield();
    EXPECT_EQ(refused, 1u) << "places come back";
}

// A double of that size has no place nearer than that: along either axis.
TEST(ExactAnswers, state_what_rounding_leaves_of_a_far_place_along_either_axis) {
    Bench bench;
    const auto answers = bench.answer({{0, 0, 0}, {1e9, 0, 0}, {0, -1e9, 0}, {3e8, 1e9, 0}}, true);
    ASSERT_EQ(answers.size(), 4u);
    EXPECT_LT(answers[0].error_m, 1e-7);
    for (std::size_t i = 1; i < 4; ++i)
        EXPECT_GE(answers[i].error_m, 4e-16 * 1e9) << i;
}

TEST(RunningSea, its_warnings_are_those_of_the_scene_the_foam_and_the_certificate) {
    // Too slow a growth for what is observed at this wind: foam says so.
    const RunningSeaPtr sea = running_sea("[foam]\ngain_per_s = 0.0001\n");
    const std::vector<std::string> all = warnings_of(*sea);
    std::vector<std::string> parts =
        sea::scene_warnings(sea->scene, *sea->realization, sea->summary, sea->budget);
    const std::vector<std::string> foam = sea::foam_warnings(sea->foam_law);
    ASSERT_FALSE(foam.empty());
    parts.insert(parts.end(), foam.begin(), foam.end());
    EXPECT_EQ(all, parts);
}

} // namespace
} // namespace seaway::server
