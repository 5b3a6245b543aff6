// SPDX-License-Identifier: Apache-2.0
// A simulation whose sea changes: keyframes, answers and foam on the way.
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "sea/scene/weather.h"
#include "server/simulation/memory_needs.h"
#include "tests/server/simulation/simulation_bench.h"

namespace seaway::server {
namespace {

sea::Scene changed(const Bench& bench, const std::string& path, const std::string& value) {
    const TomlAssignment one{path, value};
    Result<sea::Scene> next = sea::changed(bench.sea->scene, {&one, 1});
    EXPECT_TRUE(next) << (next ? "" : next.error().message);
    return *std::move(next);
}

void change(Bench& bench, const std::string& path, const std::string& value, TimeUs start_us,
            TimeUs end_us) {
    const Result<void> added = bench.course->add(changed(bench, path, value), start_us, end_us);
    ASSERT_TRUE(added) << added.error().message;
}

// A glide of the shortest length, to a sea three times as high, in other depth and with other choppiness: the bound is
// of one answer in a million, of each of 4000 here.
TEST(SimulationChanges,
     answers_from_maps_hold_their_bounds_against_the_exact_sum_throughout_a_glide) {
    for (const auto& [path, value] : std::initializer_list<std::pair<const char*, const char*>>{
             {"systems.0.wind_speed_10m_mps", "17.0"},
             {"systems.0.wind_speed_10m_mps", "4.0"},
             {"sea.depth_m", "9.0"},
             {"sea.choppiness", "0.3"},
             {"sea.seed", "8"}}) {
        Bench bench;
        change(bench, path, value, 20 * second_us, 30 * second_us);
        std::vector<sea::QueryPoint> points;
        for (int i = 0; i < 800; ++i)
            points.push_back({37.7 * i, -11.3 * i, 15 * second_us + 25'013 * i});
        const std::vector<sea::Answer> maps = bench.answer(points), exact = [&] {
            std::vector<sea::Answer> all;
            for (std::size_t i = 0; i < points.size(); i += 200)
                for (const sea::Answer& one :
                     bench.answer({points.begin() + static_cast<std::ptrdiff_t>(i),
                                   points.begin() + static_cast<std::ptrdiff_t>(i) + 200},
                                  true))
                    all.push_back(one);
            return all;
        }();
        double largest = 0, bound = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            if ((maps[i].flags | exact[i].flags) & sea::answer_folded)
                continue;
            const double error = std::abs(maps[i].height_m - exact[i].height_m);
            EXPECT_LE(error, maps[i].error_m + exact[i].error_m)
                << path << " at " << points[i].time_us;
            largest = std::max(largest, error);
            bound = std::max(bound, maps[i].error_m);
        }
        RecordProperty(path, std::to_string(largest) + " of " + std::to_string(bound));
        EXPECT_GT(largest, 1e-6);
        EXPECT_LT(bound, 3 * bench.sea->budget.height_error_m) << path << ": a bound to go by";
    }
}

/// Of displacements half way between keyframes of the first cascade, against the exact sum.
double largest_miss_m(Bench& bench, TimeUs from_us, TimeUs until_us) {
    const RunningSeaPtr sea = bench.course->at(from_us);
    const TimeUs interval_us = sea->budget.cascades[0].interval_us;
    const double step_m = 301.0 / 64, h_s = sea::seconds_from_us(interval_us);
    double largest_m = 0;
    for (TimeUs at_us = interval_start(from_us, interval_us); at_us < until_us;
         at_us += interval_us) {
        const TimeUs middle_us = at_us + interval_us / 2;
        const auto held =
            *bench.fetch({middle_us}, {1u, {Field::displacement_x, Field::displacement_x_rate}});
        auto first = std::make_shared<sea::Realization>(*sea->waves_at(middle_us));
        first->cascades.resize(1);
        const sea::DirectSum truth(first);
        for (std::size_t i = 0; i < 64 * 64; i += 37) {
            const auto at = [&](std::size_t k, Field field) {
                return static_cast<double>(std::as_const(*held[k]).plane(field)[i]);
            };
            const double mixed =
                (at(0, Field::displacement_x) + at(1, Field::displacement_x)) / 2 +
                h_s / 8 * (at(0, Field::displacement_x_rate) - at(1, Field::displacement_x_rate));
            const double x_m = static_cast<double>(i % 64) * step_m;
            const std::size_t row = i / 64;
            const double y_m = static_cast<double>(row) * step_m;
            largest_m =
                std::max(largest_m, std::abs(mixed - truth.at(x_m, y_m, middle_us).displacement_x));
        }
    }
    return largest_m;
}

// Naive: between its keyframes water is where it would be in water of one depth. A glide misses no more than the sea that
// it leads to, in which water moves furthest sideways.
TEST(SimulationChanges, displacements_between_keyframes_follow_a_glide_of_the_depth) {
    Bench bench;
    change(bench, "sea.depth_m", "3.0", 20 * second_us, 30 * second_us);
    EXPECT_LT(largest_miss_m(bench, 22 * second_us, 28 * second_us),
              1.2 * largest_miss_m(bench, 40 * second_us, 50 * second_us));
}

// Naive: the seas of all times are made first; of more than are kept the first ones are gone by then, and each keyframe
// makes its own anew.
TEST(SimulationChanges, a_fetch_of_times_in_more_glides_than_are_kept_makes_each_sea_once) {
    Bench bench;
    constexpr int glides = static_cast<int>(seas_kept) + 2;
    std::vector<TimeUs> times_us;
    for (int i = 0; i < glides; ++i) {
        const TimeUs start_us = (100 + 60 * i) * second_us;
        change(bench, "systems.0.wind_speed_10m_mps", i % 2 == 0 ? "11.0" : "8.0", start_us,
               start_us + 20 * second_us);
        times_us.push_back(start_us + 7 * second_us);
    }
    const Demand demand{sea::all_cascades, sea::surface_fields};
    const std::uint64_t before = bench.course->seas_made();
    const std::vector<sea::KeyframePtr> all = bench.fetch(times_us, demand).value();
    // Of each glide itself and the sea that it leads to, which the next one leaves.
    EXPECT_LE(bench.course->seas_made() - before, static_cast<std::uint64_t>(2 * glides));
    ASSERT_EQ(all.size(), static_cast<std::size_t>(glides) * 2 * 2);
    std::size_t next = 0;
    for (const TimeUs time_us : times_us) {
        const std::vector<sea::KeyframePtr> single = bench.fetch({time_us}, demand).value();
        for (const sea::KeyframePtr& alone : single) {
            EXPECT_EQ(all[next]->time_us, alone->time_us);
            EXPECT_EQ(all[next]->epoch, alone->epoch);
            EXPECT_EQ(all[next++]->values, alone->values);
        }
    }
}

// Every moment has two keyframes around it of the sea that runs then, and nobody has to ask for them.
TEST(SimulationChanges, a_stream_has_the_keyframes_around_every_moment_of_every_sea) {
    Bench bench;
    bench.subscriptions.set(1, {~0u, sea::surface_fields});
    change(bench, "systems.0.wind_speed_10m_mps", "16.0", 10'300'000, 21 * second_us);
    for (int i = 0; i < 260; ++i)
        bench.advance(100'000);
    std::map<std::pair<std::uint32_t, int>, std::vector<TimeUs>> times;
    for (const sea::KeyframePtr& keyframe : bench.published)
        times[{keyframe->epoch, keyframe->cascade}].push_back(keyframe->time_us);
    for (TimeUs t_us = 2 * second_us; t_us < 25 * second_us; t_us += 10'000) {
        const RunningSeaPtr sea = bench.course->at(t_us);
        for (int c = 0; c < 2; ++c) {
            const TimeUs interval_us =
                sea->budget.cascades[static_cast<std::size_t>(c)].interval_us;
            const auto& held = times[{sea->epoch, c}];
            for (const TimeUs k_us : {interval_start(t_us, interval_us),
                                      interval_start(t_us, interval_us) + interval_us})
                EXPECT_EQ(std::ranges::count(held, k_us), 1)
                    << sea->epoch << ' ' << c << ' ' << k_us;
        }
    }
    EXPECT_EQ(bench.simulation->counters().keyframes_skipped, 0u);
    // A newcomer in the glide is given what the stream does not bring again.
    bench.published.clear();
    const std::vector<sea::KeyframePtr> start = bench.fetch_current({~0u, sea::surface_fields});
    EXPECT_FALSE(start.empty());
    EXPECT_EQ(start.front()->epoch, 3u);
}

TEST(SimulationChanges, what_was_held_of_a_sea_to_come_is_not_taken_for_the_sea_that_took_over) {
    Bench bench;
    const sea::QueryPoint later{5, 6, 100 * second_us};
    const double before = bench.answer({later})[0].height_m;
    change(bench, "systems.0.wind_speed_10m_mps", "16.0", 20 * second_us, 40 * second_us);
    const sea::Answer after = bench.answer({later})[0], exact = bench.answer({later}, true)[0];
    EXPECT_GT(std::abs(after.height_m - before), 0.05);
    EXPECT_LE(std::abs(after.height_m - exact.height_m), after.error_m + exact.error_m);
    EXPECT_EQ(bench.answer({{5, 6, 10 * second_us}}, true)[0].height_m,
              Bench().answer({{5, 6, 10 * second_us}}, true)[0].height_m)
        << "the past stays as it was";
}

/// A glide that begins and ends where keyframes of cascade 0 of all three seas lie, some 40 and 60 s.
std::pair<TimeUs, TimeUs> meeting_times(const std::string& scene, const std::string& path,
                                        const std::string& value) {
    Bench bench(scene);
    change(bench, path, value, 40 * second_us, 60 * second_us);
    TimeUs together_us = 1;
    for (std::uint32_t epoch = 1; epoch <= 3; ++epoch)
        together_us =
            std::lcm(together_us, bench.course->sea(epoch)->budget.cascades[0].interval_us);
    EXPECT_LE(together_us, 20 * second_us);
    const TimeUs start_us = interval_start(40 * second_us, together_us);
    return {start_us, interval_start(start_us + 19 * second_us, together_us) + together_us};
}

// The map of foam at a boundary is the same on both of its sides, and a history that walked through the change is that of
// one who starts behind it.
TEST(SimulationChanges, foam_goes_on_over_a_change_and_is_the_same_for_who_comes_later) {
    const std::string foamy = "[foam]\nthreshold = 0.9\ndecay_s = 2\n";
    const auto [start_us, end_us] = meeting_times(foamy, "systems.0.wind_speed_10m_mps", "13.0");
    const FieldSet foam{Field::foam};
    Bench stream(foamy), late(foamy);
    for (Bench* bench : {&stream, &late})
        change(*bench, "systems.0.wind_speed_10m_mps", "13.0", start_us, end_us);
    for (TimeUs t_us = start_us - 5 * second_us; t_us < end_us + 10 * second_us; t_us += second_us)
        ASSERT_TRUE(stream.fetch({t_us}, {1u, foam}));
    const auto map = [&](Bench& bench, std::uint32_t epoch, TimeUs t_us) {
        const auto both = *bench.fetch({t_us - 1, t_us}, {1u, foam});
        for (const sea::KeyframePtr& keyframe : both)
            if (keyframe->epoch == epoch && keyframe->time_us == t_us) {
                const auto plane = std::as_const(*keyframe).plane(Field::foam);
                return std::vector<float>(plane.begin(), plane.end());
            }
        ADD_FAILURE() << "no keyframe of epoch " << epoch << " at " << t_us;
        return std::vector<float>(1);
    };
    for (const auto& [epoch, t_us] : {std::pair(2u, start_us), std::pair(3u, end_us)}) {
        EXPECT_EQ(map(late, epoch - 1, t_us), map(late, epoch, t_us)) << "where two seas meet";
        const std::vector<float> one = map(stream, epoch, t_us), other = map(late, epoch, t_us);
        double largest = 0;
        for (std::size_t i = 0; i < one.size(); ++i)
            largest = std::max(largest, double{std::abs(one[i] - other[i])});
        EXPECT_LT(largest, 5e-3) << "e^-10 of some 50";
        EXPECT_GT(*std::ranges::max_element(one), 2.0f);
    }
    // Ratios to the mean: 1 on average by the law of the sea that runs; by that of a stormier one before less.
    change(late, "systems.0.wind_speed_10m_mps", "6.0", end_us, end_us + 10 * second_us);
    const TimeUs interval_us = late.course->sea(5)->budget.cascades[0].interval_us;
    double sum = 0, count = 0;
    for (int i = 0; i < 8; ++i)
        for (const float ratio :
             map(late, 5, interval_start(end_us + (40 + 7 * i) * second_us, interval_us))) {
            sum += double{ratio};
            ++count;
        }
    EXPECT_NEAR(sum / count, 1.0, 0.04); // 1.0001 is measured, and 0.88 by the law of the first sea
}

// The last keyframe of one sea and the first of the next lie on both sides of the boundary: their foam is that of the
// boundary, so that no history ever goes back.
TEST(SimulationChanges, foam_at_a_boundary_between_keyframes_is_that_of_the_boundary) {
    Bench bench("[foam]\nthreshold = 0.9\ndecay_s = 2\n");
    const TimeUs start_us = 40'001'234;
    change(bench, "systems.0.wind_speed_10m_mps", "13.0", start_us, start_us + 20 * second_us);
    const auto both = *bench.fetch({start_us - 1, start_us}, {1u, {Field::foam}});
    std::vector<float> before, after;
    for (const sea::KeyframePtr& keyframe : both) {
        const auto plane = std::as_const(*keyframe).plane(Field::foam);
        if (keyframe->epoch == 1 && keyframe->time_us > start_us)
            before.assign(plane.begin(), plane.end());
        if (keyframe->epoch == 2 && keyframe->time_us < start_us)
            after.assign(plane.begin(), plane.end());
    }
    ASSERT_FALSE(before.empty());
    EXPECT_EQ(before, after);
}

// Naive: a history that somebody has asked to a time beyond goes on from there, through a sea that never was.
TEST(SimulationChanges, foam_of_a_sea_that_another_took_over_from_is_walked_for_anew) {
    const std::string foamy = "[foam]\nthreshold = 0.9\ndecay_s = 2\n";
    Bench asked(foamy), late(foamy);
    const TimeUs time_us = 22 * second_us;
    ASSERT_TRUE(asked.fetch({time_us - 2 * second_us}, {1u, {Field::foam}}));
    const auto map = [&](Bench& bench) {
        change(bench, "systems.0.from_deg", "70.0", 5 * second_us, 15 * second_us);
        const auto made = *bench.fetch({time_us}, {1u, {Field::foam}});
        const auto plane = std::as_const(*made.front()).plane(Field::foam);
        return std::vector<float>(plane.begin(), plane.end());
    };
    EXPECT_EQ(map(asked), map(late));
}

/// Somebody changes the sea while it walks through ticks of foam.
class InterruptedSynthesizer final : public Synthesizer {
  public:
    explicit InterruptedSynthesizer(std::function<void()>& once) : once_(once) {}
    std::string description() const override { return inner_.description(); }
    Result<void> set_sea(sea::RealizationPtr sea, std::uint32_t epoch) override {
        return inner_.set_sea(std::move(sea), epoch);
    }
    Result<FoamMapPtr> open_foam(int size, const FoamMap* from) override {
        return inner_.open_foam(size, from);
    }
    Result<std::vector<NewKeyframePtr>>
    synthesize(std::span<const KeyframeRequest> requests) override {
        if (const auto once = std::exchange(once_, nullptr))
            once();
        return inner_.synthesize(requests);
    }
    SynthesisCounters counters() const override { return inner_.counters(); }

  private:
    std::function<void()>& once_;
    NativeSynthesizer inner_{1};
};

// Naive: the foam of the keyframe is of an earlier time by then, which the history is past.
TEST(SimulationChanges, a_change_in_the_middle_of_a_walk_of_foam_is_not_in_its_way) {
    const RunningSeaPtr sea = running_sea("[foam]\nthreshold = 0.9\ndecay_s = 1\n");
    const auto course = std::make_shared<SeaCourse>(sea);
    std::function<void()> change = [&] {
        const TomlAssignment wind{"systems.0.wind_speed_10m_mps", "13.0"};
        ASSERT_TRUE(
            course->add(*sea::changed(sea->scene, {&wind, 1}), 5 * second_us, 15 * second_us));
    };
    const Memory memory(Memory::bytes_default, needs_of(*sea));
    KeyframeSource source(course,
                          RebuiltSynthesizer::start(
                              [&](const sea::RealizationPtr& waves, std::uint32_t epoch,
                                  server::Making) -> Result<std::unique_ptr<Synthesizer>> {
                                  auto made = std::make_unique<InterruptedSynthesizer>(change);
                                  SEAWAY_TRY(made->set_sea(waves, epoch));
                                  return std::unique_ptr<Synthesizer>(std::move(made));
                              },
                              sea->realization, sea->epoch, nullptr)
                              .value(),
                          memory);
    const TimeUs time_us = 20 * second_us;
    KeyframeJob job(keyframes_around(*course, {&time_us, 1}, {1u, {Field::foam}}), Walk::questions);
    std::size_t made = 0;
    for (int slices = 0; slices < 100 && !job.complete(); ++slices) {
        const Result<bool> part = source.work_on(job);
        ASSERT_TRUE(part);
        if (*part)
            made += job.take().size();
    }
    EXPECT_EQ(made, 2u);
    EXPECT_EQ(course->epochs(), 3u);
}

TEST(SimulationChanges, a_device_that_fails_in_a_glide_is_rebuilt_and_goes_on_with_it) {
    Bench bench, other;
    for (Bench* one : {&bench, &other})
        change(*one, "systems.0.wind_speed_10m_mps", "14.0", 20 * second_us, 40 * second_us);
    const std::vector<sea::QueryPoint> points{{1, 2, 30 * second_us}};
    *bench.failures = 2;
    EXPECT_EQ(bench.answer(points)[0].height_m, other.answer(points)[0].height_m);
    EXPECT_GE(bench.simulation->counters().device_rebuilds, 1u);
}

} // namespace
} // namespace seaway::server
