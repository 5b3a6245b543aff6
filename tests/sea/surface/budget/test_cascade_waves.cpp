// SPDX-License-Identifier: Apache-2.0
// What is known of the waves of a cascade: every figure of one oblique wave by hand, in shallow water.
#include <cmath>

#include <gtest/gtest.h>

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

void expect(double found, double expected, const char* what) {
    EXPECT_NEAR(found, expected, 1e-9 * std::abs(expected)) << what;
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

TEST(CascadeWaves, what_is_missed_between_keyframes_is_hermites_law_of_the_frequency) {
    const ObliqueWave one;
    const CascadeWaves& waves = one.waves;
    const double k = one.k, omega = one.omega, variance = one.variance, aspect = one.aspect;
    // Missed between keyframes, in the middle of the two.
    for (const double interval_s : {0.2, 0.5}) {
        const TimeUs interval_us = us_from_seconds(interval_s);
        const double missed = std::sqrt(variance) * hermite_error(omega * interval_s);
        const CascadeLoss loss = waves.loss(interval_us);
        EXPECT_NEAR(loss.height.time_m, missed, 1e-6 * missed);
        EXPECT_NEAR(loss.displacement.time_m, missed * aspect, 1e-6 * missed);
        expect(loss.height.east_m, std::sqrt(waves.height().east_m2), "east");
        expect(loss.height.north_m, std::sqrt(waves.height().north_m2), "north");
        expect(loss.displacement.east_m, std::sqrt(waves.displacement().east_m2), "east");
        expect(loss.displacement.north_m, std::sqrt(waves.displacement().north_m2), "north");
        EXPECT_EQ(loss.height.value_m + loss.height.rate_mps, 0) << "nothing is coded";
        EXPECT_NEAR(waves.time_strain_rms(interval_us), missed * aspect * k, 1e-6 * missed * k);
        expect(waves.strain_rms(interval_us),
               std::sqrt(std::pow(waves.time_strain_rms(interval_us), 2) + waves.strain().east_m2 +
                         waves.strain().north_m2),
               "strain");
        EXPECT_TRUE(waves.told_by(interval_us));
    }
    // At the phase step up to which keyframes say something of a wave, and beyond it.
    const double longest_s = hermite_phase_max / omega;
    EXPECT_TRUE(waves.told_by(us_from_seconds(0.999 * longest_s)));
    EXPECT_FALSE(waves.told_by(us_from_seconds(1.001 * longest_s)));
}

} // namespace
} // namespace seaway::sea
