// SPDX-License-Identifier: Apache-2.0
// The numbers behind the picture of a scene: points of the realised spectrum and waves given one by one.
#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "sea/scene/scene.h"
#include "tools/inspect/curves.h"

namespace seaway::inspect {
namespace {

constexpr double tile_m = 400;
constexpr int tile_size = 64;

sea::CascadeModes empty_tile() {
    sea::CascadeModes modes;
    modes.spec = {tile_m, tile_size};
    modes.band = {0, modes.spec.nyquist_radpm()};
    modes.h0.resize(tile_size * tile_size);
    modes.rate.resize(tile_size * tile_size);
    return modes;
}
std::size_t at(int nx, int ny) {
    return static_cast<std::size_t>((ny + tile_size) % tile_size * tile_size +
                                    (nx + tile_size) % tile_size);
}

// A mode of h0 is a wave of amplitude 2 |h0|, half the square of which is its energy. Rings are a step
// wide up to the tenth, then a tenth of their wavenumber.
TEST(Curves, a_point_of_the_realised_spectrum_is_the_energy_of_its_ring_over_its_frequencies) {
    const sea::Dispersion water = sea::SeaState{.depth_m = 30}.dispersion();
    const double step = 2 * sea::pi / tile_m;
    const auto omega = [&](double steps) { return water.omega(steps * step); };
    struct Row {
        int nx, ny;
        double lo, hi; ///< of its ring, steps
    };
    for (const Row& row : {Row{0, -1, 0.5, 1.5},
                           {-3, 4, 4.5, 5.5},
                           {9, 0, 8.5, 9.5},
                           {-10, -3, 9.5, 11.5},
                           {20, 6, 19.5, 22.5}}) {
        sea::CascadeModes modes = empty_tile();
        modes.h0[at(row.nx, row.ny)] = {0.3, -0.4};
        const std::vector<plot::Point> points = realised_density(modes, water);
        ASSERT_EQ(points.size(), 1u) << row.nx << ", " << row.ny;
        EXPECT_NEAR(points[0].x, omega((row.lo + row.hi) / 2), 1e-12);
        EXPECT_NEAR(points[0].y, 0.5 / (omega(row.hi) - omega(row.lo)), 1e-9) << row.nx;
    }
    // Of a ring that the band cuts, the part inside holds the energy; a sliver says nothing.
    sea::CascadeModes modes = empty_tile();
    modes.h0[at(5, 0)] = 0.5;
    modes.band = {4.8 * step, 60 * step};
    const std::vector<plot::Point> cut = realised_density(modes, water);
    ASSERT_EQ(cut.size(), 1u);
    EXPECT_NEAR(cut[0].x, omega((4.8 + 5.5) / 2), 1e-12);
    EXPECT_NEAR(cut[0].y, 0.5 / (omega(5.5) - omega(4.8)), 1e-9);
    modes.band.k_lo_radpm = 5.2 * step;
    EXPECT_TRUE(realised_density(modes, water).empty());
}

// One seed scatters: rings below the peak hold some waves of any size. Many seeds together lie on the
// spectrum, on the steep front as well. A ring has up to a third more or fewer modes than its area, as
// points of a lattice fall; and a mode carries what its square cell holds, not its ring.
TEST(Curves, points_of_many_seeds_lie_on_the_spectrum_of_their_rings) {
    const auto scene_of = [](int seed) {
        return sea::parse_scene(
                   fmt::format("[sea]\nseed = {}\n[[sea.system]]\ntype = \"swell\"\n"
                               "significant_height_m = 3\npeak_period_s = 9\nfrom_deg = 75\n"
                               "[[cascade]]\nlength_m = 600\nsize = 64\n",
                               seed),
                   "curves", "")
            .value();
    };
    const sea::Scene first = scene_of(1);
    const sea::Dispersion water = first.sea.dispersion();
    const SeaSpectrum spectrum(first.sea);
    constexpr int seeds = 200;
    std::vector<plot::Point> sums;
    for (int seed = 1; seed <= seeds; ++seed) {
        const std::vector<plot::Point> points =
            realised_density(sea::realize(scene_of(seed)).value().cascades[0], water);
        sums.resize(points.size());
        for (std::size_t i = 0; i < points.size(); ++i)
            sums[i] = {points[i].x, sums[i].y + points[i].y / seeds};
    }
    ASSERT_GT(sums.size(), 10u);
    // The first lies where the spectrum is a ten-thousandth of a millionth of its peak: cells reach out of it.
    EXPECT_GT(sums[0].y, spectrum.kept_density(sums[0].x));
    for (std::size_t i = 1; i < 9; ++i) { // rings of one step each: n = 2 .. 9; the peak is at 6
        const double n = static_cast<double>(i + 1);
        double mean = 0;
        for (int s = 0; s < 100; ++s)
            mean += spectrum.kept_density(
                        water.omega((n - 0.5 + (s + 0.5) / 100) * 2 * sea::pi / 600)) /
                    100;
        EXPECT_NEAR(std::log(sums[i].y / mean), 0, 0.4) << "ring " << n;
    }
}

// From below the lowest peak or the longest tile to beyond the highest peak or the finest tile.
TEST(Curves, the_picture_reaches_from_below_the_lowest_peak_to_beyond_the_highest) {
    Report report;
    report.scene = sea::parse_scene("[sea]\n[[sea.system]]\ntype = \"swell\"\n"
                                    "significant_height_m = 1\npeak_period_s = 3\nfrom_deg = 75\n"
                                    "[[sea.system]]\ntype = \"swell\"\n"
                                    "significant_height_m = 2\npeak_period_s = 14\nfrom_deg = 10\n"
                                    "[[cascade]]\nlength_m = 6000\nsize = 64\n",
                                    "curves", "")
                       .value();
    report.sea = std::make_shared<const sea::Realization>(sea::realize(report.scene).value());
    const FrequencyRange range = frequency_range(report, SeaSpectrum(report.scene.sea));
    EXPECT_NEAR(range.lo_radps, 0.45 * 2 * sea::pi / 14, 1e-9);
    EXPECT_NEAR(range.hi_radps, 3 * 2 * sea::pi / 3, 1e-9);
}

TEST(Curves, waves_given_by_hand_have_their_amplitude_direction_and_frequency) {
    const sea::Scene scene =
        sea::parse_scene(
            "[sea]\ndepth_m = 20\nheight_scale = 2\n[[sea.system]]\ntype = \"modes\"\n"
            "length_m = 200\ndata = \"\"\"\nnx,ny,amplitude_m,phase_rad\n3,-2,0.4,0.7\n"
            "-1,5,-0.25,0\n\"\"\"\n[[cascade]]\nlength_m = 200\nsize = 64\n",
            "curves", "")
            .value();
    std::vector<ExplicitWave> waves = explicit_waves(sea::realize(scene).value());
    ASSERT_EQ(waves.size(), 2u);
    std::sort(waves.begin(), waves.end(),
              [](const auto& a, const auto& b) { return a.amplitude_m > b.amplitude_m; });
    const sea::Dispersion water = scene.sea.dispersion();
    struct Row {
        int nx, ny;
        double amplitude_m;
    };
    const Row rows[] = {{3, -2, 0.8}, {-1, 5, 0.5}};
    for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_NEAR(waves[i].amplitude_m, rows[i].amplitude_m, 1e-12);
        EXPECT_NEAR(waves[i].towards_rad, std::atan2(rows[i].ny, rows[i].nx), 1e-12);
        EXPECT_NEAR(waves[i].omega_radps,
                    water.omega(2 * sea::pi / 200 * std::hypot(rows[i].nx, rows[i].ny)), 1e-9);
    }
}

} // namespace
} // namespace seaway::inspect
