// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "sea/surface/error_budget.h"
#include "sea/surface/surface.h"
#include "tests/support/explicit_sea.h"

namespace seaway::sea {
namespace {

RealizationPtr some_sea() {
    return tests::make_sea({tests::random_cascade(300.0, 64, 12, 300, 0.004, 11),
                            tests::random_cascade(41.0, 64, 15, 300, 0.004, 12)});
}

TEST(ErrorBudget, shares_add_up_to_one) {
    const BudgetShares shares;
    EXPECT_DOUBLE_EQ(shares.time + shares.space + shares.codec + shares.query, 1.0);
}

TEST(ErrorBudget, hermite_and_spline_laws_match_their_leading_order) {
    // u^4/384 to 2 % at u = 0.5 (the next term is u^6/7680); 2 (q/2pi)^4 pi^4/45 likewise.
    EXPECT_NEAR(hermite_error(0.5) / (std::pow(0.5, 4) / 384), 1.0, 0.02);
    const double leading = 4.0 * std::pow(0.3 / two_pi, 4) * std::pow(pi, 4) / 90.0;
    EXPECT_NEAR(spline_error(0.3) / leading, 1.0, 0.06);
}

TEST(ErrorBudget, a_tighter_budget_never_gets_longer_intervals) {
    const RealizationPtr sea = some_sea();
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
    const RealizationPtr sea = some_sea();
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
    double missed_m2 = 0, variance_m2 = 0, slope2 = 0;
    for (std::size_t c = 0; c < 2; ++c) {
        const CascadeModes& modes = sea->cascades[c];
        double space_m2 = 0;
        for (int iy = 0; iy < 64; ++iy)
            for (int ix = 0; ix < 64; ++ix) {
                const double v = 2 * std::norm(modes.h0[static_cast<std::size_t>(iy * 64 + ix)]);
                const double qx = two_pi / 64 * std::abs(signed_index(ix, 64));
                const double qy = two_pi / 64 * std::abs(signed_index(iy, 64));
                const double missed = spline_error(qx) + spline_error(qy);
                const double dx = modes.spec.spacing_m();
                space_m2 += v * missed * missed;
                variance_m2 += v;
                slope2 += v * (qx * qx + qy * qy) / (dx * dx);
            }
        EXPECT_NEAR(budget.cascades[c].space_rms_m, std::sqrt(space_m2), 1e-12);
        missed_m2 += space_m2 + std::pow(budget.cascades[c].time_rms_m, 2);
    }
    EXPECT_NEAR(budget.interpolation_m, 6 * std::sqrt(missed_m2), 1e-12);
    EXPECT_NEAR(budget.rms_slope, std::sqrt(slope2), 1e-12);
    EXPECT_NEAR(budget.displacement_reach_m, 6 * 1.3 * std::sqrt(variance_m2), 1e-12);
    EXPECT_DOUBLE_EQ(fold_search(budget).reach_m, budget.displacement_reach_m);
    EXPECT_EQ(fold_search(1.0, {0.7, 1.3}, 0.22).always, false);
    EXPECT_EQ(fold_search(1.0, {0.7, 1.3}, 0.24).always, true); // above 0.3 / 1.3
}

TEST(ErrorBudget, codec_bounds_spend_exactly_what_they_were_given) {
    const RealizationPtr sea = some_sea();
    const ErrorBudget budget = plan_budget(*sea, 0.01);
    const double codec_m = 0.0045;
    double height = 0;
    for (int c = 0; c < 2; ++c) {
        const std::vector<float> bounds = codec_bounds(budget, surface_fields, c, codec_m);
        ASSERT_EQ(bounds.size(), 6u);
        height += sampled_codec_error(
            static_cast<double>(bounds[0]), static_cast<double>(bounds[3]),
            seconds_from_us(budget.cascades[static_cast<std::size_t>(c)].interval_us));
    }
    const MapError error = map_error(budget, codec_m);
    EXPECT_NEAR(height, error.codec_height_m, 1e-3 * height);
    // Height plus the displacement's part at three times the typical slope is the whole share.
    const double steep = std::min(1.0, 3 * budget.rms_slope);
    EXPECT_NEAR(error.codec_height_m + steep * error.codec_displacement_m, codec_m, 1e-12);
}

} // namespace
} // namespace seaway::sea
