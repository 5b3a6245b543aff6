// SPDX-License-Identifier: Apache-2.0
// Hard cases G1, G3, G5 .. G7: queries between grid points and keyframes, anywhere.
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "sea/surface/budget/error_budget.h"
#include "sea/surface/height_map.h"
#include "sea/surface/surface.h"
#include "tests/hard_cases/maps.h"
#include "tests/hard_cases/record.h"
#include "tests/naive/surface.h"
#include "tests/naive/time.h"
#include "tests/support/explicit_sea.h"

namespace seaway::hard_cases {
namespace {

using sea::CascadeModes;
using sea::DirectSum;
using sea::RealizationPtr;
using sea::Surface;
using sea::TimeUs;

constexpr TimeUs interval_us = 200'000;

/// Every cascade, or the first `count`.
Surface surface_of(const RealizationPtr& sea, int count) {
    std::vector<sea::SplinePair> pairs;
    for (int c = 0; c < count; ++c)
        pairs.push_back(
            {std::make_shared<sea::SplineMap>(*tests::exact_keyframe(sea, c, 0)),
             std::make_shared<sea::SplineMap>(*tests::exact_keyframe(sea, c, interval_us))});
    return Surface(std::move(pairs), sea->choppiness, {.reach_m = 5.0}, {});
}

RealizationPtr two_cascades() {
    return tests::make_sea({tests::random_cascade(200.0, 64, 8, 30, 0.02, 1),
                            tests::random_cascade(37.3, 64, 10, 30, 0.02, 2)});
}

// 2e-5 m is the case's, of the waves themselves; naive: a float resolves 1 m there.
TEST(HardCase, G1_ten_thousand_kilometres_out_the_sum_is_as_good) {
    const RealizationPtr sea = two_cascades();
    const DirectSum sum(sea);
    const auto now = sum.at_time(0);
    double ours = 0, floats = 0;
    for (int i = 0; i < 100; ++i) {
        const double x = 1e7 + 0.317 * i;
        // In long double the tile is taken off exactly.
        long double truth = 0;
        for (const CascadeModes& modes : sea->cascades)
            for (std::size_t m = 0; m < modes.h0.size(); ++m)
                if (modes.h0[m] != 0.0) {
                    const int nx = sea::signed_index(static_cast<int>(m % 64), 64);
                    const long double turns =
                        nx * (static_cast<long double>(x) / modes.spec.length_m);
                    const double angle = static_cast<double>((turns - std::floor(turns)) * 2.0L *
                                                             std::numbers::pi_v<long double>);
                    truth += 2 * (modes.h0[m] * std::polar(1.0, angle)).real();
                }
        ours = std::max(ours, std::abs(static_cast<double>(now.at(x, 0).height - truth)));
        floats = std::max(
            floats, std::abs(static_cast<double>(now.at(naive::in_a_float(x), 0).height - truth)));
    }
    EXPECT_LT(ours, 2e-5);
    EXPECT_GT(floats, 2e-5);
    record("two cascades at x = 1e7 m", "largest error of a height, m", floats, ours);
}

// The tolerance is the spline's and the keyframes' own: 1e-3 m near the origin as well (test_surface).
TEST(HardCase, G3_tiles_of_any_lengths_are_wrapped_each_by_itself) {
    const RealizationPtr sea = two_cascades();
    const Surface surface = surface_of(sea, 2);
    const DirectSum sum(sea);
    const auto now = sum.at_time(0);
    std::mt19937 random(6);
    std::uniform_real_distribution<double> place(-1e7, 1e7);
    double ours = 0, once = 0;
    for (int i = 0; i < 500; ++i) {
        const double x = place(random), y = place(random);
        const double truth = now.at(x, y).height;
        ours = std::max(ours, std::abs(surface.at(x, y, 0).height - truth));
        once = std::max(
            once, std::abs(now.at(naive::wrapped_once(x, 200), naive::wrapped_once(y, 200)).height -
                           truth));
    }
    EXPECT_LT(ours, 1e-3);
    EXPECT_GT(once, 0.01);
    record("tiles of 200 and 37.3 m, |x| up to 1e7 m", "largest error of a height, m", once, ours);
}

/// One wave of angular frequency w on a small tile, keyframes 0.1 s apart.
struct OneWave {
    explicit OneWave(int n)
        : sea(tests::make_sea({modes(n)})), omega(sea::omega_from_rate(rate(n))) {
        for (int i = 0; i < 3; ++i)
            maps.push_back(
                std::make_shared<sea::SplineMap>(*tests::exact_keyframe(sea, 0, 100'000 * i)));
    }
    static CascadeModes modes(int n) {
        CascadeModes modes = tests::calm_cascade(5.0, 64);
        tests::add_wave(modes, n, 0, 1.0, 0.0);
        return modes;
    }
    sea::Rate rate(int n) const { return sea->cascades[0].rate[static_cast<std::size_t>(n)]; }
    Surface between(int first) const {
        return Surface(
            {{maps[static_cast<std::size_t>(first)], maps[static_cast<std::size_t>(first) + 1]}},
            sea->choppiness, {}, {});
    }
    RealizationPtr sea;
    double omega;
    std::vector<sea::SplineMapPtr> maps;
};

// Cubic Hermite on values and rates misses 1 - cos(u/2) - u/4 sin(u/2) at most, linear interpolation
// 1 - cos(u/2), which is a ripple at the rate of keyframes. What the spline misses in space is added.
TEST(HardCase, G5_waves_between_keyframes_are_missed_by_less_than_predicted) {
    double ours = 0, linear = 0;
    for (const int n : {1, 4, 8}) {
        const OneWave wave(n);
        const double u = wave.omega * 0.1, q = sea::two_pi * n / 64;
        const double bound = sea::hermite_error(u) + sea::spline_error(q) + 1e-5;
        const DirectSum sum(wave.sea);
        double worst = 0;
        for (TimeUs t = 0; t <= 200'000; t += 5'000) {
            const Surface surface = wave.between(t < 100'000 ? 0 : 1);
            const auto now = sum.at_time(t);
            const auto before = sum.at_time(t / 100'000 * 100'000);
            const auto after = sum.at_time(t / 100'000 * 100'000 + 100'000);
            for (double x = 0; x < 5; x += 0.11) {
                const double truth = now.at(x, 0).height;
                worst = std::max(worst, std::abs(surface.at(x, 0, t).height - truth));
                const double line =
                    naive::linear_in_time(before.at(x, 0).height, after.at(x, 0).height,
                                          static_cast<double>(t % 100'000) / 100'000);
                linear = std::max(linear, std::abs(line - truth));
            }
        }
        EXPECT_LE(worst, bound) << n;
        ours = std::max(ours, worst);
    }
    const double u = OneWave(8).omega * 0.1;
    EXPECT_NEAR(linear, 1 - std::cos(u / 2), 0.01)
        << "the loss of linear interpolation is known too";
    EXPECT_GT(linear, sea::hermite_error(u) + sea::spline_error(sea::two_pi * 8 / 64));
    record("waves of 3.5 to 10 rad/s, keyframes at 10 Hz", "largest error over amplitude", linear,
           ours);
}

// The mean square that linear lookup misses of a wave of q = k dx is 1 + (2 + cos q)/3 - 2 sinc^2(q/2) of
// its own; 10 % is the case's. Ours is held to the law of docs/physics.md.
TEST(HardCase, G6_lookup_between_grid_points_keeps_crests) {
    double ours = 0, linear = 0;
    for (const int n : {4, 8, 16}) {
        const OneWave wave(n);
        const Surface surface = wave.between(0);
        const double q = sea::two_pi * n / 64, spacing_m = 5.0 / 64;
        const auto height = [&](double x) { return std::cos(q * x / spacing_m); };
        double missed = 0, all = 0, worst = 0;
        for (double x = 0; x < 5; x += 0.00137) {
            const double truth = height(x);
            const double line =
                naive::linear_lookup([&](int i) { return height(i * spacing_m); }, x, spacing_m);
            missed += std::pow(line - truth, 2);
            all += truth * truth;
            worst = std::max(worst, std::abs(surface.at(x, 0, 0).height - truth));
        }
        const double sinc = std::sin(q / 2) / (q / 2);
        EXPECT_NEAR(missed / all / (1 + (2 + std::cos(q)) / 3 - 2 * sinc * sinc), 1, 0.1) << n;
        EXPECT_LE(worst, sea::spline_error(q) + 1e-5) << n;
        EXPECT_GT(std::sqrt(missed / all), worst) << n;
        ours = worst;
        linear = std::sqrt(missed / all);
    }
    record("a wave of four grid points", "error over amplitude: rms; largest", linear, ours);
}

// A vertex is a point of the grid moved by the displacement map; a boat asks for the height above its
// place. 1 cm is the case's. Naive: the renderer leaves the finest cascade out.
TEST(HardCase, G7_a_boat_floats_on_the_surface_that_is_drawn) {
    const RealizationPtr sea = two_cascades();
    const Surface surface = surface_of(sea, 2), coarse = surface_of(sea, 1);
    const auto vertices = [](const Surface& from) {
        const auto map = sea::MapStream::start({.kind = sea::MapKind::displacement,
                                                .x0_m = 300,
                                                .y0_m = -100,
                                                .width_m = 90,
                                                .height_m = 90,
                                                .columns = 48,
                                                .rows = 48,
                                                .time_us = 70'000},
                                               from);
        std::vector<float> all;
        while (const auto chunk = (*map)->next_chunk())
            all.insert(all.end(), chunk->values.begin(), chunk->values.end());
        return all;
    };
    const auto hovers_m = [&](const std::vector<float>& points) {
        double worst = 0;
        for (int i = 0; i < 48 * 48; ++i) {
            const float* vertex = &points[static_cast<std::size_t>(3 * i)];
            const int row = i / 48, column = i % 48;
            const double x = 300 + 90.0 * column / 48, y = -100 + 90.0 * row / 48;
            const sea::Answer answer = surface.answer({x + vertex[0], y + vertex[1], 70'000});
            worst = std::max(worst, std::abs(answer.height_m - vertex[2]));
        }
        return worst;
    };
    const double ours = hovers_m(vertices(surface)), without = hovers_m(vertices(coarse));
    EXPECT_LT(ours, 0.01);
    EXPECT_GT(without, 0.01);
    record("two cascades, 2304 vertices", "largest height of a boat above its water, m", without,
           ours);
}

} // namespace
} // namespace seaway::hard_cases
