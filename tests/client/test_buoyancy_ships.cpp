// SPDX-License-Identifier: Apache-2.0
// The freighter of examples/, as a ship is known to move.
#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include <gtest/gtest.h>

#include "examples/freighter.h"
#include "tests/client/floating.h"

namespace seaway::tests {
namespace {

constexpr double ship_step_s = 0.1; // that of examples/ship.cpp

struct Ship : Floating {
    Freighter freighter;
    Ship() {
        hull = freighter.hull();
        body.position_m[2] = Freighter::afloat_m;
    }
};

TEST(BuoyancyShips, a_freighter_floats_upright_on_an_even_keel_at_its_draught) {
    Ship ship;
    for (int i = 0; i < 1800; ++i)
        ASSERT_EQ(ship.ride(still_water, 0, ship_step_s), SEAWAY_OK);
    EXPECT_LT(ship.lean_deg(), 0.01);
    EXPECT_NEAR(ship.body.position_m[2], Freighter::afloat_m, 0.001);
}

TEST(BuoyancyShips, a_freighter_that_rolls_loses_some_of_it_with_each_swing) {
    Ship ship;
    ship.roll_to(10);
    std::vector<double> peaks_deg{10};
    double before_deg = 10, last_deg = 10;
    for (int i = 0; peaks_deg.size() < 5 && i < 1800; ++i) {
        ASSERT_EQ(ship.ride(still_water, 0, ship_step_s), SEAWAY_OK);
        const double now_deg = ship.roll_deg();
        if ((last_deg - before_deg) * (now_deg - last_deg) < 0)
            peaks_deg.push_back(std::abs(last_deg));
        before_deg = last_deg;
        last_deg = now_deg;
    }
    ASSERT_EQ(peaks_deg.size(), 5u); // it swings
    const double ratio = std::log(peaks_deg[0] / peaks_deg[4]) / (4 * M_PI);
    // Ships without keels have some hundredths to 0.2 of critical damping (Himeno 1981).
    EXPECT_GT(ratio, 0.03);
    EXPECT_LT(ratio, 0.2);
}

// Naive: drag acts on all of the flow. What slides along the sides would stop a ship within its own length.
TEST(BuoyancyShips, a_freighter_whose_engine_stops_coasts_on) {
    Ship ship;
    ship.body.velocity_mps[0] = 6;
    for (int i = 0; i < 100; ++i)
        ASSERT_EQ(ship.ride(still_water, 0, ship_step_s), SEAWAY_OK);
    // Real ones lose less. It makes waves with its bow alone, and has not got half of its length further than that takes.
    EXPECT_GT(ship.body.velocity_mps[0], 4);
    EXPECT_LT(ship.body.velocity_mps[0], 6);
}

/// A swell from abeam, 0.1 m high, as a sine.
seaway_answer swell(double period_s, const seaway_point& at) {
    const double omega = 2 * M_PI / period_s, k = omega * omega / SEAWAY_GRAVITY_MPS2;
    const double phase = k * at.y_m - omega * 1e-6 * static_cast<double>(at.time_us);
    const double slope = -0.1 * k * std::sin(phase), length = std::hypot(1, slope);
    return {0.1 * std::cos(phase),
            {0, -slope / length, 1 / length},
            {0, 0.1 * omega * std::cos(phase), 0.1 * omega * std::sin(phase)},
            0,
            0,
            0};
}

// Naive: added mass resists and is not pushed: the ship goes sideways at half of the water's speed, and what then streams past below
// rolled it by 2.4 slopes.
TEST(BuoyancyShips,
     in_a_swell_from_abeam_that_is_long_it_rolls_with_the_slope_and_goes_with_the_water) {
    for (const double period_s : {60.0, 100.0}) {
        Ship ship;
        const double omega = 2 * M_PI / period_s, k = omega * omega / SEAWAY_GRAVITY_MPS2;
        std::complex<double> roll = 0, sway = 0;
        const int steps = static_cast<int>(4 * period_s / ship_step_s);
        for (int i = -steps; i < steps;
             ++i) { // four periods until what it began with has died away
            if (i >= 0) {
                const auto turned =
                    std::polar(2.0 / steps, omega * i * ship_step_s - k * ship.body.position_m[1]);
                roll += turned * ship.roll_deg() * M_PI / 180.0;
                sway += turned * ship.body.velocity_mps[1];
            }
            ASSERT_EQ(ship.ride([&](const seaway_point& at) { return swell(period_s, at); },
                                i * ship_step_s, ship_step_s),
                      SEAWAY_OK);
        }
        // Of an oscillator of 20 s: 1.12 and 1.04 slopes, and the damping's part of it.
        EXPECT_NEAR(std::abs(roll) / (0.1 * k), 1 / (1 - std::pow(20 / period_s, 2)), 0.06)
            << period_s;
        EXPECT_NEAR(std::abs(sway) / (0.1 * omega), 1, 0.03)
            << period_s; // the wave over its draught
    }
}

// Naive: one divisor of the drag's torque for all axes, by the least inertia: that of roll slowed what stops a yaw.
TEST(BuoyancyShips, a_yaw_dies_away_as_fast_in_long_steps_as_in_short_ones) {
    const auto half_s = [](double of_step_s) {
        Ship ship;
        ship.hull.quadratic_drag = 0;
        ship.body.angular_velocity_radps[2] = 0.01;
        double last_radps = 0.01;
        for (int i = 0; i < static_cast<int>(60 / of_step_s); ++i) {
            EXPECT_EQ(ship.ride(still_water, 0, of_step_s), SEAWAY_OK);
            const double now_radps = ship.body.angular_velocity_radps[2];
            if (now_radps < 0.005)
                return of_step_s * (i + (last_radps - 0.005) / (last_radps - now_radps));
            last_radps = now_radps;
        }
        return HUGE_VAL;
    };
    const double limit_s = half_s(1.0 / 2000);
    // Of backward Euler: the step over twice the time in which it falls to 1/e, 2 %.
    EXPECT_NEAR(half_s(0.1), limit_s, 0.02 * limit_s);
    EXPECT_NEAR(half_s(1.0), limit_s, 0.1 * limit_s);
}

} // namespace
} // namespace seaway::tests
