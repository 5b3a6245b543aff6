// SPDX-License-Identifier: Apache-2.0
// Waves given one by one: what is asked is what there is, whatever their sign, their place on the
// lattice and the scale of heights.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <tuple>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sea/basics/constants.h"
#include "sea/waves/realize.h"
#include "sea/waves/reference.h"
#include "sea/waves/statistics/moments.h"
#include "sea/waves/transition.h"
#include "tests/sea/scene_of.h"
#include "tests/sea/sea_fixture.h"

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

// Naive: the first system of a tile makes it for its own waves; longer indices have their waves at the end of what it carries,
// or are refused, and with the systems the other way round they are not.
TEST(ExplicitWaves, a_tile_that_systems_share_fits_all_of_them_in_any_order) {
    const ExplicitModes few{150.0, {{3, 0, 0.4, 0.0}}}, many{150.0, {{0, 30, 0.1, 1.0}}};
    SeaState sea = sea_of({});
    sea.systems = {few, many};
    const Realization one = *realize(sea, {&tile, 1});
    sea.systems = {many, few};
    const Realization other = *realize(sea, {&tile, 1});
    ASSERT_EQ(one.cascades.size(), 2u);
    EXPECT_EQ(one.cascades[1].spec.size, explicit_tile_size(30));
    EXPECT_EQ(one.cascades[1].spec.size, other.cascades[1].spec.size);
    EXPECT_EQ(one.cascades[1].band.k_hi_radpm, other.cascades[1].band.k_hi_radpm);
    EXPECT_GT(one.cascades[1].band.k_hi_radpm, 30 * one.cascades[1].spec.wavenumber_step_radpm());
    EXPECT_EQ(one.cascades[1].h0, other.cascades[1].h0);
}

double period_s(const SeaState& sea, double lattice_steps) {
    return two_pi / sea.dispersion().omega(two_pi / length_m * lattice_steps);
}

SeaSummary summary_of(const SeaState& sea) {
    return summarize(sea, *realize(sea, {&tile, 1}));
}

// The peak is where most energy is, wherever it stands in the list. Other lines are more than the 20 %
// away in frequency that the realised peak looks at; stored frequencies are good to 1e-13 rad/s.
TEST(ExplicitWaves, the_peak_is_the_strongest_waves_in_whatever_order_they_are_given) {
    std::vector<ExplicitMode> modes{{3, 0, -1.0, 0.3}, {0, -6, 0.5, 1.0}, {-9, 0, 0.1, -2.0}};
    for (int order = 0; order < 3; ++order) {
        const SeaState sea = sea_of(modes);
        const SeaSummary summary = summary_of(sea);
        EXPECT_NEAR(summary.requested.peak_period_s, period_s(sea, 3), 1e-12) << order;
        EXPECT_NEAR(summary.realised.peak_period_s, period_s(sea, 3), 1e-9) << order;
        std::rotate(modes.begin(), modes.begin() + 1, modes.end());
    }
}

// Naive: those of the new sea alone, and what old ones may add up to is taken for chance.
TEST(ExplicitWaves, waves_given_by_hand_are_known_as_such_for_as_long_as_they_are_there) {
    SeaState old_state = testing::windy_sea(), new_state = testing::windy_sea();
    ExplicitModes list;
    list.length_m = testing::three_cascades[0].length_m;
    list.modes = {{3, -5, 0.1, 0.0}};
    old_state.systems.push_back(list);
    const auto old_sea = testing::realized(old_state, testing::three_cascades);
    const auto new_sea = testing::realized(new_state, testing::three_cascades);
    const int size = testing::three_cascades[0].size;
    const auto mode = static_cast<std::size_t>((size - 5) * size + 3);
    const double step = two_pi / list.length_m;
    EXPECT_NEAR(old_sea->cascades[0].longest_radpm(),
                std::min(std::sqrt(34.0) * step, old_sea->cascades[0].band.k_lo_radpm), 1e-12);
    for (const bool back : {false, true}) {
        const auto change =
            SeaTransition::create(back ? new_sea : old_sea, back ? old_sea : new_sea, 0, 2'000'000);
        ASSERT_TRUE(change);
        for (const RealizationPtr& sea : {change->at(1'000'000), change->growth(1'000'000),
                                          RealizationPtr(change->envelope())}) {
            EXPECT_TRUE(sea->cascades[0].is_given(mode)) << back;
            EXPECT_FALSE(sea->cascades[0].is_given(mode + 1)) << back;
        }
    }
}

