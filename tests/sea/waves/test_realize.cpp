// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "sea/basics/gaussian.h"
#include "sea/scene/scene.h"
#include "sea/surface/inverse.h"
#include "sea/waves/directional_spectrum.h"
#include "sea/waves/mode_variances.h"
#include "sea/waves/statistics/moments.h"
#include "tests/sea/csv.h"
#include "tests/sea/sea_fixture.h"

namespace seaway::sea {
namespace {

using testing::energy_of;
using testing::swell_sea;
using testing::three_cascades;
using testing::windy_sea;

/// Expected variance of one cascade by its modes' cells, and, with the seed's numbers, of this very
/// realisation.
struct Expectation {
    double mean = 0;
    double drawn = 0;
    double squares = 0; ///< sum of (mean variance of the pair k, -k)^2 over the plane
};

Expectation expectation(const SeaState& sea, const CascadeModes& modes) {
    Expectation e;
    const DirectionalSpectrum spectrum(sea.systems.at(0), sea);
    const int size = modes.spec.size;
    const std::vector<double> variances = mode_variances(spectrum, modes.spec, modes.band);
    const auto at = [&](int nx, int ny) {
        return variances[static_cast<std::size_t>((ny + size) % size * size + (nx + size) % size)];
    };
    for (int ny = 1 - size / 2; ny < size / 2; ++ny)
        for (int nx = 1 - size / 2; nx < size / 2; ++nx) {
            const double variance = at(nx, ny);
            const GaussianPair xi =
                gaussian_pair({sea.seed, 0, cascade_key(modes.spec.length_m), nx, ny});
            e.mean += variance;
            // Twice the mean |h0|^2 = variance / 2 times (xr^2 + xi^2) / 2.
            e.drawn += variance * (xi.real * xi.real + xi.imaginary * xi.imaginary) / 2.0;
            e.squares += std::pow(0.5 * (variance + at(-nx, -ny)), 2);
        }
    return e;
}

// Traps T1: published systems are off by factors 2, 4 and 8 here.
TEST(Realize, I1_sum_of_h0_squared_is_the_spectrum_times_the_drawn_numbers) {
    const SeaState sea = windy_sea();
    const auto realization = testing::realized(sea, three_cascades);
    for (const CascadeModes& modes : realization->cascades) {
        const Expectation e = expectation(sea, modes);
        EXPECT_NEAR(energy_of(modes) / e.drawn, 1.0, 1e-6);
    }
}

TEST(Realize, I6_hs_over_16_seeds_is_the_spectrums_within_3_standard_errors) {
    double realised = 0.0;
    Expectation total;
    for (std::uint64_t seed = 0; seed < 16; ++seed) {
        const SeaState sea = windy_sea(seed);
        const auto realization = testing::realized(sea, three_cascades);
        for (const CascadeModes& modes : realization->cascades) {
            realised += energy_of(modes) / 16.0;
            if (seed == 0) {
                const Expectation e = expectation(sea, modes);
                total.mean += e.mean;
                total.squares += e.squares;
            }
        }
    }
    // Time-averaged energy has half the variance of one instant's, so sqrt(2 sum E^2 / 16) bounds
    // it.
    EXPECT_NEAR(realised, total.mean, 3.0 * std::sqrt(2.0 * total.squares / 16.0));
    // And the lattice carries what the integral over the bands says.
    const SeaState sea = windy_sea();
    const Dispersion dispersion = sea.dispersion();
    const auto realization = testing::realized(sea, three_cascades);
    const double integral =
        requested_variance(sea, dispersion.omega(realization->cascades.front().band.k_lo_radpm),
                           dispersion.omega(realization->cascades.back().band.k_hi_radpm));
    EXPECT_NEAR(total.mean / integral, 1.0, 1e-3);
}

// A1, A3, T29, T41: naive code puts 0/0 at k = 0 and unpaired waves at Nyquist.
TEST(Realize, A1_A3_dc_nyquist_row_and_column_are_exactly_zero) {
    const auto realization = testing::realized(windy_sea(), three_cascades);
    for (const CascadeModes& modes : realization->cascades) {
        const int size = modes.spec.size;
        EXPECT_EQ(modes.h0[0], std::complex<double>(0.0));
        EXPECT_EQ(modes.rate[0], 0u);
        for (int i = 0; i < size; ++i) {
            EXPECT_EQ(modes.h0[static_cast<std::size_t>(size / 2 * size + i)], 0.0);
            EXPECT_EQ(modes.h0[static_cast<std::size_t>(i * size + size / 2)], 0.0);
        }
        for (const auto& h0 : modes.h0)
            ASSERT_TRUE(std::isfinite(h0.real()) && std::isfinite(h0.imag()));
    }
}

// A4, T30: naive code mirrors with N - 1 - i. The rate of k and of -k must be one number, or h(k,t)
// stops being Hermitian.
TEST(Realize, A4_frequencies_of_k_and_minus_k_are_the_same_bits) {
    const auto realization = testing::realized(windy_sea(), three_cascades);
    for (const CascadeModes& modes : realization->cascades) {
        const int size = modes.spec.size;
        for (int iy = 0; iy < size; ++iy)
            for (int ix = 0; ix < size; ++ix) {
                const auto i = static_cast<std::size_t>(iy * size + ix);
                const auto mirror =
                    static_cast<std::size_t>((size - iy) % size * size + (size - ix) % size);
                ASSERT_EQ(modes.rate[i], modes.rate[mirror]);
            }
    }
}

// T23, I2, I3: overlapping bands count waves twice, gaps lose them, square corners depend on N.
TEST(Realize, I20_every_wave_belongs_to_exactly_one_cascade) {
    const std::vector<CascadeSpec> cascades{{1021.0, 256}, {197.0, 256}, {37.0, 256}};
    const std::vector<Band> bands = *assign_bands(cascades);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> log_k(std::log(bands.front().k_lo_radpm),
                                                 std::log(bands.back().k_hi_radpm));
    for (int i = 0; i < 10000; ++i) {
        const double k = std::exp(log_k(random));
        int owners = 0;
        for (const Band& band : bands)
            owners += band.contains(k);
        ASSERT_EQ(owners, 1) << k;
    }
    const SeaState sea = windy_sea();
    const Dispersion d = sea.dispersion();
    double parts = 0.0;
    for (const Band& band : bands)
        parts += requested_variance(sea, d.omega(band.k_lo_radpm), d.omega(band.k_hi_radpm));
    EXPECT_NEAR(parts / requested_variance(sea, d.omega(bands.front().k_lo_radpm),
                                           d.omega(bands.back().k_hi_radpm)),
                1.0, 1e-6);
}

TEST(Realize, I3_corners_of_the_square_lattice_are_empty) {
    const auto realization = testing::realized(windy_sea(), three_cascades);
    for (const CascadeModes& modes : realization->cascades) {
        const int size = modes.spec.size;
        for (int iy = 0; iy < size; ++iy)
            for (int ix = 0; ix < size; ++ix)
                if (std::hypot(signed_index(ix, size), signed_index(iy, size)) >
                    band_end_share_of_nyquist * size / 2) {
                    ASSERT_EQ(modes.h0[static_cast<std::size_t>(iy * size + ix)], 0.0);
                }
    }
}

// T32: numbers drawn in texel order change when the grid does.
TEST(Realize, I22_a_mode_keeps_its_numbers_when_the_grid_grows) {
    const SeaState sea = windy_sea();
    const auto small = testing::realized(sea, {{200.0, 64}});
    const auto large = testing::realized(sea, {{200.0, 128}});
    int shared = 0;
    for (int ny = -19; ny <= 19; ++ny)
        for (int nx = -19; nx <= 19; ++nx) {
            const auto at = [&](const RealizationPtr& r, int size) {
                return r->cascades[0]
                    .h0[static_cast<std::size_t>((ny + size) % size * size + (nx + size) % size)];
            };
            const std::complex<double> a = at(small, 64), b = at(large, 128);
            if (a == 0.0)
                continue;
            ++shared;
            // The small band ends at 19.2 steps: cells there are cut, and cells that its edge
            // does not touch are the same to the bit.
            if (std::hypot(nx, ny) < 16.5)
                ASSERT_EQ(a, b);
            else
                ASSERT_NEAR(std::arg(a), std::arg(b), 1e-12);
        }
    EXPECT_GT(shared, 1000);
    // Nor does a tile that is added change the others' numbers.
    const auto two = testing::realized(sea, {{200.0, 128}, {11.0, 64}});
    EXPECT_EQ(two->cascades[0].h0[5], large->cascades[0].h0[5]);
}

TEST(Realize, I24_same_seed_same_bits_other_seed_other_sea) {
    const auto a = testing::realized(windy_sea(1), three_cascades);
    const auto b = testing::realized(windy_sea(1), three_cascades);
    const auto c = testing::realized(windy_sea(2), three_cascades);
    EXPECT_EQ(a->cascades[0].h0, b->cascades[0].h0);
    double cross = 0.0, energy = 0.0, fourth = 0.0;
    for (std::size_t i = 0; i < a->cascades[0].h0.size(); ++i) {
        const double pa = std::norm(a->cascades[0].h0[i]);
        const double pc = std::norm(c->cascades[0].h0[i]);
        cross += (std::conj(a->cascades[0].h0[i]) * c->cascades[0].h0[i]).real();
        energy += 0.5 * (pa + pc);
        fourth += pa * pc;
    }
    // The cross sum has variance sum |a|^2 |c|^2 / 2.
    EXPECT_LT(std::abs(cross), 3.0 * std::sqrt(fourth / 2.0));
    EXPECT_LT(std::abs(cross), 0.2 * energy);
}

TEST(Realize, I26_A9_no_wind_is_a_flat_sea_exactly) {
    SeaState sea;
    sea.systems.emplace_back(WindSea{});
    const auto realization = testing::realized(sea, three_cascades);
    for (const CascadeModes& modes : realization->cascades)
        EXPECT_EQ(energy_of(modes), 0.0);
}

TEST(Realize, I28_energies_of_two_systems_add) {
    SeaState both = windy_sea();
    const SeaState swell = swell_sea(2.0, 8.0);
    both.systems.push_back(swell.systems[0]);
    const double sum =
        requested_variance(windy_sea(), 0.1, 10.0) + requested_variance(swell, 0.1, 10.0);
    EXPECT_NEAR(requested_variance(both, 0.1, 10.0) / sum, 1.0, 1e-6);
    // And each draws its own numbers: two equal systems are not one of twice the amplitude.
    SeaState twice = swell;
    twice.systems.push_back(swell.systems[0]);
    const auto one = testing::realized(swell, three_cascades);
    const auto two = testing::realized(twice, three_cascades);
    double cross = 0.0, energy = 0.0;
    for (std::size_t i = 0; i < one->cascades[0].h0.size(); ++i) {
        const auto rest = two->cascades[0].h0[i] - one->cascades[0].h0[i];
        cross += (std::conj(one->cascades[0].h0[i]) * rest).real();
        energy += std::norm(rest);
    }
    EXPECT_GT(energy, 0.0);
    EXPECT_LT(std::abs(cross), 0.5 * energy);
}

// B7, T37: floor() freezes every wave slower than the loop.
TEST(Realize, B7_loop_rounds_to_whole_turns_and_never_freezes_a_wave) {
    const TimeUs period = us_from_seconds(60.0);
    for (double omega = 0.01; omega < 20.0; omega *= 1.1) {
        const Rate rate = mode_rate(omega, period);
        const double turns = omega_from_rate(rate) * 60.0 / two_pi;
        EXPECT_NEAR(turns, std::round(turns), 1e-9);
        EXPECT_GE(turns, 1.0 - 1e-9);
        if (omega * 60.0 / two_pi > 1.0) {
            EXPECT_LE(std::abs(omega_from_rate(rate) - omega), pi / 60.0 + 1e-9);
        }
    }
    // So does every wave of a sea that has a loop, which is the same sea at its beginning.
    SeaState state = windy_sea();
    const auto free = testing::realized(state, three_cascades);
    state.loop_period_s = 60.0;
    const auto looped = testing::realized(state, three_cascades);
    for (std::size_t c = 0; c < looped->cascades.size(); ++c) {
        const CascadeModes& modes = looped->cascades[c];
        EXPECT_EQ(modes.h0, free->cascades[c].h0);
        for (std::size_t i = 0; i < modes.h0.size(); ++i) {
            if (modes.h0[i] == 0.0)
                continue;
            const double turns = omega_from_rate(modes.rate[i]) * 60.0 / two_pi;
            ASSERT_NEAR(turns, std::round(turns), 1e-9) << c << ' ' << i;
            ASSERT_GE(std::round(turns), 1.0);
        }
    }
}

// T36: the spectrum knows the depth and the evolution does not (omega = sqrt(g k)).
TEST(Realize, T36_waves_run_at_the_depth_their_spectrum_was_made_for) {
    SeaState sea = windy_sea();
    sea.depth_m = 4.0;
    const auto realization = testing::realized(sea, three_cascades);
    const CascadeModes& modes = realization->cascades[0];
    const double k = modes.spec.wavenumber_step_radpm() * 5.0;
    EXPECT_NEAR(omega_from_rate(modes.rate[5]), sea.dispersion().omega(k), 1e-9);
    EXPECT_LT(omega_from_rate(modes.rate[5]), 0.6 * std::sqrt(9.81 * k));
}

// T19: the fade multiplies Psi, so amplitudes are multiplied by its root; both ways of cutting are
// reported.
TEST(Realize, T19_short_wave_fade_and_cut_offs_act_on_psi_and_are_reported) {
    SeaState faded = windy_sea();
    faded.short_wave_fade_m = 0.5;
    const DirectionalSpectrum plain(windy_sea().systems[0], windy_sea());
    const DirectionalSpectrum with_fade(faded.systems[0], faded);
    EXPECT_NEAR(with_fade.density(1.0, 0.3) / plain.density(1.0, 0.3), std::exp(-0.25 * 1.09),
                1e-12);
    SeaState cut = windy_sea();
    cut.wavenumber_min_radpm = 0.05;
    cut.wavenumber_max_radpm = 0.5;
    const DirectionalSpectrum with_cut(cut.systems[0], cut);
    EXPECT_EQ(with_cut.density(0.04, 0.0), 0.0);
    EXPECT_EQ(with_cut.density(0.51, 0.0), 0.0);
    EXPECT_EQ(with_cut.density(0.2, 0.0), plain.density(0.2, 0.0));
    const SeaSummary s = summarize(cut, *testing::realized(cut, three_cascades));
    EXPECT_GT(s.lost_fade_m2, 0.0);
    SeaState scaled = windy_sea();
    scaled.height_scale = 2.0;
    EXPECT_NEAR(requested_variance(scaled, 0, 1e9) / requested_variance(windy_sea(), 0, 1e9), 4.0,
                1e-12);
}

// T25: up to Nyquist a wave has two points, and whatever samples between them destroys it.
TEST(Realize, T25_no_wave_has_fewer_than_three_and_a_third_grid_points) {
    const auto sea = testing::realized(windy_sea(), three_cascades);
    for (const CascadeModes& modes : sea->cascades) {
        double shortest_m = 1e30;
        const double step = modes.spec.wavenumber_step_radpm();
        for (int i = 0; i < 64 * 64; ++i)
            if (modes.h0[static_cast<std::size_t>(i)] != std::complex<double>{})
                shortest_m =
                    std::min(shortest_m, two_pi / (step * std::hypot(signed_index(i % 64, 64),
                                                                     signed_index(i / 64, 64))));
        EXPECT_GE(shortest_m, modes.spec.spacing_m() / 0.3);
        EXPECT_LE(shortest_m, 1.1 * modes.spec.spacing_m() / 0.3) << "and the band is used";
    }
}

// A sea that loses waves in every way at once: longer than the longest tile, shorter than the finest
// grid, faded and cut off in between. Naive: what is below the tiles is counted as faded, too.
TEST(Realize, variance_is_carried_or_lost_for_one_reason_alone) {
    SeaState sea = windy_sea();
    sea.short_wave_fade_m = 0.2;
    sea.wavenumber_max_radpm = 3.0;
    const std::vector<CascadeSpec> tiles{{90.0, 32}, {29.0, 32}};
    const SeaSummary s = summarize(sea, *testing::realized(sea, tiles));
    const double whole = requested_variance(sea, 0.0, 1e9);
    double carried = 0.0;
    for (const CascadeVariance& cascade : s.cascades)
        carried += cascade.requested_m2;
    for (const double part : {carried, s.lost_below_m2, s.lost_above_m2, s.lost_fade_m2})
        EXPECT_GT(part, 1e-4 * whole);
    // Quadratures of the same spectrum with different ends: they agree to about 1e-9.
    EXPECT_NEAR(carried + s.lost_below_m2 + s.lost_above_m2 + s.lost_fade_m2, whole, 1e-6 * whole);
}

// What bounds go by: phases of a list may agree, those of a spectrum are drawn.
// g Tp^2 / 2 pi in deep water; surface tension is 1e-5 of it.
TEST(Realize, the_longest_peak_is_that_of_the_longest_system_whichever_stands_first) {
    const Swell swell{.significant_height_m = 0.5, .peak_period_s = 13.0};
    const Swell waves{.significant_height_m = 2.5, .peak_period_s = 5.0};
    for (const bool swell_first : {true, false}) {
        SeaState sea;
        sea.systems = swell_first ? std::vector<WaveSystem>{swell, waves}
                                  : std::vector<WaveSystem>{waves, swell};
        const CascadeSpec tile{700.0, 64};
        const Realization realization = *realize(sea, {&tile, 1});
        EXPECT_NEAR(summarize(sea, realization).longest_peak_wavelength_m, 9.81 * 13 * 13 / two_pi,
                    0.5)
            << swell_first;
    }
}

TEST(Realize, waves_of_a_list_are_known_as_given_and_those_of_a_spectrum_are_not) {
    SeaState sea = windy_sea();
    ExplicitModes list;
    list.length_m = 90.0;
    list.modes = {{3, -5, 0.1, 0.0}, {-2, 1, 0.1, 1.0}};
    sea.systems.push_back(list);
    const std::vector<CascadeSpec> tiles{{90.0, 32}, {29.0, 32}};
    const RealizationPtr realized = testing::realized(sea, tiles);
    int given = 0;
    for (int ny = -15; ny <= 15; ++ny)
        for (int nx = -15; nx <= 15; ++nx) {
            const auto i = static_cast<std::size_t>((ny + 32) % 32 * 32 + (nx + 32) % 32);
            const bool is = realized->cascades[0].is_given(i);
            EXPECT_EQ(is, (nx == 3 && ny == -5) || (nx == -2 && ny == 1)) << nx << " " << ny;
            given += is;
            EXPECT_FALSE(realized->cascades[1].is_given(i));
        }
    EXPECT_EQ(given, 2);
}

// A half more high and as far sideways: the same points of the water lie above the same places.
TEST(Realize, heights_and_sideways_motion_are_scaled_apart) {
    const Choppiness choppiness{0.9, 0.6};
    SeaState state = windy_sea();
    state.choppiness = choppiness;
    SeaState higher = windy_sea();
    higher.height_scale = 1.5;
    higher.choppiness = {choppiness.x / 1.5, choppiness.y / 1.5};
    const auto sea = testing::realized(state, three_cascades);
    const auto high_sea = testing::realized(higher, three_cascades);
    const DirectSum plain(sea), scaled(high_sea);
    for (int i = 0; i < 20; ++i) {
        const QueryPoint point{13.7 * i, -7.1 * i, 12'000'000};
        Vec2 from, from_scaled;
        const Answer answer =
            surface_at(point, {sea->choppiness, 1e-10, {}}, plain.at_time(point.time_us), &from);
        const Answer high = surface_at(point, {high_sea->choppiness, 1e-10, {}},
                                       scaled.at_time(point.time_us), &from_scaled);
        EXPECT_GT(std::hypot(from.x - point.x_m, from.y - point.y_m), 1e-3);
        EXPECT_NEAR(from_scaled.x, from.x, 1e-9);
        EXPECT_NEAR(from_scaled.y, from.y, 1e-9);
        EXPECT_NEAR(high.height_m, 1.5 * answer.height_m, 1e-9);
    }
}

TEST(Realize, A16_hs_does_not_depend_on_how_a_narrow_beam_meets_the_lattice) {
    double lowest = 1e30, highest = 0.0;
    for (int degrees = 0; degrees <= 90; ++degrees) {
        const SeaState sea = swell_sea(2.0, 8.0, degrees * pi / 180.0, 1e6);
        const DirectionalSpectrum spectrum(sea.systems[0], sea);
        // 12 peak wavelengths a tile.
        const CascadeSpec tile{1200.0, 128};
        const double step = tile.wavenumber_step_radpm();
        const Band band{0.5 * step, 38.0 * step};
        double variance = 0.0;
        for (const double cell : mode_variances(spectrum, tile, band))
            variance += cell;
        lowest = std::min(lowest, variance);
        highest = std::max(highest, variance);
    }
    EXPECT_LT(highest / lowest, 1.001);
}

} // namespace
} // namespace seaway::sea
