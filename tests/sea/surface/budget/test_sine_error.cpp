// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "sea/scene/scene.h"
#include "sea/surface/budget/error_budget.h"
#include "sea/surface/budget/sine_error.h"
#include "sea/surface/maps/sine_maps.h"
#include "sea/surface/surface.h"
#include "tests/support/explicit_sea.h"

namespace seaway::sea {
namespace {

/// Errors of heights of a stylised sea between its grid points and keyframes, and what is stated of them.
struct StylisedErrors {
    double bound_m = 0;  ///< at the worst time and place
    double inside = 0;   ///< share that is within what its answer states
    double stated_m = 0; ///< median
    std::vector<double> sorted_m;
    double share(double quantile) const {
        return sorted_m[static_cast<std::size_t>(quantile *
                                                 static_cast<double>(sorted_m.size() - 1))];
    }
};

StylisedErrors stylised_errors(double sharpness, double drag, std::uint64_t seed) {
    SineRamps ramps;
    ramps.kind = SineKind::exponential;
    ramps.length_m = 128.0;
    ramps.sharpness = sharpness;
    ramps.drag = drag;
    CascadeModes modes = tests::calm_cascade(128.0, 128);
    modes.sines.push_back(sine_field(ramps, seed, 0, Dispersion{}, 1.0, 0));
    const RealizationPtr sea = tests::make_sea({modes});
    const ErrorBudget budget = plan_budget(*sea, 0.01);
    const SineField& field = sea->cascades[0].sines[0];
    StylisedErrors errors;
    errors.bound_m = budget.interpolation_m;
    std::vector<double> stated_m;
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> place(0, 128.0), share(0, 1);
    const TimeUs interval = budget.cascades[0].interval_us;
    for (int pair = 0; pair < 4; ++pair) {
        const auto map = [&](TimeUs t) {
            Keyframe keyframe;
            keyframe.time_us = t;
            keyframe.size = 128;
            keyframe.length_m = 128.0;
            keyframe.fields = {Field::height, Field::height_rate};
            keyframe.values.assign(2 * keyframe.plane_size(), 0.0f);
            add_sines(field, t, keyframe);
            return std::make_shared<const SplineMap>(keyframe);
        };
        const TimeUs first = interval * (97 * pair + 3);
        const Surface surface({{map(first), map(first + interval)}}, {0, 0}, {},
                              map_error(budget, 0));
        for (int i = 0; i < 4000; ++i) {
            const double x = place(random), y = place(random);
            const TimeUs t =
                first + static_cast<TimeUs>(share(random) * static_cast<double>(interval));
            const Answer answer = surface.answer({x, y, t});
            const double error_m = std::abs(answer.height_m - sines_at(field, x, y, t).height);
            errors.sorted_m.push_back(error_m);
            stated_m.push_back(answer.error_m);
            errors.inside += error_m <= answer.error_m ? 1.0 / (4 * 4000) : 0.0;
        }
    }
    std::nth_element(stated_m.begin(), stated_m.begin() + 8000, stated_m.end());
    errors.stated_m = stated_m[8000];
    std::sort(errors.sorted_m.begin(), errors.sorted_m.end());
    return errors;
}

// Where waves drag each other along the largest errors are few and three times the one of 99 %; what stands above that is
// the margin for places that were not tried.
TEST(SineError, exponential_sines_keep_their_bound_with_and_without_drag_and_it_is_near) {
    for (const double sharpness : {1.0, 3.0, 10.0})
        for (const double drag : {0.0, 0.4, 1.0}) {
            const StylisedErrors errors = stylised_errors(sharpness, drag, 7);
            EXPECT_LE(errors.sorted_m.back(), errors.bound_m) << sharpness << " " << drag;
            EXPECT_LE(errors.bound_m, 6 * errors.share(0.99)) << sharpness << " " << drag;
            EXPECT_GE(errors.inside, 0.999) << sharpness << " " << drag;
            if (drag == 0.0 || sharpness == 1.0) {
                EXPECT_LE(errors.stated_m, 2 * errors.share(0.99)) << sharpness << " " << drag;
            }
        }
}

// Naive: at the points of a keyframe nothing is interpolated, so nothing is stated; maps are floats all the same.
TEST(SineError, at_the_points_of_a_keyframe_what_single_precision_costs_is_stated) {
    SineRamps ramps;
    ramps.kind = SineKind::exponential;
    ramps.length_m = 128.0;
    CascadeModes modes = tests::calm_cascade(128.0, 128);
    modes.sines.push_back(sine_field(ramps, 7, 0, Dispersion{}, 10.0, 0));
    const RealizationPtr sea = tests::make_sea({modes});
    const ErrorBudget budget = plan_budget(*sea, 0.01);
    const SineField& field = sea->cascades[0].sines[0];
    Keyframe keyframe;
    keyframe.size = 128;
    keyframe.length_m = 128.0;
    keyframe.fields = {Field::height, Field::height_rate};
    keyframe.values.assign(2 * keyframe.plane_size(), 0.0f);
    add_sines(field, 0, keyframe);
    const auto map = std::make_shared<const SplineMap>(keyframe);
    const Surface surface({{map, map}}, {0, 0}, {}, map_error(budget, 0));
    double worst_share = 0;
    for (int y = 0; y < 128; ++y)
        for (int x = 0; x < 128; ++x) {
            const Answer answer = surface.answer({1.0 * x, 1.0 * y, 0});
            const double error_m = std::abs(answer.height_m - sines_at(field, x, y, 0).height);
            ASSERT_GT(answer.error_m, 0);
            worst_share = std::max(worst_share, error_m / answer.error_m);
        }
    EXPECT_LE(worst_share, 1.0);
    EXPECT_GT(worst_share, 1e-3) << "it is not stated as if it were large";
}

// Naive: the largest error that was met, and a quarter more. With drag one of 60 000 places is missed by half as much again as
// any of 4096.
TEST(SineError, the_largest_error_between_keyframes_is_found_where_none_of_its_places_lies) {
    SineRamps ramps;
    ramps.kind = SineKind::exponential;
    ramps.length_m = 128.0;
    ramps.count = 4;
    ramps.wavelength_m = 14.0;
    ramps.wavenumber_ratio = 1.3;
    ramps.amplitude_m = 0.3;
    constexpr TimeUs interval = 100'000;
    for (const auto& [sharpness, drag] : {std::pair(1.0, 0.0), {1.0, 1.0}, {3.0, 0.0}})
        for (const std::uint64_t seed : {7u, 8u}) {
            ramps.sharpness = sharpness;
            ramps.drag = drag;
            const SineField field = sine_field(ramps, seed, 0, Dispersion{}, 1.0, 0);
            std::mt19937_64 random(seed);
            std::uniform_real_distribution<double> place(0, 128.0), time_s(0, 1e6);
            double largest_m = 0;
            for (int i = 0; i < 60'000; ++i) {
                const double x = place(random), y = place(random);
                const TimeUs t = us_from_seconds(time_s(random));
                const LagrangianPoint before = sines_at(field, x, y, t),
                                      middle = sines_at(field, x, y, t + interval / 2),
                                      after = sines_at(field, x, y, t + interval);
                const double hermite = 0.5 * (before.height + after.height) +
                                       0.0125 * (before.height_rate - after.height_rate);
                largest_m = std::max(largest_m, std::abs(hermite - middle.height));
            }
            const double bound_m = SineError(field, 1.0).time(interval).missed_m;
            EXPECT_LE(largest_m, bound_m) << sharpness << " " << drag << " " << seed;
        }
}

/// One wave of 10 m that turns once a second.
SineField once_a_second(SineKind kind, double sharpness) {
    SineRamps ramps;
    ramps.kind = kind;
    ramps.length_m = 100.0;
    ramps.sharpness = sharpness;
    ramps.by_hand = {{10.0, 1.0, 0.0, 0.3, 10.0}};
    return sine_field(ramps, 1, 0, Dispersion{}, 1.0, 0);
}

/// At any time between two keyframes.
double largest_between_m(const SineField& field, TimeUs interval_us) {
    double largest_m = 0;
    for (TimeUs first_us = 0; first_us < 1'000'000; first_us += 7'919) {
        const LagrangianPoint a = sines_at(field, 3, 4, first_us),
                              b = sines_at(field, 3, 4, first_us + interval_us);
        for (int n = 1; n < 64; ++n) {
            const double x = n / 64.0, r = 1.0 - x;
            const double hermite_m =
                r * r * (1 + 2 * x) * a.height + x * x * (1 + 2 * r) * b.height +
                seconds_from_us(interval_us) * x * r * (r * a.height_rate - x * b.height_rate);
            const auto later_us = static_cast<TimeUs>(x * static_cast<double>(interval_us));
            largest_m = std::max(
                largest_m, std::abs(hermite_m - sines_at(field, 3, 4, first_us + later_us).height));
        }
    }
    return largest_m;
}

// Naive: in the middle of two keyframes that are two turns apart the wave stands as at both, and nothing seems to be missed.
TEST(SineError, keyframes_whole_turns_apart_tell_nothing_of_a_wave) {
    for (const SineKind kind : {SineKind::sine, SineKind::exponential})
        for (const TimeUs interval_us : {1'000'000, 2'000'000, 4'000'000}) {
            const SineField field = once_a_second(kind, 2.0);
            EXPECT_GE(SineError(field, 1.0).time(interval_us).missed_m,
                      largest_between_m(field, interval_us))
                << interval_us;
        }
    CascadeModes modes = tests::calm_cascade(100.0, 128);
    modes.sines.push_back(once_a_second(SineKind::sine, 1.0));
    const ErrorBudget budget = plan_budget(*tests::make_sea({modes}), 0.01);
    EXPECT_LT(budget.cascades[0].interval_us, 1'000'000);
    EXPECT_LT(budget.cascades[0].interval_us * budget.cascades[0].every_max, 1'000'001);
}

// Naive: the harmonics of a sharp wave are missed most in the middle of an interval, as the wave itself.
TEST(SineError, harmonics_that_turn_once_in_half_an_interval_are_counted) {
    for (const double sharpness : {1.0, 3.0, 10.0})
        for (const TimeUs interval_us : {250'000, 500'000, 640'000, 800'000, 1'000'000}) {
            const SineField field = once_a_second(SineKind::exponential, sharpness);
            EXPECT_GE(SineError(field, 1.0).time(interval_us).missed_m,
                      largest_between_m(field, interval_us))
                << sharpness << " " << interval_us;
        }
}

// Naive: of 4096 places none is where the waves of a list all meet, which they do where their phases are 0: at the origin.
TEST(SineError, a_list_of_waves_that_meet_at_its_origin_stays_inside_the_bound_there) {
    for (const double sharpness : {1.0, 2.0}) {
        std::string list = "wavelength_m,amplitude_m,from_deg,phase_rad\n";
        for (int n = 20; n < 60; ++n)
            list += fmt::format("{},0.02,270,0\n", 1000.0 / n);
        const Result<Scene> scene =
            parse_scene(fmt::format("[[sea.system]]\ntype = \"sines\"\nshape = \"exponential\"\n"
                                    "length_m = 1000\nsharpness = {}\ndata = \"\"\"\n{}\"\"\"\n"
                                    "[[cascade]]\nlength_m = 1000\nsize = 256\n",
                                    sharpness, list),
                        "list.toml");
        ASSERT_TRUE(scene) << scene.error().message;
        const Result<Realization> sea = realize(*scene);
        ASSERT_TRUE(sea);
        const CascadeModes& modes = sea->cascades[0];
        ASSERT_EQ(modes.sines.size(), 1u);
        const SineError error(modes.sines[0], modes.spec.spacing_m());
        // Midway between two points of a grid, which may lie anywhere beside the crest that all have made.
        const auto missed_m = [&](double x_m, TimeUs time_us) {
            const double spacing_m = modes.spec.spacing_m();
            double sum = 0;
            constexpr double pole = -0.2679491924311227; // sqrt(3) - 2
            const auto coefficient = [&](int m) {
                return -6 * pole / (1 - pole * pole) * std::pow(pole, std::abs(m));
            };
            for (int n = 0; n < 12; ++n)
                for (const double side : {-1.0, 1.0})
                    sum += (23.0 / 48 * (coefficient(n) + coefficient(n + 1)) +
                            1.0 / 48 * (coefficient(n - 1) + coefficient(n + 2))) *
                           sines_at(modes.sines[0], x_m + side * (n + 0.5) * spacing_m, 0, time_us)
                               .height;
            return std::abs(sum - sines_at(modes.sines[0], x_m, 0, time_us).height);
        };
        double worst_m = 0;
        for (int i = -200; i <= 200; ++i)
            for (const TimeUs time_us : {-500'000, -100'000, 0, 100'000, 500'000})
                worst_m = std::max(worst_m, missed_m(0.05 * i, time_us));
        EXPECT_LE(worst_m, error.east_m()) << sharpness;
    }
}

} // namespace
} // namespace seaway::sea