// Naive: each row has an energy of its own, and what was asked for is not what the tile holds.
TEST(ExplicitWaves, rows_of_one_wave_are_one_wave) {
    for (const bool in_two_systems : {false, true})
        for (const auto& [phase_rad, amplitude_m] : {std::pair(0.0, 1.0),
                                                     {std::numbers::pi / 2, std::sqrt(0.5)},
                                                     {std::numbers::pi, 0.0}}) {
            SeaState sea = sea_of({{5, -2, 0.5, 0}});
            ExplicitModes again = std::get<ExplicitModes>(sea.systems[0]);
            again.modes[0].phase_rad = phase_rad;
            if (in_two_systems)
                sea.systems.emplace_back(again);
            else
                std::get<ExplicitModes>(sea.systems[0]).modes.push_back(again.modes[0]);
            const SeaSummary summary = summary_of(sea);
            EXPECT_NEAR(summary.requested.significant_height_m, 4 * amplitude_m / std::sqrt(2.0),
                        1e-12)
                << phase_rad;
            EXPECT_NEAR(summary.realised.significant_height_m,
                        summary.requested.significant_height_m, 1e-12)
                << phase_rad;
        }
}

// Naive: towards the east, whatever was asked for.
TEST(ExplicitWaves, a_stylised_wave_longer_than_its_tile_runs_along_the_side_that_is_nearest) {
    for (const auto& [from_deg, nx, ny] :
         {std::tuple(270, 1, 0), std::tuple(90, -1, 0), std::tuple(180, 0, 1), std::tuple(0, 0, -1),
          std::tuple(200, 0, 1)}) {
        const Scene scene = testing::scene_of(
            fmt::format("[sea]\n[[sea.system]]\ntype = \"sines\"\nshape = \"gerstner\"\nlength_m = "
                        "256\ndata = '''\n"
                        "wavelength_m,amplitude_m,from_deg,phase_rad\n600,1,{},0\n'''\n",
                        from_deg));
        const Result<Realization> sea = realize(scene);
        ASSERT_TRUE(sea);
        const auto tile = std::ranges::find(
            sea->cascades, 256.0, [](const CascadeModes& modes) { return modes.spec.length_m; });
        ASSERT_NE(tile, sea->cascades.end());
        const int size = tile->spec.size;
        const auto mode = static_cast<std::size_t>((ny + size) % size * size + (nx + size) % size);
        EXPECT_NEAR(std::abs(tile->h0[mode]), 0.5, 1e-12) << from_deg;
    }
}

// Naive: what lies beyond the peak finder's bins is no peak, and the period that of 1 rad/s.
TEST(ExplicitWaves, a_peak_however_slow_is_said) {
    SeaState sea = sea_of({{1, 0, 1e-3, 0}});
    std::get<ExplicitModes>(sea.systems[0]).length_m = 1e6;
    sea.depth_m = 0.05;
    const CascadeSpec wide{1e6, tile.size};
    const SeaSummary summary = summarize(sea, *realize(sea, {&wide, 1}));
    const double period_s = two_pi / sea.dispersion().omega(two_pi / 1e6);
    EXPECT_GT(period_s, 1e6);
    EXPECT_NEAR(summary.realised.peak_period_s, period_s, 1e-6 * period_s);
}

