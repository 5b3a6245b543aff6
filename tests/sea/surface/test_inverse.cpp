// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include <gtest/gtest.h>

#include "sea/surface/inverse.h"
#include "sea/waves/reference.h"
#include "tests/support/explicit_sea.h"

namespace seaway::sea {
namespace {

/// One wave of wavenumber 1 and amplitude a along x at t = 0: eta = a cos X, D = -a sin X.
struct Trochoid {
    DirectSum sum;
    DirectSum::Moment moment;
    explicit Trochoid(double amplitude_m) : sum(one_wave(amplitude_m)), moment(sum.at_time(0)) {}

    static RealizationPtr one_wave(double amplitude_m) {
        CascadeModes modes = tests::calm_cascade(10 * two_pi, 64);
        tests::add_wave(modes, 10, 0, amplitude_m, 0.0);
        return tests::make_sea({modes});
    }
    Answer answer(double x_m, double tolerance_m) const {
        return surface_at({x_m, 0.0, 0}, {{1, 1}, tolerance_m, {.reach_m = 2.0}}, moment);
    }
};

// D2: a plain fixed point needs 87 steps at J = 0.1; Newton solves a steep sea to rounding.
TEST(Inverse, d2_steep_sea_is_inverted_to_a_micrometre) {
    const RealizationPtr sea = tests::make_sea({tests::random_cascade(120.0, 64, 12, 60, 0.05, 7)});
    const DirectSum sum(sea);
    const DirectSum::Moment moment = sum.at_time(3'000'000);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> place(-500.0, 500.0);
    double jacobian_least = 1.0;
    for (int i = 0; i < 2000; ++i) {
        const double X = place(random);
        const double Y = place(random);
        const LagrangianPoint p = moment.at(X, Y);
        const double j = jacobian(p, sea->choppiness);
        jacobian_least = std::min(jacobian_least, j);
        if (j < 0.08)
            continue; // close to a fold a second sheet may stand higher
        const QueryPoint point{X + p.displacement_x, Y + p.displacement_y, 3'000'000};
        const Answer answer = surface_at(point, {sea->choppiness, 1e-7, 5.0}, moment);
        // Slopes reach 1, so 1e-7 m sideways is 1e-7 m of height; rounding is far below.
        EXPECT_NEAR(answer.height_m, p.height, 1e-6);
        EXPECT_EQ(answer.flags & answer_not_converged, 0u);
    }
    EXPECT_LT(jacobian_least, 0.35) << "the sea of this test must be steep";
}

// D3: a solver that returns whichever root it meets flickers between sheets.
TEST(Inverse, d3_folded_wave_answers_with_its_highest_sheet) {
    const Trochoid wave{1.2};
    for (double x = -0.06; x <= 0.06; x += 0.005) {
        double highest = -10.0; // brute force: every X that lands on x
        for (double X = -2.0; X < 2.0; X += 1e-5) {
            const double before = X - 1.2 * std::sin(X) - x;
            const double after = X + 1e-5 - 1.2 * std::sin(X + 1e-5) - x;
            if ((before > 0) != (after > 0))
                highest = std::max(highest, 1.2 * std::cos(X));
        }
        const Answer answer = wave.answer(x, 1e-9);
        EXPECT_NEAR(answer.height_m, highest, 3e-5) << "x = " << x; // the scan's step
        EXPECT_TRUE(answer.flags & answer_folded);
        // The crest that is folded over lies upside down; its normal looks up all the same.
        EXPECT_GE(answer.normal[2], 0.0) << "x = " << x;
        EXPECT_NEAR(std::hypot(answer.normal[0], answer.normal[2]), 1.0, 1e-12);
    }
    const Answer beside = wave.answer(1.0, 1e-9);
    EXPECT_EQ(beside.flags, 0u);
}

// D4: at J = 0 a Newton step of residual / J goes to another ocean.
TEST(Inverse, d4_cusp_gives_a_finite_height_within_a_centimetre) {
    const Trochoid wave{1.0}; // J = 0 at the crest
    const Answer answer = wave.answer(0.0, 1e-6);
    EXPECT_NEAR(answer.height_m, 1.0, 0.01);
    const Answer close = wave.answer(1e-6, 1e-6);
    EXPECT_NEAR(close.height_m, 1.0, 0.01);
}

// D5: with the sign of D turned crests are round and troughs sharp.
TEST(Inverse, d5_crests_are_sharper_than_troughs) {
    const Trochoid wave{0.5};
    const auto height = [&](double x) { return wave.answer(x, 1e-12).height_m; };
    const double e = 0.05;
    const double crest = 2 * height(0) - height(e) - height(-e);
    const double trough = height(pi + e) + height(pi - e) - 2 * height(pi);
    EXPECT_GT(crest, 2.0 * trough);
}

// D7: slopes alone, without 1 + Dxx, are up to 1.2 degrees wrong at choppiness 1.
TEST(Inverse, d7_normal_is_that_of_the_displaced_surface) {
    const RealizationPtr sea =
        tests::make_sea({tests::random_cascade(120.0, 64, 10, 40, 0.03, 3)}, {1.1, 0.8});
    const DirectSum sum(sea);
    const DirectSum::Moment now = sum.at_time(0);
    const InverseOptions options{sea->choppiness, 1e-10, 5.0};
    const auto height = [&](double x, double y) {
        return surface_at({x, y, 0}, options, now).height_m;
    };
    for (int i = 0; i < 100; ++i) {
        const double x = 1.7 * i;
        const double y = -0.9 * i;
        const Answer answer = surface_at({x, y, 0}, options, now);
        const double e = 1e-3;
        const double sx = (height(x + e, y) - height(x - e, y)) / (2 * e);
        const double sy = (height(x, y + e) - height(x, y - e)) / (2 * e);
        const double length = std::sqrt(1 + sx * sx + sy * sy);
        // Central differences of a surface with curvature up to 1/m: 1e-6 of the slope.
        EXPECT_NEAR(answer.normal[0], -sx / length, 1e-5);
        EXPECT_NEAR(answer.normal[1], -sy / length, 1e-5);
        EXPECT_NEAR(answer.normal[2], 1 / length, 1e-5);
    }
}

// What a metre sideways costs of the height: the tangent of the tilt, not its sine.
TEST(Inverse, the_slope_of_an_answer_is_the_tangent_of_its_tilt) {
    for (const double slope : {0.0, 0.1, 1.0, 3.0})
        for (const double direction_rad : {0.0, 2.0, -1.0}) {
            Answer answer;
            answer.normal[2] = 1.0 / std::hypot(1.0, slope);
            answer.normal[0] = -slope * std::cos(direction_rad) * answer.normal[2];
            answer.normal[1] = -slope * std::sin(direction_rad) * answer.normal[2];
            EXPECT_NEAR(surface_slope(answer), slope, 1e-12);
        }
}

// G9: a loop that waits for |residual| < tolerance never ends on NaN. The case asks for a microsecond; no clock is asserted
// here, but that the waves are not looked at.
TEST(Inverse, g9_point_that_is_not_a_number_is_refused_by_flag) {
    const Trochoid wave{0.5};
    int looked = 0;
    const auto field = [&](double x_m, double y_m) {
        ++looked;
        return wave.moment.at(x_m, y_m);
    };
    const auto answer_at = [&](double x_m, double y_m) {
        return surface_at({x_m, y_m, 0}, {{1, 1}, 1e-6, {.reach_m = 2.0}}, LagrangianField(field));
    };
    EXPECT_EQ(answer_at(0.3, 0.0).flags, 0u);
    EXPECT_GT(std::exchange(looked, 0), 0);
    const double infinity = std::numeric_limits<double>::infinity();
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), infinity, -infinity})
        for (const auto& [x_m, y_m] : {std::pair(bad, 0.0), {0.0, bad}, {bad, bad}}) {
            const Answer answer = answer_at(x_m, y_m);
            EXPECT_EQ(answer.flags, answer_invalid);
            EXPECT_TRUE(std::isnan(answer.height_m));
        }
    EXPECT_EQ(looked, 0);
    EXPECT_EQ(wave.answer(infinity, 1e-6).flags, answer_invalid) << "the sum's own way in";
}

TEST(Inverse, velocity_is_the_orbital_velocity_of_the_particle) {
    // A trochoid's particles move on circles: forward at crests with a w.
    sea::CascadeModes modes = tests::calm_cascade(100.0, 64);
    tests::add_wave(modes, 2, 0, 1.0, 0.0);
    const RealizationPtr sea = tests::make_sea({modes});
    const DirectSum sum(sea);
    const double omega = std::sqrt(gravity_default_mps2 * two_pi * 2 / 100.0);
    const Answer crest = surface_at({0, 0, 0}, {{1, 1}, 1e-10, 2.0}, sum.at_time(0));
    EXPECT_NEAR(crest.velocity_mps[0], omega, 1e-9);
    EXPECT_NEAR(crest.velocity_mps[2], 0.0, 1e-9);
}

} // namespace
} // namespace seaway::sea
