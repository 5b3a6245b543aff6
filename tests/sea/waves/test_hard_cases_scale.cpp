// SPDX-License-Identifier: Apache-2.0
// Hard cases of hard_cases.md, section I, that no other test bears the id of. Each says what naive
// code does.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sea/scene/scene.h"
#include "sea/spectrum/spectra.h"
#include "sea/waves/statistics/moments.h"
#include "tests/sea/scene_of.h"
#include "tests/sea/sea_fixture.h"

namespace seaway::sea {
namespace {

using ::testing::HasSubstr;
using testing::hs_of;
using testing::realized;
using testing::three_cascades;
using testing::windy_sea;

// Naive: float sums of many cascades depend on their order.
TEST(HardCase, I4_eight_cascades_sum_the_same_in_any_order) {
    std::vector<CascadeSpec> tiles;
    for (double length = 2000.0; tiles.size() < 8; length /= 2.3)
        tiles.push_back({length, 32});
    const auto sea = realized(windy_sea(), tiles);
    auto reversed = std::make_shared<Realization>(*sea);
    std::reverse(reversed->cascades.begin(), reversed->cascades.end());
    for (int i = 0; i < 20; ++i)
        EXPECT_NEAR(DirectSum(sea).at(13.0 * i, 5.0, 0).height,
                    DirectSum(reversed).at(13.0 * i, 5.0, 0).height, 1e-12);
}

// Naive: a band that starts at n = 1 has a handful of waves and a visible checker.
TEST(HardCase, I5_every_band_but_the_first_starts_with_enough_directions) {
    const auto sea = realized(windy_sea(), {{1021.0, 256}, {197.0, 256}, {37.0, 256}});
    for (std::size_t c = 1; c < sea->cascades.size(); ++c) {
        const CascadeModes& modes = sea->cascades[c];
        EXPECT_GE(modes.band.k_lo_radpm, 0.999 * 6.0 * modes.spec.wavenumber_step_radpm());
        int waves = 0;
        for (const auto& h0 : modes.h0)
            waves += h0 != 0.0;
        EXPECT_GT(waves, 500);
    }
}

// Naive: land is a negative depth and NaN. Here depth is one number above 0 for the whole sea, and
// seas of neighbouring depths, which are blended, differ little.
TEST(HardCase, I6_depth_is_positive_and_the_sea_continuous_in_it) {
    for (const char* land : {"0", "-5", "nan"})
        EXPECT_THAT(testing::error_of(std::string("[sea]\ndepth_m = ") + land + "\n"),
                    HasSubstr("depth_m"));
    for (const double depth_m : {1.0, 3.0, 10.0, 30.0, 100.0}) {
        SeaState state = windy_sea(), deeper = windy_sea();
        state.depth_m = depth_m;
        deeper.depth_m = 1.001 * depth_m;
        const RealizationPtr sea = realized(state, three_cascades);
        const DirectSum here(sea), there(realized(deeper, three_cascades));
        // Frequencies differ by kd / sinh(2 kd) in a thousand, at most by 0.25e-3 sqrt(g / d), and phases by that times t. Amplitudes
        // differ by less than half a percent: S is steep on the front of the peak, and circles of energy meet other cells.
        // Five standard deviations of both.
        for (const double t_s : {0.0, 10.0, 100.0}) {
            const double turned_rad = 0.25e-3 * std::sqrt(9.81 / depth_m) * t_s;
            for (int place = 0; place < 12; ++place) {
                const double x_m = 137.0 * place - 300, y_m = 41.0 * place * place;
                EXPECT_NEAR(here.at(x_m, y_m, us_from_seconds(t_s)).height,
                            there.at(x_m, y_m, us_from_seconds(t_s)).height,
                            5 * (0.005 + turned_rad) * hs_of(sea) / 4)
                    << depth_m << ' ' << t_s << ' ' << place;
            }
        }
    }
}

// Naive: a 3 % tolerance on one tile fails 60 % of correct seeds.
TEST(HardCase, I8_a_correct_sea_fails_the_gate_of_3_standard_errors_in_under_1_percent_of_seeds) {
    const CascadeSpec tile{500.0, 64};
    const SeaState state = windy_sea();
    const Band band = assign_bands(std::vector{tile})->front();
    const double scatter = summarize(state, *realized(state, {tile})).cascades[0].expected_scatter;
    const Dispersion d = state.dispersion();
    const double expected = 4.0 * std::sqrt(requested_variance(state, d.omega(band.k_lo_radpm),
                                                               d.omega(band.k_hi_radpm)));
    int failures = 0;
    double sum = 0.0, squares = 0.0;
    for (std::uint64_t seed = 5000; seed < 5200; ++seed) {
        const auto sea = realized(windy_sea(seed), {tile});
        const CascadeModes& modes = sea->cascades[0];
        double m0 = 0.0; // of this instant: sum |h(k,0)|^2
        for (int i = 0; i < 64 * 64; ++i) {
            const int mirror = (64 - i / 64) % 64 * 64 + (64 - i % 64) % 64;
            m0 += std::norm(modes.h0[static_cast<std::size_t>(i)] +
                            std::conj(modes.h0[static_cast<std::size_t>(mirror)]));
        }
        const double height = 4.0 * std::sqrt(m0) / expected;
        sum += height / 200.0;
        squares += height * height / 200.0;
        failures += std::abs(height - 1.0) > 3.0 * scatter;
    }
    EXPECT_LE(failures, 2);
    EXPECT_NEAR(sum, 1.0, 3.0 * scatter / std::sqrt(200.0) + 0.005); // lattice: I1
    // A gate that is too wide would fail none: the scatter that is stated is that of these heights. Of 200 draws it is known
    // to 1 / sqrt(2 * 199) = 5 %, and 15 % are three of these.
    EXPECT_NEAR(std::sqrt(squares - sum * sum) / scatter, 1.0, 0.15);
}

// Naive: fetch in kilometres here, metres there. The laws scale: gravity times c and lengths alike.
TEST(HardCase, I9_a_sea_scales_with_its_units) {
    const auto small = FrequencySpectrum::jonswap_by_wind(10.0, 1e5, 3.3, 9.81);
    // Lengths times 4, times times 2, speeds times 2: the same sea, four times as large.
    const auto large = FrequencySpectrum::jonswap_by_wind(20.0, 4e5, 3.3, 9.81);
    EXPECT_NEAR(large.peak_omega_radps() * 2.0 / small.peak_omega_radps(), 1.0, 1e-12);
    // S is m2 s: 16 * 2.
    EXPECT_NEAR(large.density(0.4) / (32.0 * small.density(0.8)), 1.0, 1e-12);
    // The same by gravity: times c, times shrink by sqrt(c).
    const auto heavy = FrequencySpectrum::jonswap_by_wind(20.0, 1e5, 3.3, 4 * 9.81);
    EXPECT_NEAR(heavy.density(1.6) * 2.0 / small.density(0.8), 1.0, 1e-12);
}

// Naive: 2048 x 8 cascades are allocated and the server dies.
TEST(HardCase, I10_sizes_that_no_machine_should_hold_are_refused_by_name) {
    std::string nine = "[sea]\n";
    for (int i = 0; i < 9; ++i)
        nine += "[[cascade]]\nlength_m = " + std::to_string(5000 >> i) + "\nsize = 64\n";
    EXPECT_THAT(parse_scene(nine, "s", "").error().message, HasSubstr("at most 8"));
    EXPECT_THAT(parse_scene("[sea]\n[[cascade]]\nlength_m=9\nsize=4096\n", "s", "").error().message,
                HasSubstr("16 .. 2048"));
    EXPECT_FALSE(parse_scene(std::string((1u << 20) + 1, ' '), "s", ""));
}

} // namespace
} // namespace seaway::sea
