// SPDX-License-Identifier: Apache-2.0
// Answers at the ends of what may be asked: ten thousand kilometres away, after thirty years, on waves about to fold.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "sea/surface/budget/error_budget.h"
#include "sea/surface/surface.h"
#include "tests/support/explicit_sea.h"

namespace seaway::sea {
namespace {

constexpr TimeUs between_us = 50'000;

Surface surface_at_time(const RealizationPtr& sea, TimeUs from_us) {
    std::vector<SplinePair> pairs;
    for (int c = 0; c < static_cast<int>(sea->cascades.size()); ++c)
        pairs.push_back(
            {std::make_shared<SplineMap>(*tests::exact_keyframe(sea, c, from_us)),
             std::make_shared<SplineMap>(*tests::exact_keyframe(sea, c, from_us + between_us))});
    return Surface(pairs, sea->choppiness, {.reach_m = 5.0}, {});
}

// n tiles of 200 m are whole doubles; a coordinate of 1e7 m is one to 2e-9 m. 1e-5 m was promised.
TEST(FarAway, an_answer_is_that_of_the_same_place_on_the_tile) {
    const RealizationPtr sea = tests::make_sea({tests::random_cascade(200.0, 64, 8, 60, 0.03, 1)});
    const Surface surface = surface_at_time(sea, 0);
    const DirectSum sum(sea);
    const DirectSum::Moment moment = sum.at_time(20'000);
    const InverseOptions exactly{sea->choppiness, 1e-9, {.reach_m = 5.0}};
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> on_tile(0, 200);
    double worst_m = 0;
    for (int i = 0; i < 2000; ++i) {
        // A sixteenth of a millimetre is exact at 1e7 m, so that both are the same place.
        const auto place = [&] { return std::round(on_tile(random) * 16384) / 16384; };
        const QueryPoint here{place(), place(), 20'000};
        const QueryPoint away{here.x_m + (i % 2 == 0 ? 1e7 : -1e7), here.y_m - 1e7, 20'000};
        const Answer near = surface.answer(here), far = surface.answer(away);
        EXPECT_EQ(near.flags, far.flags);
        worst_m = std::max(worst_m, std::abs(near.height_m - far.height_m));
        for (int axis = 0; axis < 3; ++axis) {
            EXPECT_NEAR(near.normal[axis], far.normal[axis], 1e-5);
            EXPECT_NEAR(near.velocity_mps[axis], far.velocity_mps[axis], 1e-5);
        }
        if (i < 100) {
            EXPECT_NEAR(surface_at(here, exactly, moment).height_m,
                        surface_at(away, exactly, moment).height_m, 1e-7);
        }
    }
    EXPECT_LT(worst_m, 1e-5);
}

// Where a sea folds, a step of a far place's last digit moves the residual by several: naively none of its sheets is near enough, and
// the one that is found by chance is the answer, with a bound of a few nanometres.
TEST(FarAway, the_highest_sheet_of_a_sea_that_folds_is_the_same) {
    const RealizationPtr sea =
        tests::make_sea({tests::random_cascade(128.0, 64, 10, 60, 0.1, 1)}, {3, 3});
    const DirectSum sum(sea);
    const DirectSum::Moment moment = sum.at_time(0);
    const auto answer = [&](const QueryPoint& point) {
        return surface_at(point, {sea->choppiness, exact_tolerance_m(point), {20.0, true}}, moment);
    };
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> on_tile(0, 128);
    int folded = 0;
    for (int i = 0; i < 1500; ++i) {
        const auto place = [&] { return std::round(on_tile(random) * 1024) / 1024; };
        const QueryPoint here{place(), place(), 0};
        const Answer near = answer(here);
        folded += (near.flags & answer_folded) != 0;
        for (const double tiles : {132'812.0, -7'000'000.0}) { // 17 000 and 896 000 km
            const QueryPoint away{here.x_m + 128 * tiles, here.y_m - 128 * tiles, 0};
            const Answer far = answer(away);
            EXPECT_EQ(near.flags, far.flags) << here.x_m << ' ' << here.y_m;
            if (!((near.flags | far.flags) & answer_open)) {
                const double within_m =
                    near.error_m + far.error_m + exact_tolerance_m(away) * (1 + surface_slope(far));
                EXPECT_NEAR(near.height_m, far.height_m, within_m) << here.x_m << ' ' << here.y_m;
            }
        }
    }
    EXPECT_GT(folded, 100) << "else nothing is compared";
}

// Phases are whole turns in 64 bits at any time; what is left is the spline's and the interpolation's, of other waves each time.
TEST(LongAfter, thirty_years_a_surface_is_as_near_to_its_sum_as_on_the_first_day) {
    const RealizationPtr sea = tests::two_cascades();
    const DirectSum sum(sea);
    const auto rms_m = [&](TimeUs from_us) {
        const Surface surface = surface_at_time(sea, from_us);
        const DirectSum::Moment moment = sum.at_time(from_us + 20'000);
        std::mt19937_64 random(5);
        std::uniform_real_distribution<double> place(-500, 500);
        double sum_m2 = 0;
        for (int i = 0; i < 1000; ++i) {
            const QueryPoint point{place(random), place(random), from_us + 20'000};
            const Answer exact =
                surface_at(point, {sea->choppiness, 1e-9, {.reach_m = 5.0}}, moment);
            const Answer answer = surface.answer(point);
            EXPECT_EQ(answer.flags, exact.flags);
            sum_m2 += std::pow(answer.height_m - exact.height_m, 2);
        }
        return std::sqrt(sum_m2 / 1000);
    };
    const double first_m = rms_m(0);
    EXPECT_LT(first_m, 1e-3) << "else nothing is compared";
    for (const TimeUs then_us : {TimeUs{1'000'000'000'000'000}, -TimeUs{1'000'000'000'000'000}})
        EXPECT_LT(rms_m(then_us), 1.5 * first_m);
}

/// One wave of a tile, so that the surface is known in closed form: at X + lambda D(X) it is as high as a cos(k X).
struct SingleWave {
    double amplitude_m, length_m, choppiness, height_error_m;
    int size;

    double k() const { return two_pi / length_m; }
    /// Where x lies, by bisection: X - lambda a sin(k X) grows where it does not fold.
    double height_m(double x_m) const {
        double from = x_m - length_m, to = x_m + length_m;
        for (int i = 0; i < 200; ++i) {
            const double middle = 0.5 * (from + to);
            (middle - choppiness * amplitude_m * std::sin(k() * middle) < x_m ? from : to) = middle;
        }
        return amplitude_m * std::cos(k() * from);
    }
};

// A place is met to a tolerance, by which heights are off as steep as the water is there, and by what it bends. Naive: no water is steeper
// than ten, and on a crest, which is level, nothing is missed.
TEST(Steep,
     what_the_tolerance_of_a_place_leaves_of_a_height_is_stated_wherever_water_is_steep_or_bends) {
    for (const SingleWave& wave : {SingleWave{100, 0.1, 1.2e-4, 0.01, 64},
                                   SingleWave{10, 1, 0.01, 0.1, 64}, SingleWave{5, 1, 0.02, 1, 64},
                                   SingleWave{10, 10, 0.1, 1, 64}, SingleWave{0.05, 0.5, 1, 1, 64},
                                   SingleWave{0.03, 0.5, 1, 1, 64}, SingleWave{1, 20, 1, 1, 64}}) {
        CascadeModes modes = tests::calm_cascade(wave.length_m, wave.size);
        tests::add_wave(modes, 1, 0, wave.amplitude_m, 0.0);
        const RealizationPtr sea = tests::make_sea({modes}, {wave.choppiness, wave.choppiness});
        const ErrorBudget budget = plan_budget(*sea, wave.height_error_m);
        const SplineMapPtr map = std::make_shared<SplineMap>(*tests::exact_keyframe(sea, 0, 0));
        const Surface surface({{{map, map}}}, sea->choppiness, fold_search(budget),
                              map_error(budget, 0), inverse_tolerance_m(wave.height_error_m));
        std::mt19937_64 random(17);
        std::uniform_real_distribution<double> place(-wave.length_m, wave.length_m);
        std::vector<QueryPoint> points;
        for (int i = 0; i < 1000; ++i)
            points.push_back({place(random), place(random), 0});
        std::vector<Answer> answers(points.size());
        surface.answer(points, answers);
        double worst = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Answer alone = surface.answer_carefully(points[i]);
            for (const Answer& answer : {answers[i], alone})
                if (!(answer.flags & answer_folded))
                    worst =
                        std::max(worst, std::abs(answer.height_m - wave.height_m(points[i].x_m)) /
                                            answer.error_m);
        }
        EXPECT_LT(worst, 1) << wave.amplitude_m << " m on " << wave.length_m << " m";
        EXPECT_GT(worst, 1e-4) << "else nothing is compared";
    }
}

/// Two crossing waves whose crests meet at the origin, steep enough for J = 0.08 there. With steepness s of each, directions
/// (1, 0) and (0.6, 0.8): I - s (e e^T + f f^T) has the determinant 1 - 2 s + s^2 (1 - 0.6^2).
struct Steep {
    static constexpr double jacobian_least = 0.08;
    static constexpr double tile_m = 100;
    static constexpr int waves = 5; // 20 m long

    static double steepness() { // the smaller root
        const double across = 1 - 0.36;
        return (1 - std::sqrt(1 - across * (1 - jacobian_least))) / across;
    }
    static RealizationPtr made(int size) {
        CascadeModes modes = tests::calm_cascade(tile_m, size);
        const double k = waves * two_pi / tile_m;
        tests::add_wave(modes, waves, 0, steepness() / k, 0.0);
        tests::add_wave(modes, 3, 4, steepness() / k, 0.0);
        return tests::make_sea({modes});
    }
};

// The numbers: 1e-6 m, 6 steps. Both waves have their crests together at every 20 m or so: a third of the places are
// chosen about them.
TEST(Steep, with_a_jacobian_of_8_percent_newton_finds_the_place_in_six_steps) {
    const RealizationPtr sea = Steep::made(32);
    const DirectSum sum(sea);
    const DirectSum::Moment moment = sum.at_time(0);
    EXPECT_NEAR(jacobian(moment.at(0, 0), sea->choppiness), Steep::jacobian_least, 1e-12);
    std::mt19937_64 random(9);
    std::uniform_real_distribution<double> anywhere(-50, 50), near_crest(-1.5, 1.5);
    int most = 0;
    double jacobian_met = 1;
    for (int i = 0; i < 3000; ++i) {
        std::uniform_real_distribution<double>& place = i % 3 == 0 ? near_crest : anywhere;
        const double X = place(random), Y = place(random);
        const LagrangianPoint p = moment.at(X, Y);
        ASSERT_GE(jacobian(p, sea->choppiness), Steep::jacobian_least - 1e-12) << "no folds";
        jacobian_met = std::min(jacobian_met, jacobian(p, sea->choppiness));
        int looks = 0;
        const auto field = [&](double x_m, double y_m) {
            ++looks;
            return moment.at(x_m, y_m);
        };
        const Answer answer = surface_at({X + p.displacement_x, Y + p.displacement_y, 0},
                                         {sea->choppiness, 1e-7, {.reach_m = 5.0}}, field);
        EXPECT_NEAR(answer.height_m, p.height, 1e-6) << X << " " << Y;
        EXPECT_EQ(answer.flags & answer_not_converged, 0u);
        most = std::max(most, looks - 1); // the first look is where it starts
    }
    EXPECT_LT(jacobian_met, 0.09);
    EXPECT_LE(most, 6);
}

// 256 points on 20 m waves: q = 0.12, a spline's error of 4e-7 of the amplitude; floats some 1e-6 m, over J = 0.08.
TEST(Steep, through_tiles_that_resolve_it_the_height_is_right_to_a_millimetre) {
    const RealizationPtr sea = Steep::made(256);
    const DirectSum sum(sea);
    const DirectSum::Moment moment = sum.at_time(0);
    const SplineMapPtr map = std::make_shared<SplineMap>(*tests::exact_keyframe(sea, 0, 0));
    const Surface surface({{map, map}}, sea->choppiness, {.reach_m = 5.0}, {});
    std::mt19937_64 random(9);
    std::uniform_real_distribution<double> anywhere(-50, 50), near_crest(-1.5, 1.5);
    for (int i = 0; i < 3000; ++i) {
        std::uniform_real_distribution<double>& place = i % 3 == 0 ? near_crest : anywhere;
        const double X = place(random), Y = place(random);
        const LagrangianPoint p = moment.at(X, Y);
        const Answer answer = surface.answer({X + p.displacement_x, Y + p.displacement_y, 0});
        EXPECT_NEAR(answer.height_m, p.height, 1e-3) << X << " " << Y;
        EXPECT_EQ(answer.flags & answer_not_converged, 0u);
    }
}

} // namespace
} // namespace seaway::sea
