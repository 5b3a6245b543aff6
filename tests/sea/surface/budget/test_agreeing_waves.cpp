// SPDX-License-Identifier: Apache-2.0
// Waves whose phases are given may all be missed most at one place and time, whatever cascade or system they are of; and of one wave
// what is missed in time and in space agrees.
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "sea/surface/budget/error_budget.h"
#include "sea/surface/surface.h"
#include "tests/support/explicit_sea.h"

namespace seaway::sea {
namespace {

constexpr double length_m = 100.0;
constexpr int size = 64;

/// A surface between two keyframes of all cascades, each half its interval before and after `middle_us`.
Surface around(const RealizationPtr& sea, const ErrorBudget& budget, TimeUs middle_us) {
    std::vector<SplinePair> pairs;
    for (std::size_t c = 0; c < sea->cascades.size(); ++c) {
        const auto map = [&](TimeUs time_us) {
            return std::make_shared<const SplineMap>(
                *tests::exact_keyframe(sea, static_cast<int>(c), time_us));
        };
        const TimeUs half_us = budget.cascades[c].interval_us / 2;
        pairs.push_back({map(middle_us - half_us), map(middle_us + half_us)});
    }
    return Surface(pairs, sea->choppiness, fold_search(budget), map_error(budget, 0));
}

/// Two hundred of each tile crest at one place in the middle of a cell, at one time between two keyframes.
RealizationPtr meeting(int cascades, double at_m, TimeUs at_us) {
    std::vector<CascadeModes> all;
    for (int c = 0; c < cascades; ++c) {
        CascadeModes modes = tests::calm_cascade(length_m - 0.01 * c, size);
        modes.given.assign(modes.h0.size(), 0);
        for (int ny = -14; ny <= 14; ++ny)
            for (int nx = 1; nx <= 14; ++nx) {
                if (std::hypot(nx, ny) < 8 || std::hypot(nx, ny) > 14)
                    continue;
                const auto i = static_cast<std::size_t>((ny + size) % size * size + nx);
                const double phase = -modes.spec.wavenumber_step_radpm() * (nx + ny) * at_m +
                                     omega_from_rate(modes.rate[i]) * seconds_from_us(at_us);
                tests::add_wave(modes, nx, ny, 0.004 / cascades, phase);
                modes.given[i] = 1;
            }
        all.push_back(std::move(modes));
    }
    return tests::make_sea(std::move(all), {0, 0});
}

// Naive: cascades have nothing to do with each other, and are added in the square: of eight tiles the bound is passed 2.6 times.
TEST(AgreeingWaves, of_several_cascades_stay_inside_the_bound_where_they_meet) {
    const double middle_m = 20.5 * length_m / size;
    constexpr TimeUs meeting_us = 7'160'000;
    for (const int cascades : {1, 2, 8}) {
        const RealizationPtr sea = meeting(cascades, middle_m, meeting_us);
        const ErrorBudget budget = plan_budget(*sea, 0.01);
        const Surface surface = around(sea, budget, meeting_us);
        const DirectSum sum(sea);
        const auto moment = sum.at_time(meeting_us);
        double worst_share = 0;
        for (int i = -20; i <= 20; ++i) {
            const double x = middle_m + 0.03 * i, y = middle_m + 0.02 * i;
            const Answer answer = surface.answer({x, y, meeting_us});
            worst_share = std::max(worst_share, std::abs(answer.height_m - moment.at(x, y).height) /
                                                    answer.error_m);
        }
        EXPECT_LT(worst_share, 1.0) << cascades;
        EXPECT_GT(worst_share, 0.5) << cascades << ": where they meet the bound is nearly met";
    }
}

SineField sine(double amplitude_m, SineKind kind, double speed_mps = 3.5) {
    SineRamps ramps;
    ramps.kind = kind;
    ramps.length_m = length_m;
    ramps.by_hand = {{8.0, amplitude_m, 20.0, 0.3, speed_mps}};
    return sine_field(ramps, 1, 0, Dispersion{}, 1.0, 0);
}

/// So many alike, of 1 m together.
RealizationPtr alike(int cascades, int systems, SineKind kind) {
    std::vector<CascadeModes> all(static_cast<std::size_t>(cascades),
                                  tests::calm_cascade(length_m, size));
    for (CascadeModes& modes : all)
        for (int s = 0; s < systems; ++s)
            modes.sines.push_back(sine(1.0 / (cascades * systems), kind));
    return tests::make_sea(std::move(all), {0, 0});
}

/// The largest share of what is stated, between two keyframes, that far from the origin.
double worst_share(const RealizationPtr& sea, double within_m = length_m) {
    const ErrorBudget budget = plan_budget(*sea, 0.01);
    const DirectSum sum(sea);
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> place(0, within_m);
    double worst = 0;
    for (const TimeUs middle_us : {0, 1'370'000, 2'111'000}) {
        const Surface surface = around(sea, budget, middle_us);
        const auto moment = sum.at_time(middle_us);
        for (int i = 0; i < 1500; ++i) {
            const double x = place(random), y = place(random);
            const Answer answer = surface.answer({x, y, middle_us});
            worst = std::max(worst,
                             std::abs(answer.height_m - moment.at(x, y).height) / answer.error_m);
        }
    }
    return worst;
}

// Naive: a sine beside the same wave as a mode is added to it in the square.
TEST(AgreeingWaves, that_are_modes_and_stylised_ones_of_one_tile_stay_inside_the_bound) {
    CascadeModes modes = tests::calm_cascade(length_m, size);
    modes.sines.push_back(sine(0.5, SineKind::sine, 0));
    const SineField::Wave& wave = modes.sines[0].waves[0];
    const double step = modes.spec.wavenumber_step_radpm();
    const auto nx = static_cast<int>(std::lround(wave.kx_radpm / step)),
               ny = static_cast<int>(std::lround(wave.ky_radpm / step));
    modes.given.assign(modes.h0.size(), 1);
    for (int n = 0; n < 20; ++n) // near the origin all are in step with it
        tests::add_wave(modes, nx + n % 3 - 1, ny + n / 10, 0.025, 0.3);
    const double worst = worst_share(tests::make_sea({modes}, {0, 0}), 6.0);
    EXPECT_LT(worst, 1.0);
    EXPECT_GT(worst, 0.3);
}

// Naive: what is missed in time, along each axis, of each system and of each cascade is added in the square: 1.1 times the bound of
// one sine, 3.1 of eight.
TEST(AgreeingWaves, that_are_stylised_stay_inside_the_bound_however_many_are_alike) {
    struct Case {
        int cascades, systems;
    };
    for (const SineKind kind : {SineKind::sine, SineKind::exponential})
        for (const Case& one : {Case{1, 1}, {1, 2}, {1, 8}, {2, 1}, {4, 2}}) {
            const RealizationPtr sea = alike(one.cascades, one.systems, kind);
            const double worst = worst_share(sea);
            EXPECT_LT(worst, 1.0) << one.cascades << " " << one.systems;
            EXPECT_GT(worst, 0.5) << one.cascades << " " << one.systems;
        }
}

} // namespace
} // namespace seaway::sea