// Two waves that run against each other or across have one frequency, and together more energy than a
// third that is higher than either: 0.8^2 + 0.8^2 > 1.
TEST(ExplicitWaves, waves_of_one_frequency_are_one_line_of_the_spectrum) {
    for (const std::vector<ExplicitMode>& pair :
         {std::vector<ExplicitMode>{{5, 0, 0.8, 0}, {-5, 0, 0.8, 1}},
          std::vector<ExplicitMode>{{5, 0, 0.8, 0}, {3, -4, -0.8, 1}}})
        for (const std::size_t place : {0u, 1u, 2u}) {
            std::vector<ExplicitMode> modes = pair;
            modes.insert(modes.begin() + static_cast<std::ptrdiff_t>(place), {0, 15, 1.0, 0});
            const SeaState sea = sea_of(modes);
            const SeaSummary summary = summary_of(sea);
            EXPECT_NEAR(summary.requested.peak_period_s, period_s(sea, 5), 1e-12) << place;
            EXPECT_NEAR(summary.realised.peak_period_s, period_s(sea, 5), 1e-9) << place;
        }
}

// The same wave on a tile of a third of the length: wavenumbers differ in their last bit for some of them.
TEST(ExplicitWaves, waves_of_one_length_on_two_tiles_are_one_line) {
    for (int steps = 1; steps <= 10; ++steps) {
        SeaState sea = sea_of({{3 * steps, 0, 0.8, 0}, {0, 4 * steps, 1.0, 0}});
        sea.systems.emplace_back(ExplicitModes{length_m / 3, {{0, -steps, 0.8, 1}}});
        const CascadeSpec wide{length_m, 128};
        EXPECT_NEAR(summarize(sea, *realize(sea, {&wide, 1})).requested.peak_period_s,
                    period_s(sea, 3 * steps), 1e-9)
            << steps;
    }
}

void expect_equal(const SeaStatistics& a, const SeaStatistics& b) {
    const auto expect_near = [](double one, double other, const char* what) {
        EXPECT_NEAR(one, other, 1e-9 * std::max(1.0, std::abs(one))) << what;
    };
    expect_near(a.significant_height_m, b.significant_height_m, "Hs");
    expect_near(a.peak_period_s, b.peak_period_s, "Tp");
    expect_near(a.zero_crossing_period_s, b.zero_crossing_period_s, "Tz");
    expect_near(a.mean_period_s, b.mean_period_s, "Tm01");
    expect_near(a.mean_towards_rad, b.mean_towards_rad, "direction");
    expect_near(a.spread_rad, b.spread_rad, "spread");
    expect_near(a.mean_square_slope, b.mean_square_slope, "slope");
    expect_near(a.mean_square_strain, b.mean_square_strain, "strain");
}

// Nothing is drawn: each statistic of these waves, requested and realised, is the same sum over them. Their
// frequencies are further apart than the 20 % over which the realised peak averages.
TEST(ExplicitWaves, every_statistic_is_the_sum_over_the_waves_asked_for_and_realised) {
    const std::vector<ExplicitMode> modes{
        {3, -5, 1.5, 0.3}, {-2, 1, -0.5, -2.0}, {1, 14, 0.2, 1.0}};
    const SeaState sea = sea_of(modes, 2.0);
    const double step = two_pi / length_m;
    double m0 = 0, m1 = 0, m2 = 0, slope = 0, strain = 0, east = 0, north = 0;
    for (const ExplicitMode& mode : modes) {
        const double energy = 0.5 * std::pow(2.0 * mode.amplitude_m, 2);
        const double length = std::hypot(mode.nx, mode.ny), k = step * length;
        const double omega = two_pi / period_s(sea, length);
        m0 += energy;
        m1 += energy * omega;
        m2 += energy * omega * omega;
        slope += energy * k * k;
        // Orbits of water of finite depth are coth(kh) times as wide as high.
        strain += energy * std::pow(k / std::tanh(k * sea.depth_m), 2);
        east += energy * mode.nx / length;
        north += energy * mode.ny / length;
    }
    SeaStatistics sums;
    sums.significant_height_m = 4 * std::sqrt(m0);
    sums.peak_period_s = period_s(sea, std::hypot(3, 5));
    sums.zero_crossing_period_s = two_pi * std::sqrt(m0 / m2);
    sums.mean_period_s = two_pi * m0 / m1;
    sums.mean_towards_rad = std::atan2(north, east);
    sums.spread_rad = std::sqrt(2 * (1 - std::hypot(east, north) / m0));
    sums.mean_square_slope = slope;
    sums.mean_square_strain = strain;
    const SeaSummary summary = summary_of(sea);
    expect_equal(summary.requested, sums);
    expect_equal(summary.realised, sums);
    // Between frequencies: from the lower one on, up to the higher one without it.
    const double low = two_pi / period_s(sea, std::hypot(2, 1)),
                 high = two_pi / period_s(sea, std::hypot(1, 14));
    EXPECT_NEAR(requested_variance(sea, low, high), 2 * (1.5 * 1.5 + 0.5 * 0.5), 1e-12);
    EXPECT_NEAR(requested_variance(sea, high, 1e9), 2 * 0.2 * 0.2, 1e-12);
    EXPECT_EQ(requested_variance(sea, 0.0, low), 0.0);
}

