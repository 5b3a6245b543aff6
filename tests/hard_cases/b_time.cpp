// SPDX-License-Identifier: Apache-2.0
// Hard cases of time beside clocks and phases as they are first written. The criteria are held for whole
// seas in tests/sea/waves.
#include <algorithm>
#include <cmath>
#include <complex>

#include <gtest/gtest.h>

#include "sea/basics/time.h"
#include "tests/hard_cases/maps.h"
#include "tests/hard_cases/record.h"
#include "tests/naive/time.h"
#include "tests/sea/sea_fixture.h"

namespace seaway::hard_cases {
namespace {

constexpr long double two_pi = 6.283185307179586476925286766559005768L;

double wrapped(long double angle) {
    return static_cast<double>(std::remainder(angle, two_pi));
}

// A frequency is rounded once, to 2^-65 turns/us: 1.8e-7 rad after 1e6 s and 1.7e-4 after 1e9 s. Against
// the frequency that was asked for, in long double (64 bits: 1e-10 rad after 1e9 s at 17 rad/s).
TEST(HardCase, B3_a_phase_is_right_after_a_million_and_a_billion_seconds) {
    double ours[2] = {}, floats[2] = {};
    const long long times_s[2] = {1'000'000, 1'000'000'000};
    for (int t = 0; t < 2; ++t)
        for (double omega = 0.3; omega <= 17; omega += 0.0713) {
            const long double truth = static_cast<long double>(omega) * times_s[t];
            const double fixed =
                sea::phase_rad(sea::rate_from_omega(omega), times_s[t] * 1'000'000);
            ours[t] = std::max(ours[t], std::abs(wrapped(fixed - truth)));
            const float naive = naive::phase_rad(omega, static_cast<double>(times_s[t]));
            floats[t] = std::max(floats[t], std::abs(wrapped(naive - truth)));
        }
    EXPECT_LT(ours[0], 2e-6); // rates are doubles before they are rounded: 1e-16 of 1.7e7 rad
    EXPECT_LT(ours[1], 1e-3);
    EXPECT_GT(floats[0], 0.5);
    record("waves of 0.3 to 17 rad/s after 1e6 s", "largest error of a phase, rad", floats[0],
           ours[0]);
}

// 1e-5 of the energy is the case's. A wave of a whole number of steps has half its amplitude squared as the mean square of
// its map, at any time.
TEST(HardCase, B5_a_wave_keeps_its_energy_over_ten_million_frames) {
    constexpr int size = 32, frames = 10'000'000;
    const double amplitude_m = 2.0;
    sea::CascadeModes modes = sea::random_modes(size, 0, 1, 200.0);
    put_wave(modes, 3, 2, 0.5 * amplitude_m);
    double ours = 0;
    for (int part = 0; part <= 10; ++part) {
        const sea::TimeUs t_us = frames / 10 * part * 16'667LL;
        const double height_m = rms(maps(modes, {sea::Field::height}, t_us));
        const double energy = 2 * height_m * height_m / (amplitude_m * amplitude_m);
        ours = std::max(ours, std::abs(energy - 1));
    }
    naive::Rotation rotation(1.234567, 1.0 / 60);
    for (int frame = 0; frame < frames; ++frame)
        rotation.advance();
    const double drifted = std::abs(std::norm(rotation.value()) - 1);
    EXPECT_LT(ours, 1e-5);
    EXPECT_GT(drifted, 1e-5);
    record("1e7 frames at 60 Hz", "energy gained or lost, of itself", drifted, ours);
}

TEST(HardCase, B2_five_seconds_before_the_start_are_five_seconds_before) {
    const double omega = 1.3;
    const sea::Rate rate = sea::rate_from_omega(omega);
    double ours = 0, without_sign = 0;
    for (int frame = -300; frame < 0; ++frame) {
        const double truth = std::cos(omega * frame / 60.0);
        ours = std::max(
            ours,
            std::abs(std::cos(sea::phase_rad(rate, sea::us_from_seconds(frame / 60.0))) - truth));
        without_sign =
            std::max(without_sign,
                     std::abs(std::cos(omega * naive::time_of_frame(frame, 1 / 60.0)) - truth));
    }
    EXPECT_LT(ours, 1e-5); // a microsecond of omega
    EXPECT_GT(without_sign, 0.1);
    record("a wave of 1 m, 300 frames before the start", "largest error of its height, m",
           without_sign, ours);
}

// Velocities belong to a time, not to a pair of frames.
TEST(HardCase, B6_a_hitch_of_three_seconds_throws_nothing_into_the_air) {
    const sea::DirectSum sum(testing::realized(testing::swell_sea(2.0, 8.0), {{400.0, 64}}));
    const sea::TimeUs hitch = 3'000'000, frame = 16'667, delta = 1000;
    double ours = 0, by_frames = 0;
    for (int i = 0; i < 40; ++i) {
        const double x = 9.7 * i, y = 3.1 * i;
        const auto height = [&](sea::TimeUs t) { return sum.at(x, y, t).height; };
        const double truth =
            (height(hitch + delta) - height(hitch - delta)) / sea::seconds_from_us(2 * delta);
        ours = std::max(ours, std::abs(sum.at(x, y, hitch).height_rate - truth));
        by_frames =
            std::max(by_frames, std::abs(naive::velocity_by_frames(height(0), height(hitch),
                                                                   sea::seconds_from_us(frame)) -
                                         truth));
    }
    EXPECT_LT(ours, 1e-5); // central differences over 2 ms: omega^3 dt^2 / 6
    EXPECT_GT(by_frames, 10);
    record("swell of Hs 2 m after a hitch of 3 s", "largest error of the vertical velocity, m/s",
           by_frames, ours);
}

TEST(HardCase, B7_no_wave_of_a_loop_stands_still) {
    sea::SeaState state = testing::swell_sea(2.0, 16.0);
    const sea::RealizationPtr free = testing::realized(state, {{2000.0, 64}});
    state.loop_period_s = 15.0;
    const sea::RealizationPtr looped = testing::realized(state, {{2000.0, 64}});
    double all = 0, ours = 0, rounded_down = 0;
    for (std::size_t i = 0; i < free->cascades[0].h0.size(); ++i) {
        const double energy = std::norm(free->cascades[0].h0[i]);
        const double omega = sea::omega_from_rate(free->cascades[0].rate[i]);
        all += energy;
        ours += looped->cascades[0].rate[i] == 0 ? energy : 0;
        rounded_down += naive::looped_omega(omega, 15.0) == 0 ? energy : 0;
    }
    EXPECT_EQ(ours, 0);
    EXPECT_GT(rounded_down / all, 0.1);
    record("swell of 16 s in a loop of 15 s", "share of the energy that stands still",
           rounded_down / all, ours / all);
}

TEST(HardCase, B9_time_since_1970_moves_every_frame) {
    const double now_s = 1.7e9;
    int moved = 0, moved_naive = 0;
    for (int frame = 0; frame < 600; ++frame) {
        const double t = now_s + frame / 60.0, next = now_s + (frame + 1) / 60.0;
        moved += sea::us_from_seconds(next) > sea::us_from_seconds(t);
        moved_naive += naive::seconds_since_epoch(next) > naive::seconds_since_epoch(t);
    }
    EXPECT_EQ(moved, 600);
    EXPECT_LT(moved_naive, 2);
    record("600 frames from 1.7e9 s on", "frames in which time moves", moved_naive, moved);
}

} // namespace
} // namespace seaway::hard_cases
