// SPDX-License-Identifier: Apache-2.0
// How water moves below linear waves: sideways coth(kd) times as far as up and down.
#include <gtest/gtest.h>

#include <cmath>

#include "sea/foam/foam_law.h"
#include "sea/surface/budget/error_budget.h"
#include "sea/waves/statistics/moments.h"
#include "sea/waves/transition.h"
#include "tests/sea/csv.h"
#include "tests/sea/sea_fixture.h"
#include "tests/support/airy_waves.h"

namespace seaway::sea {
namespace {

using seaway::testing::one_wave;
using seaway::testing::realized;
using seaway::testing::three_cascades;
using seaway::testing::windy_sea;

TEST(Orbits, D02_are_as_wide_as_the_tables_of_the_shore_protection_manual_say) {
    const seaway::testing::Table table("D02_spm_table_c1");
    for (std::size_t r = 0; r < table.size(); ++r) {
        const double kd = table.number(r, "kd");
        if (kd >= orbit_kd_min) {
            // Printed to 8 digits.
            EXPECT_NEAR(orbit_aspect(kd, 1.0) * table.number(r, "tanh_kd"), 1.0, 1e-7) << kd;
            EXPECT_NEAR(orbit_aspect(kd / 7.0, 7.0) * table.number(r, "sinh_kd") /
                            table.number(r, "cosh_kd"),
                        1.0, 1e-7);
        }
    }
}

TEST(Orbits, are_circles_in_deep_water_and_no_flatter_than_linear_theory_allows) {
    for (const double depth : {deep_water_m, 1e7, 20.001})
        EXPECT_EQ(orbit_aspect(1.0, depth), 1.0) << depth;
    // coth(0.05) = 1/0.05 + 0.05/3 - 0.05^3/45 + ...
    for (const double kd : {0.05, 0.01, 1e-9})
        EXPECT_NEAR(orbit_aspect(kd, 1.0), 20.016663889550, 1e-11);
}

TEST(WaterMotion, of_ten_airy_waves_is_theirs_to_1e_9) {
    for (const tests::AiryWave& wave : tests::airy_waves) {
        const double depth = wave.depth_m;
        auto sea = std::make_shared<Realization>(
            *one_wave(5 * wave.length_m, 16, 3, 4, wave.amplitude_m(), 0.0, depth));
        for (CascadeModes& modes : sea->cascades)
            for (Rate& rate : modes.rate)
                if (rate != 0) // without surface tension
                    rate = rate_from_omega(two_pi / wave.period_s);
        const DirectSum sum(sea);
        const double k = two_pi / wave.length_m;
        for (const double theta : {0.0, 0.9, 2.5, -1.4}) {
            const LagrangianPoint p =
                sum.at(0.6 * theta / k, 0.8 * theta / k, 0); // theta = k.X, at time 0
            const double moved = -wave.horizontal_displacement_m() * std::sin(theta);
            const double u = wave.horizontal_speed_mps() * std::cos(theta);
            const double stretch = -k * wave.horizontal_displacement_m() * std::cos(theta);
            EXPECT_NEAR(p.displacement_x, 0.6 * moved, 1e-9 * wave.height_m);
            EXPECT_NEAR(p.displacement_y, 0.8 * moved, 1e-9 * wave.height_m);
            EXPECT_NEAR(p.displacement_x_rate, 0.6 * u, 1e-9 * wave.height_m);
            EXPECT_NEAR(p.displacement_y_rate, 0.8 * u, 1e-9 * wave.height_m);
            EXPECT_NEAR(p.height_rate, wave.vertical_speed_mps() * std::sin(theta),
                        1e-9 * wave.height_m);
            EXPECT_NEAR(p.strain_xx, 0.36 * stretch, 1e-9);
            EXPECT_NEAR(p.strain_yy, 0.64 * stretch, 1e-9);
            EXPECT_NEAR(p.strain_xy, 0.48 * stretch, 1e-9);
        }
    }
}

TEST(WaterMotion, in_deep_water_no_bit_depends_on_the_depth) {
    // The longest wave of three_cascades has k = 0.0123 rad/m: kd is above 20 from 1630 m on.
    SeaState deep = windy_sea();
    deep.depth_m = deep_water_m;
    SeaState trench = windy_sea();
    trench.depth_m = 1e4;
    const DirectSum a(realized(deep, three_cascades)), b(realized(trench, three_cascades));
    for (const double x : {0.0, 12.3, -777.7}) {
        const LagrangianPoint p = a.at(x, 2 * x, 1'234'567), q = b.at(x, 2 * x, 1'234'567);
        EXPECT_EQ(p.height, q.height);
        EXPECT_EQ(p.displacement_x, q.displacement_x);
        EXPECT_EQ(p.displacement_y_rate, q.displacement_y_rate);
        EXPECT_EQ(p.strain_xy, q.strain_xy);
    }
}

TEST(WaterMotion, an_answers_velocity_is_the_waters_whatever_the_choppiness) {
    SeaState state = windy_sea();
    state.depth_m = 6.0;
    const RealizationPtr sea = realized(state, three_cascades);
    const DirectSum sum(sea);
    const auto moment = sum.at_time(5'000'000);
    for (const Choppiness choppiness : {Choppiness{0, 0}, {0.4, 0.7}, {1, 1}})
        for (const double x : {3.0, -40.0, 900.0}) {
            const LagrangianPoint p = moment.at(x, 0.3 * x);
            const QueryPoint point{x + choppiness.x * p.displacement_x,
                                   0.3 * x + choppiness.y * p.displacement_y, 5'000'000};
            const Answer answer = surface_at(point, {choppiness, 1e-10, {.reach_m = 10}}, moment);
            // Newton ends within 1e-10 m of X, where rates change by less than 10 a metre.
            EXPECT_NEAR(answer.velocity_mps[0], p.displacement_x_rate, 1e-8);
            EXPECT_NEAR(answer.velocity_mps[1], p.displacement_y_rate, 1e-8);
            EXPECT_NEAR(answer.velocity_mps[2], p.height_rate, 1e-8);
        }
}

TEST(WaterMotion, glides_when_the_depth_changes) {
    SeaState shallow = windy_sea();
    shallow.depth_m = 5.0;
    SeaState deep = windy_sea();
    deep.depth_m = deep_water_m;
    const RealizationPtr from = realized(deep, three_cascades);
    const RealizationPtr to = realized(shallow, three_cascades);
    const TimeUs start = 1'000'000, end = 11'000'000;
    const auto change = SeaTransition::create(from, to, start, end);
    ASSERT_TRUE(change);
    const auto moved = [&](const RealizationPtr& sea, TimeUs t) {
        return DirectSum(sea).at(3.0, 4.0, t).displacement_x;
    };
    EXPECT_NEAR(moved(change->at(start), start), moved(from, start), 1e-9);
    EXPECT_EQ(change->at(start)->cascades[0].depth_m, deep_water_m);
    EXPECT_NEAR(moved(change->at(end - 1), end - 1), moved(change->after(), end - 1), 1e-6);
    EXPECT_EQ(change->after()->cascades[0].depth_m, 5.0);
    // Half way the inverse depth is half of the new one's.
    EXPECT_NEAR(change->at(6'000'000)->cascades[0].depth_m, 10.0, 1e-9);
}

/// Of many points of the direct sum of a shallow sea: what its plans and laws say of strains and of
/// how far points are moved. Nothing of this knew of coth(kd).
TEST(WaterMotion, budget_foam_and_summary_know_how_far_shallow_water_moves) {
    SeaState state = windy_sea();
    state.depth_m = 3.0;
    const Realization sea = *realize(state, three_cascades);
    const DirectSum sum(std::make_shared<const Realization>(sea));
    const auto moment = sum.at_time(77'000'000);
    double divergence_2 = 0, xx_2 = 0, moved_2 = 0, moved_max = 0, slope_2 = 0;
    const int n = 4000;
    for (int i = 0; i < n; ++i) { // a lattice rule over a square of 3.6 km
        const LagrangianPoint p = moment.at(3600.0 * std::fmod(i * 0.754877666, 1.0),
                                            3600.0 * std::fmod(i * 0.569840291, 1.0));
        divergence_2 += std::pow(p.strain_xx + p.strain_yy, 2) / n;
        xx_2 += p.strain_xx * p.strain_xx / n;
        slope_2 += (p.slope_x * p.slope_x + p.slope_y * p.slope_y) / n;
        const double moved = std::hypot(p.displacement_x, p.displacement_y);
        moved_2 += moved * moved / n;
        moved_max = std::max(moved_max, moved);
    }
    const ErrorBudget budget = plan_budget(sea, 0.01);
    const SeaSummary summary = summarize(state, sea);
    StrainMoments moments;
    for (const CascadeModes& modes : sea.cascades)
        moments += strain_moments(modes, sea.choppiness);
    // Means of squares over 4000 points, some hundred waves, at one instant: 10 %. Without
    // coth(kd), which is 2 to 8 for the long waves here, each is off by a factor.
    EXPECT_NEAR(budget.rms_strain * budget.rms_strain / divergence_2, 1.0, 0.15);
    EXPECT_NEAR(summary.realised.mean_square_strain / divergence_2, 1.0, 0.15);
    EXPECT_NEAR(moments.aa / xx_2, 1.0, 0.15);
    EXPECT_NEAR(budget.displacement_reach_m / 6.0 / std::sqrt(moved_2), 1.0, 0.1);
    EXPECT_GT(budget.displacement_reach_m, moved_max);
    EXPECT_NEAR(budget.rms_slope * budget.rms_slope / slope_2, 1.0, 0.15);
    EXPECT_GT(budget.rms_strain, 1.2 * budget.rms_slope);
    EXPECT_GT(budget.interpolation_displacement_m, budget.interpolation_m);
}

TEST(WaterMotion, in_deep_water_strains_and_reach_are_those_of_slopes_and_heights) {
    SeaState state = windy_sea();
    state.depth_m = deep_water_m;
    const ErrorBudget budget = plan_budget(*realize(state, three_cascades), 0.01);
    EXPECT_EQ(budget.rms_strain, budget.rms_slope);
    EXPECT_EQ(budget.interpolation_displacement_m, budget.interpolation_m);
    const SeaSummary summary = summarize(state, *realize(state, three_cascades));
    EXPECT_EQ(summary.realised.mean_square_strain, summary.realised.mean_square_slope);
}

} // namespace
} // namespace seaway::sea
