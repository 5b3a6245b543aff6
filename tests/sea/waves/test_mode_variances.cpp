// SPDX-License-Identifier: Apache-2.0
// The energy that a lattice carries on average over seeds is the spectrum's, however narrow it is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "sea/scene/scene.h"
#include "sea/waves/mode_variances.h"
#include "sea/waves/statistics/moments.h"
#include "tests/sea/scene_of.h"
#include "tests/sea/sea_fixture.h"

namespace seaway::sea {
namespace {

using testing::realized;
using testing::scene_of;
using testing::swell_sea;
using testing::windy_sea;

const std::vector<CascadeSpec> default_tiles{{1021.0, 256}, {197.0, 256}, {37.0, 256}};

/// Energy in one bin, Hs 2 m.
SeaState one_bin(double width_hz, double towards_rad = 0.0, double frequency_hz = 0.08) {
    SeaState state;
    MeasuredSea measured;
    measured.spectrum = std::make_shared<const MeasuredSpectrum>(
        *parse_measured("f_hz,df_hz,s_m2_hz\n" + std::to_string(frequency_hz) + "," +
                            std::to_string(width_hz) + "," + std::to_string(0.25 / width_hz) + "\n",
                        "one bin"));
    measured.towards_rad = towards_rad;
    measured.spreading.exponent = 30.0;
    state.systems.emplace_back(measured);
    return state;
}

SeaState narrow_swell(double towards_rad, double exponent = 75.0) {
    SeaState state = swell_sea(2.0, 10.0, towards_rad, exponent);
    std::get<Swell>(state.systems[0]).gamma = 7.0;
    return state;
}

/// Tile of so many peak wavelengths of a swell of 10 s.
std::vector<CascadeSpec> tile_of(double wavelengths) {
    return {{wavelengths * two_pi / Dispersion{}.wavenumber(two_pi / 10.0), 64}};
}

/// Expected m0 over the requested one, within the bands.
double ratio(const SeaState& state, const std::vector<CascadeSpec>& tiles) {
    const SeaSummary summary = summarize(state, *realized(state, tiles));
    double expected = 0, requested = 0;
    for (const CascadeVariance& cascade : summary.cascades) {
        expected += cascade.expected_m2;
        requested += cascade.requested_m2;
    }
    return expected / requested;
}

// Sampled at the modes themselves these were 1.49, 0, 0.67 and 1.26.
TEST(ModeVariances, expected_energy_of_narrow_seas_is_the_requested_within_1_in_a_thousand) {
    for (const double towards : {0.0, 0.3, 0.7}) {
        EXPECT_NEAR(ratio(one_bin(0.005, towards), default_tiles), 1.0, 1e-3);
        EXPECT_NEAR(ratio(one_bin(0.001, towards), default_tiles), 1.0, 1e-3);
        // 21 steps out and a quarter of a step wide: between the rings of the modes.
        EXPECT_NEAR(ratio(one_bin(0.001, towards, 0.18), default_tiles), 1.0, 1e-3);
        for (const double wavelengths : {1.5, 1.9, 3.0, 8.0})
            EXPECT_NEAR(ratio(narrow_swell(towards), tile_of(wavelengths)), 1.0, 1e-3)
                << wavelengths;
        EXPECT_NEAR(ratio(narrow_swell(towards, 1e6), tile_of(8.0)), 1.0, 1e-3);
    }
}

// Two of 220 swells drawn at random that lose the most: 2.6e-3 of the cascade's energy, where a steep
// front counts as smooth.
TEST(ModeVariances, the_worst_of_many_random_swells_keep_their_energy_within_3_in_a_thousand) {
    SeaState first = swell_sea(2.0, 2.810060467101369);
    first.depth_m = 51.3451174119983;
    Swell& steep = std::get<Swell>(first.systems[0]);
    steep.gamma = 14.173661713256413;
    steep.spreading.kind = SpreadingKind::donelan_banner;
    steep.towards_rad = 0.261;
    EXPECT_NEAR(ratio(first, {{520.8802385126796, 128}, {75.5311928734308, 128}}), 1.0, 3e-3);
    SeaState second = swell_sea(2.0, 2.7559454574120696);
    second.depth_m = 1.7483144233132175;
    Swell& shallow = std::get<Swell>(second.systems[0]);
    shallow.spectrum = SpectrumKind::tma;
    shallow.gamma = 4.87760271003272;
    shallow.spreading.kind = SpreadingKind::cos2_hasselmann;
    shallow.spreading.narrow_share = 0.68;
    EXPECT_NEAR(ratio(second, {{2071.72201237773, 128}, {386.96644108504444, 128}}), 1.0, 3e-3);
}

TEST(ModeVariances, cut_offs_and_band_edges_lose_nothing) {
    SeaState cut = narrow_swell(0.2, 10.0);
    for (const double k_max : {0.03, 0.0415, 0.1})
        for (const double k_min : {0.0, 0.02}) {
            cut.wavenumber_max_radpm = k_max;
            cut.wavenumber_min_radpm = k_min;
            EXPECT_NEAR(ratio(cut, default_tiles), 1.0, 1e-3) << k_min << " .. " << k_max;
        }
    // A peak on the seam of two cascades: 6 steps of the second tile.
    const double k = Dispersion{}.wavenumber(two_pi / 10.0);
    EXPECT_NEAR(ratio(narrow_swell(0.2), {{2000.0, 256}, {6.001 * two_pi / k, 64}}), 1.0, 1e-3);
}

/// Each cell by brute force: 60 x 60 points of it.
TEST(ModeVariances, of_a_cell_is_the_integral_of_psi_over_it) {
    const SeaState state = windy_sea();
    const DirectionalSpectrum spectrum(state.systems[0], state);
    const CascadeSpec tile{300.0, 64};
    const Band band = assign_bands(std::vector{tile})->front();
    const std::vector<double> variances = mode_variances(spectrum, tile, band);
    const double total = std::accumulate(variances.begin(), variances.end(), 0.0);
    const double step = tile.wavenumber_step_radpm();
    for (const auto& [nx, ny] :
         {std::pair{2, 1}, {4, 0}, {3, 3}, {5, -2}, {9, 4}, {-2, 3}, {14, 6}}) {
        double sum = 0;
        const int n = 60;
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j)
                sum += spectrum.density(step * (nx - 0.5 + (i + 0.5) / n),
                                        step * (ny - 0.5 + (j + 0.5) / n));
        const double truth = sum * step * step / (n * n);
        const double got =
            variances[static_cast<std::size_t>((ny + 64) % 64 * 64 + (nx + 64) % 64)];
        // Six circles cross a cell: 3 %; cells of little energy count less.
        EXPECT_NEAR(got, truth, 0.03 * truth + 1e-4 * total) << nx << ", " << ny;
    }
}

TEST(ModeVariances, of_60_seeds_a_swell_of_one_bin_has_its_energy_within_3_standard_errors) {
    std::vector<double> energies;
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        SeaState state = one_bin(0.005);
        state.seed = seed;
        energies.push_back(testing::energy_of(realized(state, {default_tiles[0]})->cascades[0]));
    }
    const double mean = std::accumulate(energies.begin(), energies.end(), 0.0) / 60.0;
    double variance = 0;
    for (const double e : energies)
        variance += (e - mean) * (e - mean) / 59.0;
    EXPECT_NEAR(mean, 0.25, 3.0 * std::sqrt(variance / 60.0));
}

