// SPDX-License-Identifier: Apache-2.0
// Waves given one by one: what is asked is what there is, whatever their sign, their place on the
// lattice and the scale of heights.
#include <algorithm>
#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sea/basics/constants.h"
#include "sea/waves/realize.h"
#include "sea/waves/reference.h"
#include "sea/waves/statistics/moments.h"

namespace seaway::sea {
namespace {

constexpr double length_m = 300.0;
constexpr int size = 64;
const CascadeSpec tile{length_m, size};

SeaState sea_of(std::vector<ExplicitMode> modes, double height_scale = 1.0) {
    SeaState sea;
    sea.depth_m = 40.0;
    sea.choppiness = {0, 0};
    sea.height_scale = height_scale;
    sea.systems = {ExplicitModes{length_m, std::move(modes)}};
    return sea;
}

double cosine(const SeaState& sea, const ExplicitMode& mode, double x_m, double y_m, double t_s) {
    const double step = two_pi / length_m;
    return sea.height_scale * mode.amplitude_m *
           std::cos(step * (mode.nx * x_m + mode.ny * y_m) -
                    sea.dispersion().omega(step * std::hypot(mode.nx, mode.ny)) * t_s +
                    mode.phase_rad);
}

// The scale multiplies amplitudes once: in what is asked, in what is drawn and at every point. Waves of
// two amplitudes a_i have Hs = 4 scale sqrt(sum a_i^2 / 2).
TEST(ExplicitWaves, height_scale_multiplies_what_is_requested_and_what_is_realised_once) {
    const std::vector<ExplicitMode> modes{{3, -5, 1.5, 0.3}, {-4, 2, -0.5, -2.0}};
    for (const double scale : {0.5, 1.0, 2.0, 10.0}) {
        const SeaState sea = sea_of(modes, scale);
        const auto realization = std::make_shared<const Realization>(*realize(sea, {&tile, 1}));
        const SeaSummary summary = summarize(sea, *realization);
        const double hs_m = 4 * scale * std::sqrt((1.5 * 1.5 + 0.5 * 0.5) / 2);
        EXPECT_NEAR(summary.requested.significant_height_m, hs_m, 1e-12 * hs_m);
        EXPECT_NEAR(summary.realised.significant_height_m, hs_m, 1e-12 * hs_m);
        const DirectSum sum(realization);
        for (const double t_s : {0.0, 3.25})
            EXPECT_NEAR(sum.at(12.5, -40.0, us_from_seconds(t_s)).height,
                        cosine(sea, modes[0], 12.5, -40.0, t_s) +
                            cosine(sea, modes[1], 12.5, -40.0, t_s),
                        1e-9 * scale);
    }
}

// In a loop every wave turns a whole number of times, without one each has its own period.
TEST(ExplicitWaves, close_the_loop_that_they_are_given) {
    const auto moved_m = [](double loop_s, double t_s) {
        SeaState sea = sea_of({{3, -5, 1.5, 0.3}, {-4, 2, -0.5, -2.0}});
        sea.loop_period_s = loop_s;
        const DirectSum sum(std::make_shared<const Realization>(*realize(sea, {&tile, 1})));
        return std::abs(sum.at(12.5, -40.0, us_from_seconds(t_s)).height -
                        sum.at(12.5, -40.0, 0).height);
    };
    EXPECT_LT(moved_m(29.0, 29.0), 1e-12);
    EXPECT_LT(moved_m(29.0, -58.0), 1e-12);
    EXPECT_GT(moved_m(29.0, 14.0), 0.01);
    EXPECT_GT(moved_m(0.0, 29.0), 0.01);
    // The frequencies themselves are whole in the loop: at the end of it without beginning anew.
    SeaState sea = sea_of({{3, -5, 1.5, 0.3}});
    sea.loop_period_s = 29.0;
    const Realization realization = *realize(sea, {&tile, 1});
    const double turns =
        omega_from_rate(realization.cascades[0].rate[59 * size + 3]) * 29.0 / two_pi;
    EXPECT_NEAR(turns, std::round(turns), 1e-9);
    EXPECT_GT(turns, 1.0);
}

// One wave alone, of every sign, up to the last index before Nyquist: frequencies are stored to 1e-13
// rad/s, so after 1000 s the sum is the cosine to 1e-9.
TEST(ExplicitWaves, one_wave_of_every_sign_is_its_cosine_up_to_the_last_index_before_nyquist) {
    for (const int nx : {0, 1, 3, size / 2 - 1})
        for (const int ny : {0, 5, size / 2 - 1})
            for (const int signs : {0, 1, 2, 3}) {
                if (nx == 0 && ny == 0)
                    continue;
                const ExplicitMode mode{signs & 1 ? -nx : nx, signs & 2 ? -ny : ny, 1.5, 0.3};
                const SeaState sea = sea_of({mode});
                const auto realization = realize(sea, {&tile, 1});
                ASSERT_TRUE(realization) << realization.error().message;
                const DirectSum sum(std::make_shared<const Realization>(*realization));
                for (const double t_s : {0.0, 1000.5})
                    EXPECT_NEAR(sum.at(77.7, -1234.5, us_from_seconds(t_s)).height,
                                cosine(sea, mode, 77.7, -1234.5, t_s), 1e-9)
                        << mode.nx << ", " << mode.ny;
            }
}

// On Nyquist a wave and its opposite are the same points of the grid: its direction is lost, and the
// transforms leave that row and column out. So it is refused, in either sign and on either axis.
TEST(ExplicitWaves, a_wave_exactly_on_nyquist_is_refused_and_the_error_names_index_and_limit) {
    for (const ExplicitMode& mode :
         {ExplicitMode{size / 2, 1, 1, 0}, ExplicitMode{-size / 2, 1, 1, 0},
          ExplicitMode{1, size / 2, 1, 0}, ExplicitMode{1, -size / 2, 1, 0},
          ExplicitMode{size / 2, size / 2, 1, 0}}) {
        const auto refused = realize(sea_of({mode}), {&tile, 1});
        ASSERT_FALSE(refused) << mode.nx << ", " << mode.ny;
        EXPECT_EQ(
            refused.error().message,
            "sea.system[1]: explicit waves reach lattice index 32, but the cascade of length_m = "
            "300 has size = 64 and holds 31 at most");
    }
}

// A tile that is made for a wave holds it well below Nyquist, where it is also sampled well.
TEST(ExplicitWaves, a_tile_that_is_added_keeps_its_waves_below_the_band_end) {
    const CascadeSpec other{1000.0, 64};
    for (const int steps : {1, 19, 20, 38, 39, 153, 154, explicit_steps_max}) {
        const auto realization = realize(sea_of({{-steps, 1, 1.0, 0.0}}), {&other, 1});
        ASSERT_TRUE(realization) << realization.error().message;
        const CascadeModes& added = realization->cascades[1];
        EXPECT_EQ(added.spec.length_m, length_m);
        EXPECT_LE(steps, band_end_share_of_nyquist * added.spec.size / 2);
        EXPECT_LE(added.spec.size, 1024);
    }
}

// A tile that is added for waves holds all of them, also those at its lattice's corners.
TEST(ExplicitWaves, the_band_of_a_tile_that_is_added_holds_every_wave_of_it) {
    for (const int steps : {1, 2, 7, 30}) {
        const std::vector<ExplicitMode> modes{
            {steps, steps, 0.1, 0}, {-steps, steps, 0.1, 0}, {0, 1, 0.1, 0}, {1, 0, 0.1, 0}};
        SeaState sea = sea_of(modes);
        const CascadeSpec other{77.0, size};
        const Realization realization = *realize(sea, {&other, 1});
        ASSERT_EQ(realization.cascades.size(), 2u);
        const CascadeModes& added = realization.cascades[0]; // the longer one
        ASSERT_EQ(added.spec.length_m, length_m);
        for (const ExplicitMode& mode : modes)
            EXPECT_TRUE(added.band.contains(two_pi / length_m * std::hypot(mode.nx, mode.ny)))
                << mode.nx << ", " << mode.ny;
    }
}

} // namespace
} // namespace seaway::sea