// Stylised waves are lines too, but move nothing sideways. Here 14 waves go towards east and 5 towards north,
// of which the second, the higher one, is not first in the list; each is its own half of amplitude squared,
// or the variance of exp(p (cos - 1)), between 0 and a half of it.
TEST(ExplicitWaves, stylised_waves_are_lines_that_strain_nothing) {
    for (const SineKind kind : {SineKind::sine, SineKind::exponential}) {
        SeaState sea = sea_of({});
        sea.choppiness = {1, 1};
        SineRamps ramps;
        ramps.kind = kind;
        ramps.length_m = length_m;
        ramps.by_hand = {{length_m / 14, 0.5, 0.0, 0.3}, {length_m / 5, 0.75, two_pi / 4, 1.0}};
        sea.systems = {ramps};
        const SeaSummary summary = summary_of(sea);
        expect_equal(summary.requested, summary.realised);
        EXPECT_NEAR(summary.requested.peak_period_s, period_s(sea, 5), 1e-9);
        const double half = 0.5 * (0.5 * 0.5 + 0.75 * 0.75);
        const double variance = std::pow(summary.requested.significant_height_m / 4, 2);
        if (kind == SineKind::sine) {
            EXPECT_NEAR(variance, half, 1e-12);
        } else {
            EXPECT_LT(variance, half);
        }
        EXPECT_GT(summary.requested.mean_square_slope, 0.0);
        EXPECT_EQ(summary.requested.mean_square_strain, 0.0);
        EXPECT_EQ(summary.realised.mean_square_strain, 0.0);
    }
}

// In a loop every wave turns a whole number of times, without one each has its own period.
// By hand: the second wave stands where the first one has dragged the point to, back along the first one's way by drag times
// its rise per radian. A drag that is not taken, or is taken along the second one's way, would show.
TEST(ExplicitWaves, a_wave_drags_the_next_one_back_along_its_way_by_its_rise_per_radian) {
    SineField field{.length_m = length_m, .sharpness = 1.7, .drag = 0.6};
    const double step = two_pi / length_m, p = field.sharpness;
    field.waves = {{4 * step, 3 * step, 1.5, 0.3, 0, 0}, {-7 * step, 5 * step, 0.8, -1.1, 0, 0}};
    const SineField::Wave &one = field.waves[0], &two = field.waves[1];
    const auto phase = [](const SineField::Wave& wave, double x, double y) {
        return wave.kx_radpm * x + wave.ky_radpm * y + wave.phase_rad;
    };
    const auto raised = [p](const SineField::Wave& wave, double phase_rad) {
        return wave.amplitude_m * std::exp(p * (std::sin(phase_rad) - 1));
    };
    double dragged_by = 0;
    for (int i = 0; i < 40; ++i) {
        const double x = 7.1 * i, y = 3.3 * i;
        const double first = raised(one, phase(one, x, y));
        const double per_radian = p * std::cos(phase(one, x, y)) * first;
        // The way of (4, 3) is (0.8, 0.6).
        const double second =
            raised(two, phase(two, x - 0.6 * 0.8 * per_radian, y - 0.6 * 0.6 * per_radian));
        const double level = exponential_sine(p).mean * (1.5 + 0.8);
        EXPECT_NEAR(sines_at(field, x, y, 0).height, first + second - level, 1e-12) << i;
        dragged_by = std::max(dragged_by, std::abs(second - raised(two, phase(two, x, y))));
    }
    EXPECT_GT(dragged_by, 0.01);
}

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
