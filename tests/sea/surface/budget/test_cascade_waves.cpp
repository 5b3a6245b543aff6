// SPDX-License-Identifier: Apache-2.0
// What is known of the waves of a cascade: every figure of one oblique wave by hand, in shallow water.
#include <cmath>
#include <tuple>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "sea/scene/scene.h"
#include "sea/surface/budget/cascade_waves.h"
#include "sea/surface/budget/interpolation_laws.h"
#include "tests/support/explicit_sea.h"

namespace seaway::sea {
namespace {

/// A wave that runs east and south, more south.
struct ObliqueWave {
    static constexpr double amplitude_m = 0.31, depth_m = 4, spacing_m = 90.0 / 64;
    const double step = two_pi / 90, kx = 5 * step, ky = -9 * step, k = std::hypot(kx, ky);
    const double qx = kx * spacing_m, qy = -ky * spacing_m;
    const double omega = std::sqrt(gravity_default_mps2 * k); // calm_cascade() gives deep water's
    const double variance = 0.5 * amplitude_m * amplitude_m;
    const double aspect = 1 / std::tanh(k * depth_m); // of the orbits
    const CascadeWaves waves{modes()};

    static CascadeModes modes() {
        CascadeModes modes = tests::calm_cascade(90.0, 64);
        modes.depth_m = depth_m;
        tests::add_wave(modes, 5, -9, amplitude_m, 0.3);
        return modes;
    }
};

void expect(double found, double expected, const char* what, double share = 1e-9) {
    EXPECT_NEAR(found, expected, share * std::abs(expected)) << what;
}

TEST(CascadeWaves, every_figure_of_one_wave_is_what_its_definition_gives) {
    const ObliqueWave one;
    const CascadeWaves& waves = one.waves;
    const double k = one.k, omega = one.omega, variance = one.variance, aspect = one.aspect;
    ASSERT_GT(aspect, 1.005);
    expect(waves.spacing_m(), ObliqueWave::spacing_m, "spacing");
    expect(waves.points(), 64 * 64, "points");
    expect(waves.height().whole.mean_square_m2(), variance, "height");
    expect(waves.height().gradient.mean_square_m2(), variance * k * k, "slope");
    expect(waves.displacement().whole.mean_square_m2(), variance * aspect * aspect, "displacement");
    expect(waves.displacement().gradient.mean_square_m2(), variance * aspect * aspect * k * k,
           "strain");
    expect(waves.strain().whole.mean_square_m2(), variance * aspect * aspect * k * k, "strain");
    // What the predictor of the codec leaves: differences along both axes.
    const double detail = variance * (2 - 2 * std::cos(one.qx)) * (2 - 2 * std::cos(one.qy));
    expect(waves.detail_m2(), detail, "detail");
    expect(waves.rate_detail_m2ps2(), detail * omega * omega, "detail of rates");
    // Missed between grid points: by both axes together in the middle of a cell, by each on its side.
    const auto expect_missed = [&](const Motion& motion, double size2, double east, double north,
                                   const char* what) {
        expect(motion.east_m2 + motion.north_m2, size2 * (east + north) * (east + north), what);
        expect(motion.east_m2 - motion.north_m2, size2 * (east * east - north * north), what);
    };
    ASSERT_GT(spline_error(one.qy), 2 * spline_error(one.qx)) << "told apart";
    expect_missed(waves.height(), variance, spline_error(one.qx), spline_error(one.qy), "height");
    expect_missed(waves.displacement(), variance * aspect * aspect, spline_error(one.qx),
                  spline_error(one.qy), "displacement");
    expect_missed(waves.strain(), variance * aspect * aspect * k * k, spline_slope_error(one.qx),
                  spline_slope_error(one.qy), "strain");
}

// Naive: of slow waves it is the difference of two sums that round differently, below 0, and products with it have no root.
TEST(CascadeWaves, what_hermites_cubic_misses_is_never_less_than_nothing_and_grows) {
    double before = 0;
    for (double u = 1e-7; u < 6; u *= 1.3) {
        const double missed = hermite_error(u);
        EXPECT_GT(missed, before) << u;
        const auto x = static_cast<long double>(u) / 2;
        if (u > 0.05) {
            EXPECT_NEAR(missed / static_cast<double>(1 - std::cos(x) - x / 2 * std::sin(x)), 1,
                        1e-9)
                << u;
        }
        before = missed;
    }
    // A tide beside which keyframes are as close as may be.
    CascadeModes slow = tests::calm_cascade(1e6, 64);
    tests::add_wave(slow, 1, 0, 1.0, 0.3);
    const CascadeWaves waves{slow};
    for (const TimeUs interval_us : {10'000, 500'000, 2'000'000}) {
        EXPECT_GE(waves.time_costs_m2(interval_us, 0.1), 0.0);
        EXPECT_TRUE(std::isfinite(waves.strain_rms(interval_us)));
    }
}

// Hermite's cubic and the spline both make a wave smaller. Naive: their errors of one wave have nothing to do with each other, so that
// where both are, a bound of five deviations is one of four.
TEST(CascadeWaves, what_keyframes_and_the_grid_miss_of_one_wave_adds_up) {
    const ObliqueWave one;
    const CascadeWaves& waves = one.waves;
    constexpr double by_rate = 1e-6; // a frequency is a whole number of turns
    const double east = spline_error(one.qx), north = spline_error(one.qy);
    for (const double interval_s : {0.2, 0.5}) {
        const TimeUs interval_us = us_from_seconds(interval_s);
        const double time = hermite_error(one.omega * interval_s);
        const CascadeLoss loss = waves.loss(interval_us);
        const auto expect_loss = [&](const MapLoss& found, double size2, const char* what) {
            expect(found.interpolation_variance_m2(), size2 * std::pow(time + east + north, 2),
                   what, by_rate);
            expect(square(found.time_m), size2 * time * (time + east + north), what, by_rate);
            expect(square(found.east_m), size2 * east * (east + north + time), what, by_rate);
            EXPECT_EQ(found.value_m + found.rate_mps, 0) << "nothing is coded";
        };
        expect_loss(loss.height, one.variance, "height");
        expect_loss(loss.displacement, one.variance * one.aspect * one.aspect, "displacement");
        // Less far from a keyframe or a grid point, and of keyframes further apart than the sea says.
        for (const double slow_s : {interval_s, 2 * interval_s}) {
            const auto slow = waves.slow_loss(interval_us, us_from_seconds(slow_s));
            MapLoss slower = loss.height;
            slower.time_m = slow.height_m;
            const double slow_time = hermite_error(one.omega * slow_s);
            for (const double s : {0.01, 0.1, 0.3, 0.5})
                for (const double x : {0.0, 0.1, 0.3, 0.5})
                    for (const double y : {0.0, 0.2, 0.5}) {
                        const double b = between_samples(s), bx = between_samples(x),
                                     by = between_samples(y);
                        const double missed =
                            b * slow_time + std::sqrt(bx) * east + std::sqrt(by) * north;
                        EXPECT_GE(slower.variance_m2(s, bx, by, hermite_weights(0, 1'000'000, 0)),
                                  one.variance * missed * missed * (1 - by_rate))
                            << slow_s << ' ' << s << ' ' << x << ' ' << y;
                    }
        }
        // What a second costs is what it adds to the grid's part.
        expect(waves.time_costs_m2(interval_us, 0.5),
               one.variance * (1 + 0.25 * one.aspect * one.aspect) *
                   (std::pow(time + east + north, 2) - std::pow(east + north, 2)),
               "cost", by_rate);
        const double strain2 = one.variance * one.aspect * one.aspect * one.k * one.k;
        EXPECT_NEAR(waves.time_strain_rms(interval_us), std::sqrt(strain2) * time,
                    by_rate * std::sqrt(strain2) * time);
        expect(waves.strain_rms(interval_us),
               std::sqrt(strain2) *
                   (time + spline_slope_error(one.qx) + spline_slope_error(one.qy)),
               "strain", by_rate);
        EXPECT_TRUE(waves.told_by(interval_us));
    }
    // At the phase step up to which keyframes say something of a wave, and beyond it.
    const double longest_s = hermite_phase_max / one.omega;
    EXPECT_TRUE(waves.told_by(us_from_seconds(0.999 * longest_s)));
    EXPECT_FALSE(waves.told_by(us_from_seconds(1.001 * longest_s)));
}

// Naive: what space counts of a product that nothing counts at the sea's own interval is what rounding left of it, and time is charged
// with its square over that: bounds of thousands of kilometres.
TEST(CascadeWaves, fewer_keyframes_of_a_stylised_wave_state_no_more_than_some_times_both_together) {
    for (const auto& [wavelength_m, sharpness, degrees] :
         {std::tuple(51.2, 10.0, 250), {30.0, 5.0, 20}, {43.0, 3.0, 100}, {25.0, 1.0, 270}}) {
        const Result<Scene> scene = parse_scene(
            fmt::format("[[sea.system]]\ntype = \"sines\"\nshape = \"exponential\"\n"
                        "length_m = 256\nsharpness = {}\ndata = \"\"\"\n"
                        "wavelength_m,amplitude_m,from_deg,phase_rad\n{},0.3,{},0.4\n\"\"\"\n"
                        "[[cascade]]\nlength_m = 256\nsize = 64\n",
                        sharpness, wavelength_m, degrees),
            "one.toml");
        ASSERT_TRUE(scene) << scene.error().message;
        const Result<Realization> sea = realize(*scene);
        ASSERT_TRUE(sea);
        for (const CascadeModes& modes : sea->cascades) {
            const CascadeWaves waves(modes);
            for (const TimeUs interval_us : {50'000, 125'000, 250'000})
                for (int every = 1; every <= 8; ++every) {
                    const MapLoss both = waves.loss(every * interval_us).height;
                    EXPECT_LE(waves.slow_loss(interval_us, every * interval_us).height_m,
                              3.5 * (both.time_m + both.east_m + both.north_m))
                        << wavelength_m << ' ' << interval_us << ' ' << every;
                }
        }
    }
}

} // namespace
} // namespace seaway::sea