TEST(ModeVariances, nothing_lies_outside_the_band) {
    const SeaState state = windy_sea();
    const auto bands = *assign_bands(default_tiles);
    const DirectionalSpectrum spectrum(state.systems[0], state);
    for (std::size_t c = 0; c < bands.size(); ++c) {
        const std::vector<double> variances = mode_variances(spectrum, default_tiles[c], bands[c]);
        const double step = default_tiles[c].wavenumber_step_radpm();
        for (int i = 0; i < 256 * 256; ++i)
            if (!bands[c].contains(
                    step * std::hypot(signed_index(i % 256, 256), signed_index(i / 256, 256)))) {
                ASSERT_EQ(variances[static_cast<std::size_t>(i)], 0.0);
            }
    }
}

// What a lattice cannot do is said: the beam below is 1.5 cells from the origin and half a cell wide.
TEST(ModeVariances, what_few_waves_do_to_direction_and_spread_is_stated) {
    const SeaState coarse = narrow_swell(0.3);
    const SeaSummary summary = summarize(coarse, *realized(coarse, tile_of(1.5)));
    ASSERT_EQ(summary.lattice.size(), 1u);
    EXPECT_NEAR(summary.lattice[0].energy, 1.0, 1e-3);
    // The same from the seeds themselves.
    double east = 0, north = 0;
    for (std::uint64_t seed = 0; seed < 400; ++seed) {
        SeaState state = coarse;
        state.seed = seed;
        const auto sea = realized(state, tile_of(1.5));
        for (int i = 0; i < 64 * 64; ++i) {
            const double e = std::norm(sea->cascades[0].h0[static_cast<std::size_t>(i)]);
            const double nx = signed_index(i % 64, 64), ny = signed_index(i / 64, 64);
            if (e > 0) {
                east += e * nx / std::hypot(nx, ny);
                north += e * ny / std::hypot(nx, ny);
            }
        }
    }
    // 400 seeds of some four modes: 3 standard errors of the direction are 0.03 rad.
    EXPECT_NEAR(std::atan2(north, east), 0.3 + summary.lattice[0].turned_rad, 0.03);
    EXPECT_GT(std::abs(summary.lattice[0].spread - 1.0), 0.01);
    // On a tile of 16 wavelengths direction and spread are within 1 %.
    const SeaState fine = narrow_swell(0.3);
    const SeaSummary good = summarize(fine, *realized(fine, tile_of(16.0)));
    EXPECT_NEAR(good.lattice[0].turned_rad, 0.0, 0.003);
    EXPECT_NEAR(good.lattice[0].spread, 1.0, 0.01);
}

