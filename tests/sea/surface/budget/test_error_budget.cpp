// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "sea/native/native_runner.h"
#include "sea/surface/budget/error_budget.h"
#include "sea/surface/surface.h"
#include "tests/support/explicit_sea.h"

namespace seaway::sea {
namespace {

TEST(ErrorBudget, hermite_and_spline_laws_match_their_leading_order) {
    // u^4/384 to 2 % at u = 0.5 (the next term is u^6/7680); 2 (q/2pi)^4 pi^4/45 likewise.
    EXPECT_NEAR(hermite_error(0.5) / (std::pow(0.5, 4) / 384), 1.0, 0.02);
    const double leading = 4.0 * std::pow(0.3 / two_pi, 4) * std::pow(pi, 4) / 90.0;
    EXPECT_NEAR(spline_error(0.3) / leading, 1.0, 0.06);
    // The slope of the images: sum of 2 (q / 2 pi j)^3 over j > 0, zeta(3) = 1.202.
    EXPECT_NEAR(spline_slope_error(0.3) / (2.0 * std::pow(0.3 / two_pi, 3) * 1.202), 1.0, 0.1);
}

TEST(ErrorBudget, a_tighter_budget_never_gets_longer_intervals) {
    const RealizationPtr sea = tests::two_cascades();
    TimeUs before[2] = {keyframe_intervals_us[0], keyframe_intervals_us[0]};
    for (const double error_m : {1.0, 0.1, 0.03, 0.01, 0.003, 0.001, 1e-4}) {
        const ErrorBudget budget = plan_budget(*sea, error_m);
        for (std::size_t c = 0; c < 2; ++c) {
            EXPECT_LE(budget.cascades[c].interval_us, before[c]);
            before[c] = budget.cascades[c].interval_us;
        }
    }
    EXPECT_LT(before[1], keyframe_intervals_us[0]);
}

TEST(ErrorBudget, realised_error_stays_inside_the_stated_bound) {
    const RealizationPtr sea = tests::two_cascades();
    const ErrorBudget budget = plan_budget(*sea, 0.01);
    const DirectSum sum(sea);
    std::vector<SplinePair> pairs;
    TimeUs shortest = keyframe_intervals_us[0];
    for (int c = 0; c < 2; ++c) {
        const TimeUs interval = budget.cascades[static_cast<std::size_t>(c)].interval_us;
        shortest = std::min(shortest, interval);
        pairs.push_back({std::make_shared<SplineMap>(*tests::exact_keyframe(sea, c, 0)),
                         std::make_shared<SplineMap>(*tests::exact_keyframe(sea, c, interval))});
    }
    const Surface surface(std::move(pairs), sea->choppiness, fold_search(budget),
                          map_error(budget, 0.0));
    std::mt19937 random(2);
    std::uniform_real_distribution<double> place(-1e6, 1e6);
    double worst_share = 0;
    for (int i = 0; i < 1000; ++i) {
        const TimeUs t = shortest * (i % 8) / 8;
        const QueryPoint point{place(random), place(random), t};
        const Answer answer = surface.answer(point);
        const Answer truth = surface_at(point, {sea->choppiness, 1e-9, 5.0}, sum.at_time(t));
        const double error = std::abs(answer.height_m - truth.height_m);
        EXPECT_LE(error, answer.error_m);
        worst_share = std::max(worst_share, error / answer.error_m);
    }
    EXPECT_GT(worst_share, 0.05) << "a bound that nothing ever comes near says nothing";
}

/// Random points of a sea of one cascade, answered from its maps and by the direct sum.
struct Folding {
    int points = 2000;
    int flagged = 0;
    int apart = 0; ///< further from the truth than error_m
    int apart_unflagged = 0;
    int truth_flagged = 0;
};

Folding folding(double steepness, double choppiness) {
    auto made = std::make_shared<Realization>(
        *tests::make_sea({tests::random_cascade(200.0, 64, 9, 60, steepness, 5)}));
    made->choppiness = {choppiness, choppiness};
    const RealizationPtr sea = made;
    const ErrorBudget budget = plan_budget(*sea, 0.01);
    const FoldSearch folds = fold_search(budget);
    const TimeUs interval_us = budget.cascades[0].interval_us;
    const DirectSum sum(sea);
    const Surface surface(
        {{std::make_shared<SplineMap>(*tests::exact_keyframe(sea, 0, 0)),
          std::make_shared<SplineMap>(*tests::exact_keyframe(sea, 0, interval_us))}},
        sea->choppiness, folds, map_error(budget, 0.0));
    const auto moment = sum.at_time(interval_us / 3);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> place(-1e4, 1e4);
    Folding result;
    for (int i = 0; i < result.points; ++i) {
        const QueryPoint point{place(random), place(random), interval_us / 3};
        const Answer answer = surface.answer(point);
        const Answer truth = surface_at(point, {sea->choppiness, 1e-9, folds}, moment);
        EXPECT_TRUE(std::isfinite(answer.height_m));
        const bool apart = std::abs(answer.height_m - truth.height_m) > answer.error_m;
        const bool flagged = (answer.flags & answer_folded) != 0;
        result.flagged += flagged;
        result.truth_flagged += (truth.flags & answer_folded) != 0;
        result.apart += apart;
        result.apart_unflagged += apart && !flagged;
    }
    return result;
}

// At choppiness 3 times a slope of 0.3 the sea is a tangle of sheets. Its maps and its direct sum find
// the same one, but for points at the very edge of a fold, and those say that the surface folds.
TEST(ErrorBudget, D3_an_answer_on_another_sheet_than_the_truth_is_flagged) {
    const Folding tangle = folding(0.05, 3);
    EXPECT_GT(tangle.truth_flagged, 20) << "too tame a sea to tell anything";
    EXPECT_LE(tangle.apart, tangle.truth_flagged / 20);
    EXPECT_EQ(tangle.apart_unflagged, 0);
}

// A flag on every answer would say nothing: answers carry it as often as the truth does, and in a gale
// none.
TEST(ErrorBudget, D3_flags_are_about_as_common_as_folds) {
    for (const double steepness : {0.03, 0.05}) {
        const Folding steep = folding(steepness, 3);
        EXPECT_EQ(steep.apart_unflagged, 0);
        EXPECT_LE(steep.flagged, steep.truth_flagged + 0.01 * steep.points);
        EXPECT_GE(steep.flagged, 0.8 * steep.truth_flagged);
    }
    EXPECT_EQ(folding(0.03, 1).flagged, 0);
}

// Bounds are held as formulas: each term left out would still leave most errors inside.
TEST(ErrorBudget, what_is_stated_is_the_sum_of_all_its_parts) {
    const RealizationPtr sea =
        tests::make_sea({tests::random_cascade(300.0, 64, 12, 300, 0.004, 11),
                         tests::random_cascade(41.0, 64, 15, 300, 0.004, 12)},
                        {0.7, 1.3});
    const ErrorBudget budget = plan_budget(*sea, 0.01);
    double missed_m2 = 0, strain_missed2 = 0, variance_m2 = 0, slope2 = 0, single_m = 0,
           single_strain = 0;
    for (std::size_t c = 0; c < 2; ++c) {
        const CascadeModes& modes = sea->cascades[c];
        const double dx = modes.spec.spacing_m();
        double wave_m2 = 0, own_m2 = 0;
        for (int iy = 0; iy < 64; ++iy)
            for (int ix = 0; ix < 64; ++ix) {
                const double v = 2 * std::norm(modes.h0[static_cast<std::size_t>(iy * 64 + ix)]);
                const double qx = two_pi / 64 * std::abs(signed_index(ix, 64));
                const double qy = two_pi / 64 * std::abs(signed_index(iy, 64));
                const double missed = spline_error(qx) + spline_error(qy);
                const double slope_missed = spline_slope_error(qx) + spline_slope_error(qy);
                const double slope_v = v * (qx * qx + qy * qy) / (dx * dx);
                own_m2 += v;
                slope2 += slope_v;
                const double u =
                    omega_from_rate(modes.rate[static_cast<std::size_t>(iy * 64 + ix)]) *
                    seconds_from_us(budget.cascades[c].interval_us);
                wave_m2 += v * std::pow(missed + hermite_error(u), 2);
                strain_missed2 += slope_v * std::pow(slope_missed + hermite_error(u), 2);
            }
        variance_m2 += own_m2;
        single_m += single_precision_share * 4 * std::sqrt(own_m2);
        single_strain += sampled_slope_error(single_precision_share * 4 * std::sqrt(own_m2), dx);
        EXPECT_EQ(budget.cascades[c].spacing_m, dx);
        const MapLoss& height = budget.cascades[c].loss.height;
        // The budget takes frequencies by bins, each at its upper end: a little more.
        EXPECT_GE(height.interpolation_variance_m2(), wave_m2);
        EXPECT_LT(height.interpolation_variance_m2(), 1.1 * wave_m2);
        EXPECT_NEAR(height.time_m, budget.cascades[c].loss.displacement.time_m, 1e-12);
        missed_m2 += height.interpolation_variance_m2();
    }
    EXPECT_NEAR(budget.single_precision_m, single_m, 1e-15);
    EXPECT_NEAR(budget.interpolation_m, 5 * std::sqrt(missed_m2) + single_m, 1e-12);
    EXPECT_NEAR(budget.interpolation_displacement_m, 5 * std::sqrt(missed_m2) + single_m, 1e-12);
    // Level water sees no sideways error, and coding counts at the slope that is typical.
    const double weight = 1.3 * budget.rms_slope, codec_m = 0.007;
    EXPECT_NEAR(level_error_m(budget, codec_m),
                std::sqrt(25 * missed_m2 + codec_m * codec_m / (1 + weight * weight)) + single_m,
                1e-12);
    EXPECT_GE(budget.interpolation_strain, 6 * std::sqrt(strain_missed2) + single_strain);
    EXPECT_LT(budget.interpolation_strain, 1.1 * (6 * std::sqrt(strain_missed2) + single_strain));
    EXPECT_EQ(map_error(budget, 0).strain_bound, budget.interpolation_strain);
    EXPECT_EQ(map_error(budget, 0).codec_strain_bound, 0);
    EXPECT_EQ(map_error(budget, 0).height_bound_m, budget.single_precision_m);
    EXPECT_NEAR(budget.rms_slope, std::sqrt(slope2), 1e-12);
    EXPECT_NEAR(budget.displacement_reach_m, 6 * 1.3 * std::sqrt(variance_m2), 1e-12);
    EXPECT_DOUBLE_EQ(fold_search(budget).reach_m, budget.displacement_reach_m);
    EXPECT_EQ(fold_search(1.0, {0.7, 1.3}, 0.16).always, false);
    EXPECT_EQ(fold_search(1.0, {0.7, 1.3}, 0.163).always, true); // above 0.21 / 1.3
}

TEST(ErrorBudget, given_intervals_leave_the_codec_what_is_left) {
    const RealizationPtr sea = tests::two_cascades();
    const ErrorBudget chosen = plan_budget(*sea, 0.01);
    const TimeUs same[] = {chosen.cascades[0].interval_us, chosen.cascades[1].interval_us};
    const ErrorBudget given = plan_budget(*sea, 0.01, same);
    EXPECT_NEAR(given.codec_error_m / chosen.codec_error_m, 1.0, 1e-12);
    EXPECT_EQ(given.interpolation_m, chosen.interpolation_m);
    // Two thirds of the interval lose a fifth, and leave the rest to the codec.
    const TimeUs shorter[] = {same[0] * 2 / 3, same[1] * 2 / 3};
    const ErrorBudget finer = plan_budget(*sea, 0.01, shorter);
    EXPECT_GT(finer.codec_error_m, 1.05 * chosen.codec_error_m);
    EXPECT_LE(level_error_m(finer, finer.codec_error_m), 0.01);
    // Intervals that lose all of it leave a sixteenth of the variance, and the stated bound says so.
    const TimeUs longer[] = {2'000'000, 2'000'000};
    const ErrorBudget coarse = plan_budget(*sea, 0.01, longer);
    EXPECT_GT(coarse.codec_error_m, 0);
    EXPECT_GT(level_error_m(coarse, coarse.codec_error_m), 0.01);
}

TEST(ErrorBudget, codec_bounds_spend_exactly_what_they_were_given) {
    const RealizationPtr sea = tests::two_cascades();
    const ErrorBudget budget = plan_budget(*sea, 0.01);
    const double codec_m = 0.0045;
    const MapError error = map_error(budget, codec_m);
    double variance = 0, strain = 0;
    for (int c = 0; c < 2; ++c) {
        const CascadeBudget& own = budget.cascades[static_cast<std::size_t>(c)];
        const double interval_s = seconds_from_us(own.interval_us);
        const std::vector<float> bounds = codec_bounds(budget, surface_fields, c, codec_m);
        ASSERT_EQ(bounds.size(), 6u);
        // Even between plus and minus the bound: a third of its square.
        const double value2 = std::pow(bounds[0], 2) / 3, rate2 = std::pow(bounds[3], 2) / 3;
        const double peak = value2 * codec_peak(rate2 * interval_s * interval_s / value2);
        EXPECT_EQ(bounds[0], bounds[1]);
        EXPECT_EQ(bounds[3], bounds[5]);
        const CascadeLoss& loss = error.cascades[static_cast<std::size_t>(c)];
        for (const MapLoss* map : {&loss.height, &loss.displacement}) {
            EXPECT_NEAR(map->value_m, std::sqrt(value2), 1e-6 * map->value_m);
            EXPECT_NEAR(map->rate_mps, std::sqrt(rate2), 1e-6 * map->rate_mps);
        }
        const double weight = budget.rms_slope; // choppiness 1
        variance += peak * (1 + weight * weight);
        strain += peak * 3.4217 / std::pow(own.spacing_m, 2);
    }
    EXPECT_NEAR(5 * std::sqrt(variance), codec_m, 1e-5 * codec_m);
    EXPECT_NEAR(error.codec_strain_bound, 6 * std::sqrt(2 * strain),
                1e-5 * error.codec_strain_bound);
}

/// Two maps by the native device, one interval apart.
Surface native_surface(const RealizationPtr& sea, const ErrorBudget& budget) {
    NativeRunner runner(1);
    std::vector<SplinePair> pairs;
    for (std::size_t c = 0; c < sea->cascades.size(); ++c) {
        const CascadeModes& modes = sea->cascades[c];
        const auto transform = NativeTransform::create(modes, sea->choppiness);
        const auto map = [&](TimeUs time_us) {
            Keyframe keyframe;
            keyframe.time_us = time_us;
            keyframe.size = modes.spec.size;
            keyframe.length_m = modes.spec.length_m;
            keyframe.fields = surface_fields;
            keyframe.values.resize(keyframe.plane_size() * 6);
            const NativeTask task{&*transform, time_us, surface_fields, keyframe.values};
            runner.run({&task, 1});
            return std::make_shared<const SplineMap>(keyframe);
        };
        pairs.push_back({map(0), map(budget.cascades[c].interval_us)});
    }
    return Surface(std::move(pairs), sea->choppiness, fold_search(budget), map_error(budget, 0));
}

// Long waves on a fine grid, at the shortest intervals: interpolation costs next to nothing, and what
// is left is single precision. Without it in the bound every third answer is outside.
TEST(ErrorBudget, single_precision_is_part_of_what_is_stated) {
    const RealizationPtr sea =
        tests::make_sea({tests::random_cascade(4000.0, 256, 1, 20, 0.004, 5),
                         tests::random_cascade(3900.0, 256, 1, 20, 0.004, 6)});
    const ErrorBudget budget = plan_budget(*sea, 1e-5);
    const Surface surface = native_surface(sea, budget);
    const TimeUs time_us = budget.cascades[0].interval_us / 2;
    const DirectSum sum(sea);
    const auto moment = sum.at_time(time_us);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> place(-1e5, 1e5);
    double worst_share = 0;
    for (int i = 0; i < 3000; ++i) {
        const QueryPoint point{place(random), place(random), time_us};
        const Answer answer = surface.answer(point);
        const Answer truth = surface_at(point, {sea->choppiness, 1e-10, 5.0}, moment);
        // The residual of 0.1 mm that Newton may leave is no part of this.
        const double residual_m = answer.error_m - budget.interpolation_m -
                                  surface_slope(answer) * budget.interpolation_displacement_m;
        worst_share =
            std::max(worst_share, (std::abs(answer.height_m - truth.height_m) - residual_m) /
                                      (answer.error_m - residual_m));
    }
    EXPECT_LT(worst_share, 1.0);
    EXPECT_GT(worst_share, 0.1) << "nothing ever comes near the bound";
}

// Waves whose phases a scene gives may all crest at one place and time: 800 of them reach forty standard
// deviations there. Here they meet in the middle of a cell between two keyframes.
TEST(ErrorBudget, waves_given_in_phase_stay_inside_the_bound_where_they_meet) {
    const double middle_m = 0.5 * 100.0 / 64;
    CascadeModes modes = tests::calm_cascade(100.0, 64);
    double displaced_m = 0, strain = 0;
    constexpr TimeUs meeting_us = 160'000;
    modes.given.assign(modes.h0.size(), 0);
    for (int ny = -20; ny <= 20; ++ny)
        for (int nx = 1; nx <= 20; ++nx) {
            const auto i = static_cast<std::size_t>((ny + 64) % 64 * 64 + nx);
            const double k = two_pi / 100 * std::hypot(nx, ny);
            const double phase = -two_pi / 100 * (nx + ny) * middle_m +
                                 omega_from_rate(modes.rate[i]) * seconds_from_us(meeting_us);
            tests::add_wave(modes, nx, ny, 0.001, phase);
            modes.given[i] = 1;
            displaced_m += 0.001;
            strain += 0.001 * k;
        }
    const RealizationPtr sea = tests::make_sea({modes}, {0.5, 0.5});
    const TimeUs intervals_us[] = {2 * meeting_us};
    const ErrorBudget budget = plan_budget(*sea, 0.01, intervals_us);
    EXPECT_NEAR(budget.displacement_reach_m, 0.5 * displaced_m, 1e-9);
    EXPECT_NEAR(budget.rms_strain, folds_searched_above * strain, 1e-9);
    const DirectSum sum(sea);
    const Surface surface(
        {{std::make_shared<SplineMap>(*tests::exact_keyframe(sea, 0, 0)),
          std::make_shared<SplineMap>(*tests::exact_keyframe(sea, 0, 2 * meeting_us))}},
        sea->choppiness, fold_search(budget), map_error(budget, 0));
    double worst_share = 0;
    for (int i = -20; i <= 20; ++i) {
        const QueryPoint point{middle_m + 0.05 * i, middle_m + 0.02 * i, meeting_us};
        const Answer answer = surface.answer(point);
        const Answer truth =
            surface_at(point, {sea->choppiness, 1e-9, 5.0}, sum.at_time(meeting_us));
        if (answer.flags & answer_folded)
            continue;
        worst_share =
            std::max(worst_share, std::abs(answer.height_m - truth.height_m) / answer.error_m);
    }
    EXPECT_LT(worst_share, 1.0);
    EXPECT_GT(worst_share, 0.3) << "where they meet the bound is nearly met";
}

// What sheets are told apart by (sea/surface/sheets.h): a bound that is too small misses folds, one
// that is too large flags them everywhere.
TEST(ErrorBudget, strains_of_maps_stay_inside_the_stated_bound) {
    const RealizationPtr sea =
        tests::make_sea({tests::random_cascade(300.0, 64, 19, 300, 0.004, 11),
                         tests::random_cascade(41.0, 64, 19, 300, 0.004, 12)});
    const ErrorBudget budget = plan_budget(*sea, 0.01);
    const Surface surface = native_surface(sea, budget);
    const DirectSum sum(sea);
    std::mt19937 random(8);
    std::uniform_real_distribution<double> place(-1e3, 1e3);
    double worst = 0;
    for (const TimeUs time_us : {0, 7, 31, 50, 60}) {
        const TimeUs t = budget.cascades[1].interval_us * time_us / 100;
        const auto moment = sum.at_time(t);
        for (int i = 0; i < 1000; ++i) {
            const double x = place(random), y = place(random);
            const LagrangianPoint a = surface.at(x, y, t), b = moment.at(x, y);
            const double xx = a.strain_xx - b.strain_xx, yy = a.strain_yy - b.strain_yy;
            const double xy = a.strain_xy - b.strain_xy;
            worst = std::max(worst, std::abs(0.5 * (xx + yy)) + std::hypot(0.5 * (xx - yy), xy));
        }
    }
    EXPECT_LT(worst, budget.interpolation_strain);
    EXPECT_GT(worst, 0.2 * budget.interpolation_strain);
}

// Errors of +-e at the grid points, as a codec may leave them: by lot, and the worst there is.
TEST(ErrorBudget, errors_at_grid_points_tilt_a_spline_by_no_more_than_is_stated) {
    constexpr int size = 16;
    constexpr double length_m = 8, e = 0.01;
    std::mt19937 random(9);
    double worst = 0;
    for (int round = 0; round < 200; ++round) {
        Keyframe keyframe;
        keyframe.size = size;
        keyframe.length_m = length_m;
        keyframe.fields = surface_fields;
        keyframe.values.assign(keyframe.plane_size() * 6, 0.0f);
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x)
                for (const Field field : {Field::displacement_x, Field::displacement_y}) {
                    // Around the middle of cell (8, 8) the spline's own signs, alternating outwards.
                    const auto out = [](int i) { return (i < 8 ? 7 - i : i - 8) % 2 ? -1 : 1; };
                    const double sign = round > 0 ? (random() & 1 ? 1 : -1)
                                        : field == Field::displacement_x
                                            ? (x < 8 ? -1 : 1) * out(x) * out(y)
                                            : (x < 8 ? -1 : 1) * out(x) * out(y);
                    keyframe.plane(field)[static_cast<std::size_t>(y * size + x)] =
                        static_cast<float>(e * sign);
                }
        const SplineMap map(keyframe);
        for (int i = 0; i < 200; ++i) {
            const auto place = [&] {
                return static_cast<double>(random() % 4096) / 4096 * length_m;
            };
            const bool middle = round == 0 && i == 0;
            const SplineSample s =
                middle ? map.sample(8.0 - 3.75, 8.0 - 3.75) : map.sample(place(), place());
            const double xx = static_cast<double>(s.d_dx[1]), yy = static_cast<double>(s.d_dy[2]);
            const double xy = 0.5 * static_cast<double>(s.d_dy[1] + s.d_dx[2]);
            worst = std::max(worst, std::abs(0.5 * (xx + yy)) + std::hypot(0.5 * (xx - yy), xy));
        }
    }
    const double stated = sampled_slope_error(spline_gain * e, length_m / size);
    EXPECT_LT(worst, stated);
    EXPECT_GT(worst, 0.4 * stated);
}

} // namespace
} // namespace seaway::sea
