// SPDX-License-Identifier: Apache-2.0
// Foam is a function of the sea and the time: whoever asks, in whatever steps, and around a loop.
#include "sea/foam/foam_ticks.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/sea/foam/foam_seas.h"

namespace seaway::sea {
namespace {

/// Largest difference of two histories, in ratios.
double largest_difference(const FoamHistory& a, const FoamHistory& b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.ratios().size(); ++i)
        largest = std::max(largest, static_cast<double>(std::abs(a.ratios()[i] - b.ratios()[i])));
    return largest;
}

/// The same waves in a sea that repeats. Frequencies are rounded to the loop by phase_time alone, so
/// that the loop has a cut at its end: harder than a smooth one.
sea::RealizationPtr looping(TimeUs loop_us) {
    sea::Realization sea = *storm();
    sea.loop_period_us = loop_us;
    return std::make_shared<const sea::Realization>(std::move(sea));
}

TEST(Foam, is_the_same_for_who_has_run_for_long_and_who_starts_now_or_comes_from_elsewhere) {
    // exp(-10) of what a history may differ from the average by, some tens: 1e-3.
    const sea::RealizationPtr sea = storm();
    const FoamLawPtr law = make_foam_law(*sea, foam_model);
    Strains strains(sea, 0);
    const auto history = [&] { return FoamHistory(law, 0, 64, 100'000); };
    FoamHistory old = history(), elsewhere = history();
    for (TimeUs t = 3'000'000; t <= 90'000'000; t += 100'000) // at every keyframe
        ASSERT_TRUE(old.advance_to(t, strains.source()));
    for (const TimeUs t :
         {500'000'000, -7'000'000, 61'234'567, 71'300'001, 89'999'999}) // a jumpy client
        ASSERT_TRUE(elsewhere.advance_to(t, strains.source()));
    for (TimeUs t = 90'000'000; t <= 92'000'000; t += 100'000) { // also in the first seconds
        FoamHistory fresh = history();
        ASSERT_TRUE(old.advance_to(t, strains.source()));
        ASSERT_TRUE(elsewhere.advance_to(t, strains.source()));
        ASSERT_TRUE(fresh.advance_to(t, strains.source()));
        EXPECT_LT(largest_difference(old, fresh), 1e-3) << t;
        EXPECT_LT(largest_difference(old, elsewhere), 1e-3) << t;
    }
}

TEST(Foam, a_walk_in_slices_is_the_walk_at_once) {
    for (const TimeUs loop_us : {TimeUs{0}, TimeUs{7'300'000}}) {
        const sea::RealizationPtr sea = loop_us == 0 ? storm() : looping(loop_us);
        const FoamLawPtr law = make_foam_law(*sea, foam_model);
        Strains strains(sea, 0);
        FoamHistory whole(law, 0, 64, 100'000), sliced(law, 0, 64, 100'000);
        ASSERT_TRUE(whole.advance_to(60'000'000, strains.source()));
        const int ticks = std::exchange(strains.asked, 0);
        TimeUs goal_us = 60'000'000;
        for (int left = sliced.ticks_to(goal_us), slices = 0; left > 0; ++slices) {
            EXPECT_EQ(left, ticks - 7 * slices);
            const Result<bool> there = sliced.walk_towards(goal_us, 7, strains.source());
            ASSERT_TRUE(there);
            EXPECT_EQ(*there, left <= 7);
            left = sliced.ticks_to(goal_us);
        }
        EXPECT_EQ(strains.asked, ticks) << "no tick twice";
        ASSERT_TRUE(sliced.advance_to(goal_us, strains.source()));
        EXPECT_EQ(largest_difference(whole, sliced), 0.0);
    }
}

// The state of the tick, advanced by hand by the rest of the way with the strains of the moment: single precision twice.
TEST(Foam, between_two_ticks_is_that_of_the_earlier_advanced_by_the_rest) {
    const sea::RealizationPtr sea = storm();
    const FoamLawPtr law = make_foam_law(*sea, foam_model);
    Strains strains(sea, 0);
    constexpr TimeUs tick_us = 50'000'000, shown_us = tick_us + 70'000;
    FoamHistory shown(law, 0, 64, interval_us), by_hand(law, 0, 64, interval_us);
    ASSERT_TRUE(shown.advance_to(tick_us, strains.source()));
    ASSERT_TRUE(by_hand.advance_to(tick_us, strains.source()));
    const std::vector<float> at_tick(shown.ratios().begin(), shown.ratios().end());
    ASSERT_TRUE(shown.advance_to(shown_us, strains.source()));
    by_hand.advance(*strains.at(shown_us), 0.07);
    EXPECT_LT(largest_difference(shown, by_hand), 1e-5);
    double moved = 0;
    for (std::size_t i = 0; i < at_tick.size(); ++i)
        moved = std::max(moved, std::abs(static_cast<double>(shown.ratios()[i] - at_tick[i])));
    EXPECT_GT(moved, 0.01) << "something happens in 0.07 s";
}

TEST(Foam, a_start_that_is_half_way_goes_on_to_a_later_time_and_anew_to_an_earlier_one) {
    const sea::RealizationPtr sea = storm();
    const FoamLawPtr law = make_foam_law(*sea, foam_model);
    Strains strains(sea, 0);
    FoamHistory whole(law, 0, 64, 200'000), moved(law, 0, 64, 200'000);
    ASSERT_TRUE(whole.advance_to(60'000'000, strains.source()));
    ASSERT_TRUE(whole.advance_to(62'000'000, strains.source()));
    strains.asked = 0;
    ASSERT_FALSE(*moved.walk_towards(60'000'000, 50, strains.source()));
    EXPECT_EQ(moved.ticks_to(62'000'000), 160) << "150 of the start, 10 behind it";
    ASSERT_TRUE(*moved.walk_towards(62'000'000, 160, strains.source()));
    ASSERT_TRUE(moved.advance_to(62'000'000, strains.source()));
    EXPECT_EQ(strains.asked, 210);
    EXPECT_EQ(largest_difference(whole, moved), 0.0);

    ASSERT_FALSE(*moved.walk_towards(600'000'000, 50, strains.source()));
    EXPECT_EQ(moved.ticks_to(599'000'000), 200) << "its state is no history of that time";
    EXPECT_EQ(moved.ticks_to(900'000'000), 200) << "nor worth going on from";
}

// Naive: a history that came through a change under way is another than one that begins behind it.
TEST(Foam, what_a_changed_law_makes_is_the_same_whoever_asks_and_from_where_they_come) {
    const sea::RealizationPtr sea = storm();
    const FoamLawPtr law = make_foam_law(*sea, foam_model);
    FoamModel other_model = foam_model;
    other_model.threshold = *foam_model.threshold - 0.1;
    const FoamLawPtr other = make_foam_law(*sea, other_model);
    const auto law_at = [&](TimeUs t_us) { return t_us < 50'000'000 ? law : other; };
    Strains strains(sea, 0);
    FoamHistory film(law, 0, 64, 200'000), late(law, 0, 64, 200'000), old(law, 0, 64, 200'000);
    film.follow(law_at);
    late.follow(law_at);
    for (TimeUs t_us = 30'000'000; t_us <= 60'000'000; t_us += 3'000'000)
        ASSERT_TRUE(film.advance_to(t_us, strains.source()));
    ASSERT_TRUE(late.advance_to(60'000'000, strains.source()));
    ASSERT_TRUE(old.advance_to(60'000'000, strains.source()));
    EXPECT_LT(largest_difference(film, late), 2e-3) << "e^-10 of some 20";
    EXPECT_GT(largest_difference(film, old), 0.1) << "the other law breaks elsewhere";
}

// Naive: hundreds of ticks that leave an average an average.
TEST(Foam, a_calm_before_the_storm_takes_no_step_and_the_storm_begins_at_the_average) {
    const sea::RealizationPtr sea = storm();
    const FoamLawPtr rough = make_foam_law(*sea, foam_model);
    const FoamLawPtr calm = make_foam_law(
        *tests::make_sea({tests::calm_cascade(211.0, 64), tests::calm_cascade(37.0, 64)}),
        foam_model);
    ASSERT_TRUE(calm->calm());
    constexpr TimeUs storm_us = 50'000'000, tick_us = 200'000;
    FoamWalk walk(calm, 0, tick_us);
    walk.follow([&](TimeUs t_us) { return t_us <= storm_us ? calm : rough; });
    EXPECT_GT(walk.pass_calm(storm_us, 1000), 0);
    EXPECT_FALSE(walk.next(storm_us));
    const FoamView average = walk.at(storm_us);
    EXPECT_EQ(average.tick.remains, 0.0f) << "whatever stands in the map";
    EXPECT_EQ(average.tick.added, 1.0f);
    for (const TimeUs t_us : {storm_us + tick_us, storm_us + 2 * tick_us}) {
        const std::optional<FoamStep> step = walk.next(storm_us + 2 * tick_us);
        ASSERT_TRUE(step);
        EXPECT_EQ(step->time_us, t_us);
        EXPECT_TRUE(step->tick.looks());
        const bool first = t_us == storm_us + tick_us;
        const double remains = foam_remains(0.2, foam_model.decay_s);
        EXPECT_FLOAT_EQ(step->tick.remains, first ? 0.0f : static_cast<float>(remains));
        EXPECT_FLOAT_EQ(step->tick.added, first ? static_cast<float>(remains) : 0.0f);
    }
    EXPECT_FALSE(walk.next(storm_us + 2 * tick_us));
    // A law that nothing follows is that of all moments: not even counted.
    FoamWalk still(calm, 0, tick_us);
    still.follow([&](TimeUs) { return calm; }, false);
    EXPECT_EQ(still.ticks_to(storm_us), 0);
    EXPECT_TRUE(still.at(storm_us).is_state());
    // Nor looked at.
    FoamWalk alone(rough, 0, tick_us), watched(rough, 0, tick_us);
    watched.follow([&](TimeUs) { return calm; }, false);
    EXPECT_EQ(watched.at(storm_us + 1).tick.remains, alone.at(storm_us + 1).tick.remains);
    EXPECT_EQ(watched.at(storm_us + 1).departure, alone.at(storm_us + 1).departure);
    EXPECT_EQ(watched.next(storm_us)->tick.looks(), alone.next(storm_us)->tick.looks());
    still.may_change();
    const int ticks = still.ticks_to(storm_us);
    EXPECT_GT(ticks, 7);
    EXPECT_EQ(still.pass_calm(storm_us, 7), 7);
    EXPECT_EQ(still.ticks_to(storm_us), ticks - 7);
    EXPECT_EQ(still.pass_calm(storm_us, ticks), ticks - 7) << "no more than there are";
    EXPECT_EQ(still.ticks_to(storm_us), 0);
}

TEST(Foam, does_not_know_how_many_frames_a_second_it_is_asked_for) {
    const sea::RealizationPtr sea = storm();
    const FoamLawPtr law = make_foam_law(*sea, foam_model);
    Strains strains(sea, 1);
    FoamHistory film(law, 1, 64, 250'000), slow(law, 1, 64, 250'000);
    for (int frame = 0; frame <= 240; ++frame)
        ASSERT_TRUE(film.advance_to(sea::us_from_seconds(2.0 + frame / 24.0), strains.source()));
    for (int frame = 0; frame <= 70; ++frame)
        ASSERT_TRUE(slow.advance_to(sea::us_from_seconds(2.0 + frame / 7.0), strains.source()));
    EXPECT_LT(largest_difference(film, slow), 1e-3);
}

TEST(Foam, of_a_loop_meets_itself_at_its_end) {
    // 7.3 s is no multiple of a tick, and less than two decay times; the others are more than a memory,
    // and a tenth of a decay time.
    for (const TimeUs loop_us : {7'300'000, 60'000'000, 1'000'000}) {
        const sea::RealizationPtr sea = looping(loop_us);
        for (const double decay_s : {4.0, 10.0, 1e6}) {
            const FoamLawPtr law = make_foam_law(*sea, {0.6, decay_s, 3.0});
            Strains strains(sea, 0);
            FoamHistory first(law, 0, 64, interval_us), on(law, 0, 64, interval_us);
            ASSERT_TRUE(first.advance_to(1'234'567, strains.source()));
            for (TimeUs t = 1'234'567; t < loop_us + 1'234'567; t += 730'000)
                ASSERT_TRUE(on.advance_to(t, strains.source()));
            ASSERT_TRUE(on.advance_to(loop_us + 1'234'567, strains.source()));
            // Periodic: rounding of some hundred ticks. Longer than the memory: exp(-10) of some tens.
            const double bound = loop_us < 10'000'000 ? 2e-4 : 1e-3;
            EXPECT_LT(largest_difference(first, on), bound) << loop_us << " " << decay_s;
            FoamHistory later(law, 0, 64, interval_us);
            ASSERT_TRUE(later.advance_to(1000 * loop_us + 1'234'567, strains.source()));
            EXPECT_EQ(largest_difference(first, later), 0.0) << "alone, a thousand loops on";
        }
    }
}

TEST(Foam, of_a_loop_is_what_many_loops_leave) {
    // The periodic solution against plain running for 20 decay times, which leaves 2e-9 of the start.
    const TimeUs loop_us = 6'000'000;
    const sea::RealizationPtr sea = looping(loop_us);
    const FoamLawPtr law = make_foam_law(*sea, foam_model);
    Strains strains(sea, 0);
    FoamHistory history(law, 0, 64, interval_us), plain(law, 0, 64, interval_us);
    ASSERT_TRUE(history.advance_to(84'000'000, strains.source()));
    EXPECT_EQ(strains.asked, 30);
    for (TimeUs t = 4'000'000; t < 84'000'000; t += 200'000)
        plain.advance(*strains.at(t + 200'000), 0.2);
    EXPECT_LT(largest_difference(history, plain), 2e-4);
}

TEST(Foam, decay_times_too_long_to_walk_scatter_as_an_average_over_them_does) {
    // Half a minute in ticks of 0.2 s is beyond 512 ticks. Plain running over 6 decay times is the
    // truth; one tile has some dozens of crests: 25 % for the deviation.
    const sea::RealizationPtr sea = storm();
    const FoamLawPtr law = make_foam_law(*sea, {0.6, 30.0, 3.0});
    Strains strains(sea, 0);
    FoamHistory history(law, 0, 64, interval_us), plain(law, 0, 64, interval_us);
    ASSERT_TRUE(history.advance_to(180'000'000, strains.source()));
    EXPECT_LE(strains.asked, foam_ticks_max);
    for (TimeUs t = 200'000; t <= 180'000'000; t += 200'000)
        plain.advance(*strains.at(t), 0.2);
    const auto deviation = [](const FoamHistory& h) {
        double squares = 0;
        for (const float ratio : h.ratios())
            squares += std::pow(static_cast<double>(ratio) - 1.0, 2);
        return std::sqrt(squares / static_cast<double>(h.ratios().size()));
    };
    EXPECT_NEAR(deviation(history) / deviation(plain), 1.0, 0.25);
}

TEST(Foam, a_cascade_that_makes_nothing_break_stays_average) {
    // Naive: what breaks is divided by its mean, 0/0.
    const sea::RealizationPtr sea = storm();
    FoamLaw law = *make_foam_law(*sea, foam_model);
    law.cascades[0].mean_breaking = 0.0;
    Strains strains(sea, 0);
    FoamHistory history(std::make_shared<const FoamLaw>(law), 0, 64, interval_us);
    ASSERT_TRUE(history.advance_to(50'000'000, strains.source()));
    for (const float ratio : history.ratios())
        ASSERT_EQ(ratio, 1.0f);
}

TEST(Foam, every_legal_model_gives_finite_ratios_and_a_coverage_of_0_to_1) {
    const sea::RealizationPtr seas[] = {
        storm(), storm(0.0005), storm(0.3),
        tests::make_sea({storm()->cascades[0], tests::calm_cascade(37.0, 64)})};
    for (const sea::RealizationPtr& sea : seas) {
        const sea::KeyframePtr strains[] = {Strains(sea, 0).at(0), Strains(sea, 1).at(0)};
        for (const double threshold : {-1.0, 0.0, 1.0})
            for (const double decay_s : {0.0, 1e-9, 4.0, 1e6})
                for (const double gain_per_s : {0.0, 1e-9, 3.0, 1000.0})
                    for (const double bias : {0.0, 1.0}) {
                        const FoamLawPtr law =
                            make_foam_law(*sea, {threshold, decay_s, gain_per_s, bias});
                        ASSERT_GE(law->mean_coverage, 0.0);
                        ASSERT_LE(law->mean_coverage, foam_mean_max);
                        for (int c = 0; c < 2; ++c) {
                            const auto index = static_cast<std::size_t>(c);
                            FoamHistory history(law, c, 64, 2'000'000);
                            const sea::KeyframePtr& one = strains[index];
                            const auto same = [&](TimeUs) { return Result(one); };
                            ASSERT_TRUE(history.advance_to(5'000'000, same));
                            for (const float ratio : history.ratios()) {
                                ASSERT_TRUE(std::isfinite(ratio) && ratio >= 0)
                                    << threshold << " " << decay_s << " " << gain_per_s << " "
                                    << law->cascades[index].mean_breaking;
                                const double f = foam_coverage(law->mean_coverage, {&ratio, 1});
                                ASSERT_TRUE(f >= 0 && f <= 1);
                            }
                        }
                    }
    }
}

// A history of 512 ticks of 0.2 s holds ten decay times of 10.24 s at most. A longer decay averages over
// more: its departure from the average scatters as one over the root of how much. A loop holds no more
// independent moments than it is long, two decay times being one.
TEST(FoamTicks, a_decay_that_is_walked_shorter_departs_less_by_the_root_of_what_it_would_average) {
    constexpr double walked_s = 0.2 * 512 / 10;
    struct Row {
        double decay_s, loop_s, averaged_s;
    };
    for (const Row& row : {Row{5, 0, 0},
                           {walked_s, 0, 0},
                           {40, 0, 40},
                           {5000, 0, 5000},
                           {5000, 300, 150},
                           {5000, 120, 60},
                           {40, 300, 40},
                           {5000, 15, walked_s}}) {
        const FoamTicks ticks = foam_ticks(row.decay_s, 200'000, us_from_seconds(row.loop_s));
        EXPECT_EQ(ticks.tick_us, 200'000);
        EXPECT_NEAR(ticks.decay_s, std::min(row.decay_s, walked_s), 1e-12);
        EXPECT_NEAR(ticks.departure,
                    row.averaged_s > 0 ? std::sqrt(walked_s / row.averaged_s) : 1.0, 1e-12)
            << row.decay_s << " s in a loop of " << row.loop_s << " s";
        EXPECT_EQ(ticks.periodic, row.loop_s == 15);
    }
}

} // namespace
} // namespace seaway::sea