// T30. Two seas whose waves against each other are known: as many either way, and none. Naive: the
// mirror of mode i is N - 1 - i, which is its neighbour's.
TEST(ModeVariances, scatter_counts_a_wave_together_with_the_one_against_it) {
    const CascadeSpec tile{200.0, 64}; // two wavelengths: energy differs from mode to mode
    const Band band = assign_bands(std::vector{tile})->front();
    for (const bool either_way : {true, false}) {
        SeaState sea = swell_sea(2.0, 8.0);
        SpreadingModel& spreading = std::get<Swell>(sea.systems[0]).spreading;
        spreading.kind = SpreadingKind::cos2; // nothing beyond 90 degrees
        spreading.isotropic = either_way ? 1.0 : 0.0;
        double sum = 0.0, squares = 0.0;
        for (const double v :
             mode_variances(DirectionalSpectrum(sea.systems[0], sea), tile, band)) {
            sum += v;
            squares += v * v;
        }
        // sqrt(2 sum E^2) / (2 sum E), E the mean of both: v, or v / 2 at either. Cells of k and -k are
        // cut alike to 1e-4.
        const double expected = std::sqrt((either_way ? 2.0 : 1.0) * squares) / (2.0 * sum);
        const double told = summarize(sea, *realized(sea, {tile})).cascades[0].expected_scatter;
        EXPECT_NEAR(told / expected, 1.0, 1e-3);
    }
}

