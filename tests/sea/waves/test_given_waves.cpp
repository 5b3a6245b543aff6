// SPDX-License-Identifier: Apache-2.0
// What is told of seas that have waves given one by one beside those that are drawn from spectra.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sea/waves/realize.h"
#include "sea/waves/statistics/moments.h"
#include "tests/sea/sea_fixture.h"

namespace seaway::sea {
namespace {

constexpr double tile_m = 1021.0;
const std::vector<CascadeSpec> two_tiles{{tile_m, 128}, {97.0, 64}};

/// A mode of 2 m on the first tile, (nx, 0), and a narrow swell beside it.
SeaState mixed(int nx, double height_m, double period_s, std::uint64_t seed = 1) {
    SeaState state = testing::swell_sea(height_m, period_s, 0.3, 300);
    state.seed = seed;
    state.systems.emplace_back(ExplicitModes{.length_m = tile_m, .modes = {{nx, 0, 2.0, 0.0}}});
    return state;
}

// Of 2.0156 m2 0.0156 are drawn, some of them of the given wave's own wavenumber, with which they add up by their phases. Naive: 9 %, which
// is what the swell alone scatters by. The standard error of a standard deviation of 40 seeds is 11 %; the stated one is at an instant, over
// time a sea scatters by up to sqrt(2) less.
TEST(GivenWaves, scatter_from_seed_to_seed_no_more_than_what_is_drawn_beside_them) {
    double sum = 0, squares = 0;
    constexpr int seeds = 40;
    for (int seed = 1; seed <= seeds; ++seed) {
        const SeaState state = mixed(8, 0.5, 9, static_cast<std::uint64_t>(seed));
        const double height_m =
            summarize(state, *testing::realized(state, two_tiles)).realised.significant_height_m;
        sum += height_m;
        squares += height_m * height_m;
    }
    const double mean = sum / seeds;
    const double found = std::sqrt(squares / seeds - mean * mean) / mean;
    const SeaState state = mixed(8, 0.5, 9);
    const double stated = hs_scatter(summarize(state, *testing::realized(state, two_tiles)));
    EXPECT_LT(stated, 0.002);
    EXPECT_GT(found, stated / std::numbers::sqrt2 * (1 - 3 * 0.11));
    EXPECT_LT(found, stated * (1 + 3 * 0.11));
}

TEST(GivenWaves, are_the_peak_where_they_hold_more_than_spectra_do_around_theirs) {
    const auto peak_s = [](const SeaState& state) {
        return summarize(state, *testing::realized(state, two_tiles)).requested.peak_period_s;
    };
    const double given_s =
        2 * pi / SeaState{}.dispersion().omega(2 * 2 * pi / tile_m); // (2, 0): 510 m
    EXPECT_NEAR(given_s, 18.08, 0.01);
    EXPECT_NEAR(peak_s(mixed(2, 0.5, 5)), given_s, 1e-9);
    // Of a swell of 20 m, 25 m2 in all, a third is within a tenth around its peak.
    EXPECT_NEAR(peak_s(mixed(2, 20, 12)), 12, 1e-6);
}

TEST(GivenWaves, are_asked_for_and_expected_on_their_tile) {
    const SeaState state = mixed(8, 0.5, 9);
    const SeaSummary summary = summarize(state, *testing::realized(state, two_tiles));
    double asked_m2 = summary.lost_below_m2 + summary.lost_above_m2 + summary.lost_fade_m2;
    for (const CascadeVariance& tile : summary.cascades) {
        asked_m2 += tile.requested_m2;
        EXPECT_NEAR(tile.expected_m2, tile.requested_m2, 0.002)
            << "what the lattice takes of a swell";
    }
    EXPECT_GT(summary.cascades[0].requested_m2, 2.0);
    EXPECT_LT(summary.cascades[1].requested_m2, 0.01);
    EXPECT_NEAR(asked_m2, std::pow(summary.requested.significant_height_m / 4, 2), 1e-6);
}

// w2 grows as k3 there, and the energy falls as k-3. Naive: a period that says how far an integral went, a third of what is drawn.
TEST(GivenWaves, of_phillips_with_surface_tension_the_period_is_that_of_the_waves_in_the_bands) {
    SeaState state;
    WindSea wind;
    wind.spectrum = SpectrumKind::phillips;
    wind.wind_speed_10m_mps = 1;
    state.systems.emplace_back(wind);
    const std::vector<CascadeSpec> tiles{{20.0, 128}, {1.3, 128}};
    const SeaSummary summary = summarize(state, *testing::realized(state, tiles));
    // One seed's scatters by some percent.
    EXPECT_NEAR(summary.requested.zero_crossing_period_s / summary.realised.zero_crossing_period_s,
                1, 0.1);
}

} // namespace
} // namespace seaway::sea
