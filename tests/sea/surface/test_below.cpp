// SPDX-License-Identifier: Apache-2.0
// The water below the surface: Airy's waves as handbooks have them, and the laws that any such flow obeys.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "sea/surface/below.h"
#include "tests/sea/sea_fixture.h"
#include "tests/support/airy_waves.h"

namespace seaway::sea {
namespace {

using seaway::testing::one_wave;
using seaway::testing::realized;
using seaway::testing::three_cascades;
using seaway::testing::windy_sea;

/// Without surface tension.
RealizationPtr airy_sea(const tests::AiryWave& wave, double choppiness) {
    auto sea = std::make_shared<Realization>(
        *one_wave(5 * wave.length_m, 16, 3, 4, wave.amplitude_m(), 0.0, wave.depth_m));
    sea->choppiness = {choppiness, choppiness};
    for (CascadeModes& modes : sea->cascades)
        for (Rate& rate : modes.rate)
            if (rate != 0)
                rate = rate_from_omega(two_pi / wave.period_s);
    return sea;
}

/// A twentieth of the height, so that folds and the second order are far; linear theory is linear.
tests::AiryWave flat(tests::AiryWave wave) {
    wave.height_m *= 0.05;
    return wave;
}

TEST(Below, ten_airy_waves_move_water_and_press_it_as_handbooks_say_at_every_depth) {
    for (const tests::AiryWave& steep : tests::airy_waves) {
        const tests::AiryWave wave = flat(steep);
        const double k = wave.k_radpm, d = wave.depth_m, a = wave.amplitude_m();
        const double omega = two_pi / wave.period_s;
        const DirectSum sum(airy_sea(wave, 0));
        for (const double theta : {0.0, 0.9, 2.5, -1.4})
            for (const double share : {0.0, 0.1, 0.5, 0.9, 1.0}) {
                const double x = tests::airy_east * theta / k, y = tests::airy_north * theta / k;
                const double eta = a * std::cos(theta);
                const double z = eta - share * (d + eta); // share of the column below the surface
                WaterBelow water;
                const Answer answer =
                    water_at({x, y, 0}, z, {{0, 0}, 1e-10, {}}, sum.at_time(0), water);
                const double still = -share * d; // Wheeler: the column's share stays
                const double along = a * omega * std::cosh(k * (still + d)) / std::sinh(k * d);
                const double up = a * omega * std::sinh(k * (still + d)) / std::sinh(k * d);
                const double pressure = 9.81 * a * std::cosh(k * (still + d)) / std::cosh(k * d);
                // k of the table and of the lattice agree to 1e-13; frequencies are rounded to 2^-64 turns a us.
                EXPECT_NEAR(water.velocity_mps[0], 0.6 * along * std::cos(theta), 1e-9 * a);
                EXPECT_NEAR(water.velocity_mps[1], 0.8 * along * std::cos(theta), 1e-9 * a);
                EXPECT_NEAR(water.velocity_mps[2], up * std::sin(theta), 1e-9 * a);
                EXPECT_NEAR(water.pressure_m2ps2, pressure * std::cos(theta), 1e-8 * a);
                EXPECT_NEAR(answer.height_m, eta, 1e-9 * a);
                EXPECT_EQ(answer.flags & answer_dry, 0u) << share;
            }
    }
}

TEST(Below, at_the_surface_it_is_the_answer_of_the_surface_and_the_pressure_of_what_stands_above) {
    SeaState state = windy_sea();
    state.surface_tension = false;
    const RealizationPtr sea = realized(state, three_cascades);
    const DirectSum sum(sea);
    const DirectSum::Moment moment = sum.at_time(12'345'678);
    const InverseOptions options{sea->choppiness, 1e-10, {.reach_m = 10}};
    for (int i = 0; i < 50; ++i) {
        const QueryPoint point{13.7 * i, -7.1 * i, 12'345'678};
        const Answer surface = surface_at(point, options, moment);
        WaterBelow water;
        const Answer answer = water_at(point, surface.height_m, options, moment, water);
        EXPECT_EQ(answer.flags & answer_dry, 0u);
        EXPECT_EQ(answer.height_m, surface.height_m);
        for (int axis = 0; axis < 3; ++axis) // the same sums in another order of products
            EXPECT_NEAR(water.velocity_mps[axis], surface.velocity_mps[axis], 1e-12);
        // Total pressure over density, -g z + p: that of the air, which is none. Rates are rounded to 2^-64 turns a us.
        EXPECT_NEAR(water.pressure_m2ps2, gravity_default_mps2 * surface.height_m, 1e-9);
    }
}

TEST(Below, flow_keeps_its_volume_does_not_turn_and_is_driven_by_its_pressure) {
    SeaState state = windy_sea();
    state.depth_m = 9.0; // the floor is felt
    const DirectSum sum(realized(state, three_cascades));
    constexpr TimeUs now_us = 60'000'000;
    constexpr double h = 1e-3;
    constexpr TimeUs h_us = 1000;
    const DirectSum::Moment now = sum.at_time(now_us);
    const DirectSum::Moment before = sum.at_time(now_us - h_us), after = sum.at_time(now_us + h_us);
    for (int i = 0; i < 12; ++i) {
        const double x = 31.3 * i, y = 17.9 * i, z = -0.3 - 0.7 * i;
        const auto slope = [&](int axis, int of) { // d velocity[of] / d axis; of 3: the pressure
            const double dx = axis == 0 ? h : 0, dy = axis == 1 ? h : 0, dz = axis == 2 ? h : 0;
            const WaterMotion low = now.motion(x - dx, y - dy, z - dz);
            const WaterMotion high = now.motion(x + dx, y + dy, z + dz);
            const double step = of == 3 ? high.pressure_m2ps2 - low.pressure_m2ps2
                                        : high.velocity_mps[of] - low.velocity_mps[of];
            return step / (2 * h);
        };
        // Central differences: h^2 / 6 of a third derivative, below k^3 = 30 at these depths, of 0.1 m/s.
        constexpr double near = 2e-6;
        EXPECT_NEAR(slope(0, 0) + slope(1, 1) + slope(2, 2), 0, near) << z;
        EXPECT_NEAR(slope(1, 0) - slope(0, 1), 0, near) << z;
        EXPECT_NEAR(slope(2, 0) - slope(0, 2), 0, near) << z;
        EXPECT_NEAR(slope(2, 1) - slope(1, 2), 0, near) << z;
        const WaterMotion earlier = before.motion(x, y, z), later = after.motion(x, y, z);
        for (int axis = 0; axis < 3; ++axis) {
            const double gained =
                (later.velocity_mps[axis] - earlier.velocity_mps[axis]) / (2e-6 * h_us);
            EXPECT_NEAR(gained, -slope(axis, 3), 10 * near) << axis << " at " << z;
        }
    }
    for (int i = 0; i < 12; ++i)
        EXPECT_NEAR(now.motion(3.0 * i, 5.0 * i, -9.0).velocity_mps[2], 0, 1e-15)
            << "nothing goes through the floor";
}

TEST(Below, where_there_is_no_water_it_is_still_and_the_answer_says_so) {
    const DirectSum sum(airy_sea(tests::airy_waves[5], 1)); // 20 m deep, 3 m high
    const DirectSum::Moment now = sum.at_time(0);
    const InverseOptions options{{1, 1}, 1e-9, {.reach_m = 3}};
    for (const double z : {1.6, 1e9, -20.001, -1e9}) {
        WaterBelow water{{1, 1, 1}, 1};
        const Answer answer = water_at({0, 0, 0}, z, options, now, water);
        EXPECT_EQ(answer.flags & answer_dry, unsigned{answer_dry}) << z;
        EXPECT_NEAR(answer.height_m, 1.5, 1e-9) << "the surface is known all the same";
        for (const double velocity : water.velocity_mps)
            EXPECT_EQ(velocity, 0);
        EXPECT_EQ(water.pressure_m2ps2, 0);
    }
    constexpr double infinite = std::numeric_limits<double>::infinity();
    for (const double z : {std::nan(""), infinite, -infinite}) {
        WaterBelow water;
        EXPECT_TRUE(water_at({0, 0, 0}, z, options, now, water).flags & answer_invalid);
        EXPECT_TRUE(std::isnan(water.velocity_mps[0]) && std::isnan(water.pressure_m2ps2));
    }
    EXPECT_FALSE(still_z_m(-5, -5, 5)) << "a trough down to the floor leaves nothing";
    EXPECT_EQ(still_z_m(-4, 1, 9), -4.5) << "a column of 10 m, of which 5 are below";
    EXPECT_EQ(still_z_m(-4, 1, infinite), -5);
}

TEST(Below, is_finite_in_the_deepest_and_the_shallowest_water_that_a_scene_may_have) {
    for (const double depth : {0.01, 0.1, 1.0, 1e4, deep_water_m}) {
        SeaState state = windy_sea();
        state.depth_m = depth;
        const DirectSum sum(realized(state, three_cascades));
        const DirectSum::Moment now = sum.at_time(5'000'000);
        const double floor = std::isinf(depth) ? -1e9 : -depth;
        for (const double z : {0.0, -1e-12, 1e-3 * floor, 0.5 * floor, floor}) {
            const WaterMotion motion = now.motion(100, -50, z);
            for (const double velocity : motion.velocity_mps)
                EXPECT_LT(std::abs(velocity), 100) << depth << " at " << z;
            EXPECT_LT(std::abs(motion.pressure_m2ps2), 1000) << depth << " at " << z;
        }
        if (depth >= 1e4) {
            EXPECT_NEAR(now.motion(0, 0, floor).velocity_mps[0], 0, 1e-30)
                << "no wave of this sea reaches down there";
        }
    }
}

TEST(SomeCascades, add_up_to_the_whole_and_the_others_are_as_if_they_were_not) {
    const RealizationPtr sea = realized(windy_sea(), three_cascades);
    const DirectSum sum(sea);
    constexpr TimeUs now_us = 77'000'000;
    const LagrangianPoint whole = sum.at(10, 20, now_us);
    LagrangianPoint added;
    double pressure = 0;
    for (std::uint32_t c = 0; c < 3; ++c) {
        const DirectSum::Moment one = sum.at_time(now_us, 1u << c);
        const LagrangianPoint part = one.at(10, 20);
        added.height += part.height;
        added.strain_xy += part.strain_xy;
        pressure += one.motion(10, 20, -2).pressure_m2ps2;
        for (int other = 0; other < 3; ++other)
            EXPECT_EQ(one.patch_scale(other).displacement_m > 0, other == static_cast<int>(c));
        auto alone = std::make_shared<Realization>(*sea);
        for (int other = 2; other >= 0; --other)
            if (other != static_cast<int>(c))
                alone->cascades.erase(alone->cascades.begin() + other);
        EXPECT_EQ(DirectSum(alone).at(10, 20, now_us).height, part.height);
    }
    EXPECT_NEAR(added.height, whole.height, 1e-13);
    EXPECT_NEAR(added.strain_xy, whole.strain_xy, 1e-13);
    EXPECT_NEAR(pressure, sum.at_time(now_us).motion(10, 20, -2).pressure_m2ps2, 1e-12);
}

} // namespace
} // namespace seaway::sea
