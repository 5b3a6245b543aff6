// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <complex>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "sea/basics/glide.h"
#include "sea/scene/scene.h"
#include "sea/surface/budget/cascade_waves.h"
#include "sea/surface/budget/error_budget.h"
#include "sea/surface/maps/hermite.h"
#include "tests/sea/warnings_of.h"
#include "tests/support/explicit_sea.h"

namespace seaway::sea {
namespace {

/// Largest error of cubic Hermite on the complex wave e^(i u s), s = 0 .. 1: its size is that of the
/// real wave of the worst phase.
double largest_hermite_error(double u) {
    using namespace std::complex_literals;
    double largest = 0;
    for (double s = 0; s <= 1; s += 0.01) {
        const double r = 1 - s;
        const std::complex<double> after = std::exp(1i * u);
        const std::complex<double> mixed = r * r * (1 + 2 * s) + s * r * r * u * 1i +
                                           after * (s * s * (1 + 2 * r) - s * s * r * u * 1i);
        largest = std::max(largest, std::abs(mixed - std::exp(1i * (u * s))));
    }
    return largest;
}

// Of a wave that fades while another grows in its place, as amplitudes do in a glide. Naive: the law of a steady wave, which a swell of
// a minute and keyframes two seconds apart pass eight times.
TEST(TimeBudget, of_a_glide_no_more_is_missed_than_is_stated) {
    using namespace std::complex_literals;
    constexpr TimeUs glide_us = glide_us_min + 300'000; // it ends between keyframes
    const double glide_s = seconds_from_us(glide_us);
    for (const double interval_s : {0.1, 0.5, 1.0, 2.0, 5.0})
        for (const double omega : {0.0, 0.02, 0.06, 0.5, 2.0})
            for (const std::complex<double> other : {0.0 + 0.0i, -1.0 + 0.0i, 0.0 + 1.0i}) {
                const auto value = [&](double t_s) {
                    const double s = glide_share(us_from_seconds(t_s), 0, glide_us);
                    return (1.0 + s * (other - 1.0)) * std::exp(1i * (omega * t_s));
                };
                const auto rate = [&](double t_s) {
                    const double ds = glide_rate(us_from_seconds(t_s), 0, glide_us);
                    return 1i * omega * value(t_s) +
                           ds * (other - 1.0) * std::exp(1i * (omega * t_s));
                };
                const TimeUs interval_us = us_from_seconds(interval_s);
                const double bound = gliding_error(omega * interval_s, interval_s / glide_s);
                double worst = 0;
                for (double t_s = 0; t_s < glide_s; t_s += interval_s)
                    for (const double share : {0.25, 0.5, 0.75}) {
                        const HermiteWeights w =
                            hermite_weights(0, interval_us, us_from_seconds(share * interval_s));
                        const double after_s = t_s + interval_s;
                        const std::complex<double> mixed =
                            w.value[0] * value(t_s) + w.value[1] * rate(t_s) +
                            w.value[2] * value(after_s) + w.value[3] * rate(after_s);
                        worst = std::max(worst, std::abs(mixed - value(t_s + share * interval_s)));
                    }
                EXPECT_LE(worst, bound * (1 + 1e-9) + 1e-13) << interval_s << " " << omega;
                EXPECT_GE(bound, hermite_error(omega * interval_s));
            }
    EXPECT_EQ(gliding_error(0.7, 0.0), hermite_error(0.7));
}

// A wave of a kilometre over a depth that glides from 2 to 200 m moves things by 20 to 1 times its height; given, it counts with all of
// its amplitude.
TEST(TimeBudget, of_a_glide_of_depth_displacements_are_missed_by_what_coth_is) {
    CascadeModes modes = tests::calm_cascade(1000.0, 64);
    modes.depth_m = 2; // the shallower of the two
    tests::add_wave(modes, 1, 0, 0.3, 0.1);
    const double k = two_pi / 1000;
    const DepthGlide glide{30'000'000, 2, 200};
    const CascadeWaves deepens(modes, glide), steady(modes);
    for (const TimeUs interval_us : {200'000, 1'000'000}) {
        const double missed_m = 0.3 * orbit_error(k, glide, interval_us);
        const double stated_m = bound_sigmas * deepens.loss(interval_us).displacement.time_m;
        EXPECT_GE(stated_m, 0.7 * missed_m)
            << "of one wave that is not given: 5 / sqrt(2) of its rms";
        EXPECT_LE(stated_m, 8 * missed_m);
        EXPECT_GT(stated_m, 10 * bound_sigmas * steady.loss(interval_us).displacement.time_m);
        EXPECT_GT(deepens.time_strain_rms(interval_us), steady.time_strain_rms(interval_us));
        EXPECT_GE(bound_sigmas * deepens.slow_loss(interval_us, 2 * interval_us).displacement_m,
                  0.7 * 0.3 * orbit_error(k, glide, 2 * interval_us));
    }
}

// Towards a keyframe the error of every wave falls as s^2, whatever its phase step.
TEST(TimeBudget, near_a_keyframe_a_wave_is_missed_by_no_more_than_the_shape_says) {
    using namespace std::complex_literals;
    for (double u = 0.1; u <= hermite_phase_max; u += 0.1)
        for (double s = 0.005; s < 1; s += 0.005) {
            const HermiteWeights w = hermite_weights(0, 1'000'000, us_from_seconds(s));
            const std::complex<double> after = std::exp(1i * u);
            const std::complex<double> mixed =
                w.value[0] + w.value[1] * u * 1i + after * (w.value[2] + w.value[3] * u * 1i);
            const double missed = std::abs(mixed - std::exp(1i * (u * s)));
            // Rounding: between_samples() is 1e-6 at the ends of this range.
            EXPECT_LE(missed, (1 + 1e-9) * hermite_error(u) * between_samples(s) + 1e-14)
                << u << " " << s;
        }
}

// Naive: the cubic goes on: ten intervals behind the last keyframe a wave is a hundred times as high, and a loop of folds.
TEST(TimeBudget, beyond_its_keyframes_a_wave_runs_on_for_a_quarter_of_an_interval_and_stands) {
    using namespace std::complex_literals;
    const auto wave = [](double u,
                         double s) { // of the worst phase, and its rate, an interval of 1 s
        const HermiteWeights w = hermite_weights(0, 1'000'000, us_from_seconds(s));
        const std::complex<double> after = std::exp(1i * u);
        const auto mixed = [&](const double(&of)[4]) {
            return of[0] + of[1] * u * 1i + after * (of[2] + of[3] * u * 1i);
        };
        return std::pair(mixed(w.value), mixed(w.rate));
    };
    for (double u = 0.1; u < 3; u += 0.1) { // beyond, waves are small
        for (const double end : {0.0, 1.0})
            for (const double out : {1e-4, 0.05, 0.1, 0.3, 1.0, 10.0, 1e9}) {
                const double s = end == 0 ? -out : 1 + out;
                const auto [value, rate] = wave(u, s);
                // At a quarter: 0.22 of one keyframe, 0.78 of the other, 0.08 and 0.39 of their rates.
                EXPECT_LE(std::abs(value), 1 + 0.47 * u) << u << ' ' << s;
                EXPECT_LE(std::abs(rate), u * (1 + u)) << u << ' ' << s;
                if (out >= 10) {
                    EXPECT_LT(std::abs(rate), 1e-6 * u) << "it stands";
                }
                if (out > 1e6)
                    continue;
                // A rate is what the value changes by; microseconds are what times are told in.
                const double step = 2e-6;
                const auto difference =
                    (wave(u, s + step).first - wave(u, s - step).first) / (2 * step);
                EXPECT_LE(std::abs(difference - rate), 1e-4 * u) << u << ' ' << s;
                if (out <= 0.1 && u <= 1) { // late by a tenth of an interval
                    // The cubic is off by u^4 s^2 (1-s)^2 / 24, what it runs slower by 0.0063 of 0.1.
                    const double off = std::abs(value - std::exp(1i * (u * s)));
                    EXPECT_LE(off, std::pow(u, 4) * 0.0122 / 24 * 1.5 + 0.0064 * out * u * 1.1);
                }
            }
    }
    const HermiteWeights alone = hermite_weights(5, 5, 3'600'000'000);
    EXPECT_NEAR(alone.value[1], hermite_beyond_alone_s, 1e-9) << "of one map, s of its rate";
    EXPECT_NEAR(alone.rate[1], 0, 1e-12);
    EXPECT_EQ(alone.value[0], 1);
}

// The error in the middle of an interval alone is zero at whole turns: 2 s between keyframes of a
// loop of 1 s looked perfect.
TEST(TimeBudget, hermite_law_bounds_every_time_and_phase_and_never_falls) {
    double before = 0;
    for (double u = 0; u < 80; u += 0.03) {
        const double law = hermite_error(u);
        EXPECT_GE(law, before) << u;
        EXPECT_GE(law, largest_hermite_error(u) - 1e-12) << u; // rounding
        // Where keyframes say anything of the wave the law is met: nothing is given away.
        if (u <= hermite_phase_max) {
            EXPECT_LE(law, 1.001 * largest_hermite_error(u) + 1e-12) << u;
        }
        before = law;
    }
}

Scene looping_swell(double loop_period_s, double height_error_m) {
    const std::string text = fmt::format(R"(
[sea]
seed = 1
depth_m = 20.0
loop_period_s = {}
[[sea.system]]
type = "swell"
significant_height_m = 2.0
peak_period_s = 8.0
from_deg = 270
[[cascade]]
length_m = 200.0
size = 64
[[cascade]]
length_m = 30.0
size = 64
[accuracy]
height_error_m = {}
)",
                                         loop_period_s, height_error_m);
    Result<Scene> scene = parse_scene(text, "loop.toml", ".");
    EXPECT_TRUE(scene) << (scene ? "" : scene.error().message);
    return *scene;
}

TEST(TimeBudget, in_a_loop_of_any_length_heights_between_keyframes_stay_inside_the_bound) {
    for (const double loop_s : {1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 8.0, 12.0, 20.0, 33.0, 60.0}) {
        const auto sea = std::make_shared<const Realization>(*realize(looping_swell(loop_s, 0.01)));
        const ErrorBudget budget = plan_budget(*sea, 0.01);
        double bound_m = 0; // of the time alone; both cascades together
        double worst_m = 0;
        std::vector<DirectSum> alone;
        for (const CascadeModes& modes : sea->cascades)
            alone.emplace_back(std::make_shared<const Realization>(
                Realization{{modes}, sea->choppiness, sea->loop_period_us}));
        for (const CascadeBudget& cascade : budget.cascades)
            bound_m = std::hypot(bound_m, bound_sigmas * cascade.loss.height.time_m);
        for (int i = 0; i < 60; ++i) {
            const double x = 17.3 * i, y = -5.9 * i;
            double mixed_m = 0, truth_m = 0;
            for (std::size_t c = 0; c < alone.size(); ++c) {
                const TimeUs interval = budget.cascades[c].interval_us;
                const TimeUs t = interval * (i % 7) + interval * (1 + i % 3) / 4;
                const TimeUs first = interval * (i % 7);
                const HermiteWeights w = hermite_weights(first, first + interval, t);
                const LagrangianPoint a = alone[c].at(x, y, first);
                const LagrangianPoint b = alone[c].at(x, y, first + interval);
                mixed_m += w.value[0] * a.height + w.value[1] * a.height_rate +
                           w.value[2] * b.height + w.value[3] * b.height_rate;
                truth_m += alone[c].at(x, y, t).height;
            }
            worst_m = std::max(worst_m, std::abs(mixed_m - truth_m));
        }
        EXPECT_LE(worst_m, bound_m) << "loop of " << loop_s << " s";
        EXPECT_LE(bound_m, 0.01) << "loop of " << loop_s << " s";
    }
}

// Energy that no keyframe tells of is not worth longer intervals, however little it is.
TEST(TimeBudget, no_wave_turns_more_than_once_between_two_keyframes) {
    const RealizationPtr steep = tests::two_cascades();
    const RealizationPtr flat =
        tests::make_sea({tests::random_cascade(41.0, 64, 15, 300, 4e-9, 12)});
    for (const auto& [sea, error_m] :
         {std::pair(steep, 0.01), std::pair(steep, 1.0), std::pair(flat, 1.0)}) {
        const ErrorBudget budget = plan_budget(*sea, error_m);
        for (std::size_t c = 0; c < sea->cascades.size(); ++c) {
            const CascadeModes& modes = sea->cascades[c];
            for (std::size_t i = 0; i < modes.h0.size(); ++i)
                if (std::abs(modes.h0[i]) > 0) {
                    ASSERT_LE(omega_from_rate(modes.rate[i]) *
                                  seconds_from_us(budget.cascades[c].interval_us),
                              hermite_phase_max);
                }
        }
    }
}

TEST(TimeBudget, an_accuracy_that_the_grids_cannot_reach_is_warned_of) {
    const auto warned = [](double asked_m) {
        const std::vector<std::string> warnings = testing::warnings_of(looping_swell(0, asked_m));
        return std::any_of(warnings.begin(), warnings.end(), [](const std::string& warning) {
            return warning.find("accuracy.height_error_m") != std::string::npos;
        });
    };
    EXPECT_TRUE(warned(1e-4));
    EXPECT_FALSE(warned(1.0));
    const RealizationPtr sea = tests::two_cascades();
    const ErrorBudget budget = plan_budget(*sea, 1e-4);
    EXPECT_GT(level_error_m(budget, budget.codec_error_m), budget.interpolation_m);
    EXPECT_GT(budget.interpolation_m, 1e-4);
}

} // namespace
} // namespace seaway::sea
