// SPDX-License-Identifier: Apache-2.0
// Hard cases of choppiness: the inverse displacement and its normal.
#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "sea/basics/gaussian.h"
#include "sea/surface/inverse.h"
#include "tests/hard_cases/maps.h"
#include "tests/hard_cases/record.h"
#include "tests/naive/surface.h"
#include "tests/support/explicit_sea.h"

namespace seaway::hard_cases {
namespace {

using sea::Answer;
using sea::CascadeModes;
using sea::DirectSum;
using sea::LagrangianPoint;
using sea::RealizationPtr;

/// eta = a cos X, D = -a sin X: one wave of wavenumber 1 m^-1, J = 1 - a cos X.
LagrangianPoint trochoid(double a, double X) {
    LagrangianPoint p;
    p.height = a * std::cos(X);
    p.displacement_x = -a * std::sin(X);
    p.slope_x = -a * std::sin(X);
    p.strain_xx = -a * std::cos(X);
    return p;
}

/// Waves along x with Gaussian amplitudes, mean square slope `mss`.
CascadeModes long_crested(std::uint64_t seed, double mss) {
    CascadeModes modes = sea::random_modes(128, 0, 1);
    constexpr int first = 6, last = 40;
    for (int n = first; n <= last; ++n) {
        const auto [real, imaginary] = sea::gaussian_pair({seed, 0, 0, n, 0});
        const double k = n * modes.spec.wavenumber_step_radpm();
        const double sigma = std::sqrt(mss / (last - first + 1)) / k;
        put_wave(modes, n, 0, std::complex(real, imaginary) * 0.5 * sigma);
    }
    modes.depth_m = sea::deep_water_m;
    return modes;
}

// Brute force: every X of a fine lattice that lands on x.
TEST(HardCase, D3_of_three_sheets_above_a_point_the_highest_answers) {
    const auto field = [](double X, double) { return trochoid(1.2, X); };
    double ours = 0, met = 0;
    for (double x = -0.06; x <= 0.06; x += 0.004) {
        double highest = -10;
        for (double X = -2; X < 2; X += 1e-5)
            if ((X - 1.2 * std::sin(X) > x) != (X + 1e-5 - 1.2 * std::sin(X + 1e-5) > x))
                highest = std::max(highest, 1.2 * std::cos(X));
        const Answer answer =
            sea::surface_at({x, 0, 0}, {{1, 1}, 1e-9, {.reach_m = 2, .always = true}}, field);
        const naive::Undisplaced first = naive::fixed_point(field, x, 0, 1e-9, 200);
        ours = std::max(ours, std::abs(answer.height_m - highest));
        met = std::max(met, std::abs(trochoid(1.2, first.x_m).height - highest));
        EXPECT_TRUE(answer.flags & sea::answer_folded) << x;
    }
    EXPECT_LT(ours, 1e-4); // the lattice of the brute force
    EXPECT_GT(met, 0.01);
    record("one wave of steepness 1.2 around its crest", "largest error of the height, m", met,
           ours);
}

// Stokes: crests are sharp and short, troughs are long. Above its mean level a trochoid of steepness a is
// 1/2 - a/pi of the way.
TEST(HardCase, D5_crests_are_shorter_than_troughs) {
    const double a = 0.5;
    const auto field = [a](double X, double) { return trochoid(a, X); };
    const naive::Field other_sign = naive::turned(field);
    double ours = 0, turned = 0;
    constexpr int points = 2000;
    for (int i = 0; i < points; ++i) {
        const double x = sea::two_pi * i / points;
        ours += sea::surface_at({x, 0, 0}, {{1, 1}, 1e-9, {}}, field).height_m > 0;
        turned += sea::surface_at({x, 0, 0}, {{1, 1}, 1e-9, {}}, other_sign).height_m > 0;
    }
    EXPECT_NEAR(ours / points, 0.5 - a / sea::pi, 2e-3);
    EXPECT_GT(turned / points, 0.5);
    record("one wave of steepness 0.5", "share of its length above the mean level", turned / points,
           ours / points);
}

// J = 1 + lambda d D_x/dx is normal with deviation lambda sqrt(mss): the folded share is Phi(-1/0.5) =
// 2.3 %, within 3 standard errors over 200 seas.
TEST(HardCase, D1_the_folded_share_is_the_normal_tail_and_without_choppiness_j_is_one) {
    const double mss = 0.0625, lambda = 2.0;
    std::vector<double> shares;
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        const CascadeModes modes = long_crested(seed, mss);
        const auto folded = maps(modes, {sea::Field::jacobian}, 0, {lambda, lambda});
        int below = 0;
        for (std::size_t x = 0; x < 128; ++x)
            below += folded[x] < 0;
        shares.push_back(below / 128.0);
        for (const float j : maps(modes, {sea::Field::jacobian}, 0, {0, 0}))
            ASSERT_EQ(j, 1.0f);
    }
    double share = 0, variance = 0;
    for (const double s : shares)
        share += s / 200;
    for (const double s : shares)
        variance += (s - share) * (s - share) / 199;
    const double expected = 0.5 * std::erfc(1 / (lambda * std::sqrt(2 * mss)));
    EXPECT_NEAR(share, expected, 3 * std::sqrt(variance / 200));
    // The highest sheet of a folded crest lies upside down.
    const auto field = [](double X, double) { return trochoid(1.2, X); };
    const Answer answer = sea::surface_at({0, 0, 0}, {{1, 1}, 1e-9, {}}, field);
    EXPECT_GE(answer.normal[2], 0.0);
    EXPECT_LT(naive::normal_z(trochoid(1.2, 0)), 0.0);
    record("crest of steepness 1.2", "z of its normal", naive::normal_z(trochoid(1.2, 0)),
           answer.normal[2]);
}

// Six Newton steps and the evaluation that finds them good. J is 0.08 at the crest: a residual of 8e-8 m is
// an X right to 1e-6 m.
TEST(HardCase, D2_a_steep_crest_is_inverted_in_six_steps_where_a_fixed_point_takes_a_hundred) {
    const double a = 0.92;
    int evaluations = 0, most = 0, fixed = 0;
    double worst = 0;
    const auto field = [&](double X, double) {
        ++evaluations;
        return trochoid(a, X);
    };
    for (double X = -3.0; X < 3.0; X += 0.0137) {
        const double x = X - a * std::sin(X);
        evaluations = 0;
        const Answer answer = sea::surface_at({x, 0, 0}, {{1, 1}, 8e-8, {}}, field);
        most = std::max(most, evaluations);
        worst = std::max(worst, std::abs(answer.height_m - a * std::cos(X)));
        EXPECT_EQ(answer.flags & sea::answer_not_converged, 0u) << X;
        fixed = std::max(fixed, naive::fixed_point(field, x, 0, 8e-8, 10'000).steps);
    }
    EXPECT_LT(worst, 1e-6); // d eta/dX is below 1
    EXPECT_LE(most, 7);
    EXPECT_GT(fixed, 50);
    record("one wave of steepness 0.92, J down to 0.08", "evaluations for 1e-6 m", fixed, most);
}

// Folds included: nothing that is no number, and a residual below 1 mm or a flag.
TEST(HardCase, D2_a_million_points_of_a_folding_sea_are_numbers_and_solved_or_flagged) {
    const auto at = [](double X, double Y) {
        LagrangianPoint p = trochoid(0.7, X);
        const LagrangianPoint across = trochoid(0.6, 0.8 * X + 0.6 * Y + 1);
        p.height += across.height;
        p.displacement_x += 0.8 * across.displacement_x;
        p.displacement_y += 0.6 * across.displacement_x;
        p.slope_x += 0.8 * across.slope_x;
        p.slope_y += 0.6 * across.slope_x;
        p.strain_xx += 0.64 * across.strain_xx;
        p.strain_xy += 0.48 * across.strain_xx;
        p.strain_yy += 0.36 * across.strain_xx;
        return p;
    };
    std::mt19937 random(2);
    std::uniform_real_distribution<double> place(-100, 100);
    int unsolved = 0, lost = 0;
    for (int i = 0; i < 1'000'000; ++i) {
        const double x = place(random), y = place(random);
        sea::Vec2 from; // where what is there now was undisplaced
        const Answer answer = sea::surface_at({x, y, 0}, {{1, 1}, 1e-4, {}}, at, nullptr, &from);
        const LagrangianPoint there = at(from.x, from.y);
        const double missed_m =
            std::hypot(from.x + there.displacement_x - x, from.y + there.displacement_y - y);
        ASSERT_TRUE(std::isfinite(answer.height_m) && std::isfinite(answer.normal[2]));
        const std::uint32_t flagged = sea::answer_folded | sea::answer_not_converged;
        unsolved += (answer.flags & flagged) == 0 && !(missed_m < 1e-3 && answer.error_m < 1e-3);
        if (i % 100 == 0)
            lost += naive::fixed_point(at, x, y, 1e-3, 100).steps > 100;
    }
    EXPECT_EQ(unsolved, 0);
    EXPECT_GT(lost, 0);
    record("two waves of steepness 1.3 together", "share of points not solved, not flagged",
           lost / 1e4, unsolved / 1e6);
}

// Asked for at and beside the crest, where J is 5e-13 and a step of Newton 2e6 m. No step of ours is longer than points move
// sideways, which is 1 m here; the case allows a quarter of the wavelength, 1.6 m.
TEST(HardCase, D4_at_a_cusp_no_step_leaves_the_wave) {
    const auto field = [](double X, double) { return trochoid(1.0, X); };
    const double leap = std::abs(naive::newton_step_m(field, 1e-6, 1e-6));
    double farthest = 0, off = 0;
    const auto watched = [&](double X, double Y) {
        farthest = std::max(farthest, std::hypot(X, Y));
        return field(X, Y);
    };
    for (const double x : {0.0, 1e-9, 1e-6, -1e-6, 1e-4, 1e-3}) {
        const Answer answer = sea::surface_at({x, 0, 0}, {{1, 1}, 1e-6, {.reach_m = 1}}, watched);
        const double X = std::cbrt(6 * x); // x = X - sin X = X^3 / 6 near the crest
        off = std::max(off, std::abs(answer.height_m - std::cos(X)));
    }
    EXPECT_GT(leap, 1e3);
    EXPECT_LT(farthest, 1.6);
    EXPECT_LT(off, 0.01); // the case's centimetre
    record("one wave with J = 0 at its crest", "step of Newton, m", leap, farthest);
}

TEST(HardCase, D6_the_sum_of_displacements_is_inverted) {
    const auto cascade = [](double length_m, double steepness, unsigned seed) {
        return tests::random_cascade(length_m, 64, 6, 12, steepness, seed);
    };
    const std::vector<CascadeModes> cascades{cascade(200, 0.04, 1), cascade(37.3, 0.04, 2)};
    const DirectSum sum(tests::make_sea(cascades)), one(tests::make_sea({cascades[0]})),
        two(tests::make_sea({cascades[1]}));
    const auto moment = sum.at_time(0), first = one.at_time(0), second = two.at_time(0);
    const std::vector<naive::Field> fields{[&](double X, double Y) { return first.at(X, Y); },
                                           [&](double X, double Y) { return second.at(X, Y); }};
    double ours = 0, apart = 0;
    int points = 0;
    for (int i = 0; i < 200; ++i) {
        const double X = 13.7 * i - 900, Y = -7.1 * i;
        const LagrangianPoint p = moment.at(X, Y);
        if (sea::jacobian(p, {}) < 0.2)
            continue; // another sheet may stand higher
        const double x = X + p.displacement_x, y = Y + p.displacement_y;
        const Answer answer = sea::surface_at({x, y, 0}, {{1, 1}, 1e-8, {.reach_m = 5}}, moment);
        ours = std::max(ours, std::abs(answer.height_m - p.height));
        apart = std::max(apart, std::abs(naive::inverted_apart_m(fields, x, y) - p.height));
        ++points;
    }
    EXPECT_GT(points, 150);
    EXPECT_LT(ours, 1e-6);
    EXPECT_GT(apart, 1e-3);
    record("two cascades of rms slope 0.1", "largest error of a height, m", apart, ours);
}

// 1e-3 rad is the case's; the difference is taken between points of the displaced mesh.
TEST(HardCase, D7_the_normal_is_that_of_the_displaced_mesh) {
    const double a = 0.5, e = 1e-4;
    const auto field = [&](double X, double) { return trochoid(a, X); };
    double ours = 0, slopes = 0;
    for (double X = -3; X < 3; X += 0.01) { // J is 0.5 at the crest
        const LagrangianPoint p = trochoid(a, X), west = trochoid(a, X - e),
                              east = trochoid(a, X + e);
        const double rise = east.height - west.height;
        const double run = 2 * e + east.displacement_x - west.displacement_x;
        const double truth = std::atan2(rise, run);
        const Answer answer =
            sea::surface_at({X + p.displacement_x, 0, 0}, {{1, 1}, 1e-10, {}}, field);
        ours = std::max(ours, std::abs(std::atan2(-answer.normal[0], answer.normal[2]) - truth));
        slopes = std::max(slopes, std::abs(naive::angle_of_slope_rad(p) - truth));
    }
    EXPECT_LT(ours, 1e-3);
    EXPECT_GT(slopes, 1e-3);
    record("one wave of steepness 0.5", "largest error of the normal, rad", slopes, ours);
}

} // namespace
} // namespace seaway::hard_cases