// Naive: the quadrature looks closely where the waves go, and not at the beam against them: along an axis, where cells meet,
// a narrow one falls between its nodes.
TEST(ModeVariances, a_narrow_beam_of_waves_both_ways_has_half_of_its_energy_either_way) {
    for (const double s : {2.0, 75.0, 300.0, 1000.0}) {
        const SeaState sea =
            testing::scene_of(
                fmt::format("[sea]\n[[sea.system]]\ntype=\"wind\"\nspectrum=\"phillips\"\n"
                            "wind_speed_10m_mps=8\nfrom_deg=270\nsignificant_height_m=1.5\n"
                            "phillips_upwind=true\nspreading=\"cos2s\"\n"
                            "spreading_exponent={}\n",
                            s))
                .sea;
        const CascadeSpec spec{60, 64}; // the peak is two steps out
        const std::vector<double> variances =
            mode_variances(DirectionalSpectrum(sea.systems[0], sea), spec, {0.06, 3});
        double with = 0, against = 0;
        for (int iy = 0; iy < spec.size; ++iy)
            for (int ix = 0; ix < spec.size; ++ix)
                if (const int nx = signed_index(ix, spec.size); nx != 0)
                    (nx > 0 ? with : against) +=
                        variances[static_cast<std::size_t>(iy * spec.size + ix)];
        EXPECT_NEAR(against / (with + against), 0.5, 1e-3) << s;
    }
}

// Naive: as far as a thousand peaks in frequency. Phillips' law is of wavenumbers, and shallow water gives short waves low ones.
TEST(ModeVariances, what_is_told_of_phillips_in_a_puddle_counts_its_short_waves) {
    const Scene scene =
        scene_of("[sea]\ndepth_m=0.1\nsurface_tension=false\n[[sea.system]]\ntype="
                 "\"wind\"\nspectrum=\"phillips\"\n"
                 "wind_speed_10m_mps=30\nfrom_deg=1\n[[cascade]]\nlength_m=70\nsize=512\n"
                 "[[cascade]]\nlength_m=2\nsize=256\n");
    const SeaSummary summary = summarize(scene.sea, *realize(scene));
    for (const auto& cascade : summary.cascades)
        EXPECT_NEAR(cascade.requested_m2 / cascade.expected_m2, 1.0, 0.05);
    EXPECT_GT(summary.cascades.back().requested_m2, 0.0);
}

// From the bearing of 217 degrees: towards 37, which is 53 degrees anticlockwise from east.
TEST(ModeVariances, phillips_goes_where_an_oblique_wind_goes_and_nowhere_upwind) {
    const Scene scene = scene_of("[sea]\n[[sea.system]]\ntype=\"wind\"\nspectrum=\"phillips\"\n"
                                 "wind_speed_10m_mps=8\nfrom_deg=217\nsignificant_height_m=1.5\n"
                                 "[[cascade]]\nlength_m=800\nsize=256\n");
    const double towards_rad = 53 * pi / 180;
    const auto along = [&](double x, double y) {
        return x * std::cos(towards_rad) + y * std::sin(towards_rad);
    };
    const DirectionalSpectrum spectrum(scene.sea.systems[0], scene.sea);
    for (int degrees = 0; degrees < 360; ++degrees) {
        const double kx = 0.3 * std::cos(degrees * pi / 180),
                     ky = 0.3 * std::sin(degrees * pi / 180);
        if (std::abs(along(kx, ky)) > 1e-9) { // not square to it
            EXPECT_EQ(spectrum.density(kx, ky) > 0.0, along(kx, ky) > 0) << degrees;
        }
    }
    // So do the waves that are made: their energy on average over seeds, and which there are at all.
    const auto sea = realize(scene);
    const CascadeModes& modes = sea->cascades[0];
    const std::vector<double> energy = mode_variances(spectrum, modes.spec, modes.band);
    std::complex<double> mean;
    int waves = 0;
    for (int i = 0; i < 256 * 256; ++i) {
        const int nx = signed_index(i % 256, 256), ny = signed_index(i / 256, 256);
        const auto index = static_cast<std::size_t>(i);
        mean += std::polar(energy[index], std::atan2(ny, nx));
        waves += modes.h0[index] != 0.0;
        if (along(nx, ny) < -std::sqrt(0.5)) { // no corner of its cell lies downwind
            EXPECT_EQ(modes.h0[index], 0.0) << nx << ", " << ny;
        }
    }
    EXPECT_NEAR(std::arg(mean), towards_rad, pi / 180);
    EXPECT_GT(waves, 1000);
}

} // namespace
} // namespace seaway::sea
