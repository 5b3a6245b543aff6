// SPDX-License-Identifier: Apache-2.0
// A spectrum in few numbers: what it says it misses is what it misses, with every block and at any time.
#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "sea/basics/deviations.h"
#include "sea/waves/quantised_spectrum.h"
#include "sea/waves/spectrum_builder.h"
#include "tests/sea/sea_fixture.h"
#include "tests/support/explicit_sea.h"

namespace seaway::sea {
namespace {

using testing::one_wave;
using testing::realized;
using testing::swell_sea;
using testing::three_cascades;
using testing::windy_sea;

SpectrumFrame frame_of(const Realization& sea, const SeaState& state) {
    SpectrumFrame frame;
    for (const CascadeModes& modes : sea.cascades)
        frame.tiles.push_back({modes.spec,
                               {modes.longest_radpm(), modes.band.k_hi_radpm}, // as it is told
                               modes.carries_spectra});
    frame.choppiness = sea.choppiness;
    frame.dispersion = state.dispersion();
    frame.loop_period_us = sea.loop_period_us;
    return frame;
}

SpectrumBuilder begun(const Realization& sea, const SeaState& state,
                      const QuantisedSpectrum& waves) {
    return *SpectrumBuilder::create(frame_of(sea, state), waves.steps);
}

Realization rebuilt(const Realization& sea, const SeaState& state, const QuantisedSpectrum& waves) {
    SpectrumBuilder builder = begun(sea, state, waves);
    for (const WaveBlock& block : waves.blocks)
        EXPECT_TRUE(builder.add(block));
    return builder.sea();
}

/// Standard deviations of the difference of two seas over their tiles, from the definition; of vectors along the line where it is most, of
/// some that are looked along.
SpectrumLeft difference(const Realization& a, const Realization& b) {
    constexpr std::size_t lines = 32;
    double height = 0;
    std::array<double, lines> displacement{}, slope{};
    for (std::size_t c = 0; c < a.cascades.size(); ++c) {
        const CascadeModes& modes = a.cascades[c];
        const int size = modes.spec.size;
        for (int iy = 0; iy < size; ++iy)
            for (int ix = 0; ix < size; ++ix) {
                const auto i = static_cast<std::size_t>(iy * size + ix);
                const double energy = 2 * std::norm(modes.h0[i] - b.cascades[c].h0[i]);
                if (energy == 0)
                    continue;
                const double step = modes.spec.wavenumber_step_radpm();
                const double k[2] = {step * signed_index(ix, size), step * signed_index(iy, size)};
                const double d_over_k = modes.displacement_over_k(std::hypot(k[0], k[1]));
                height += energy;
                for (std::size_t line = 0; line < lines; ++line) {
                    const double turned = pi * static_cast<double>(line) / lines;
                    const double along = k[0] * std::cos(turned) + k[1] * std::sin(turned);
                    slope[line] += energy * along * along;
                    displacement[line] += energy * along * along * d_over_k * d_over_k;
                }
            }
    }
    return {std::sqrt(height), std::sqrt(std::ranges::max(displacement)),
            std::sqrt(std::ranges::max(slope))};
}

void expect_near(const SpectrumLeft& stated, const SpectrumLeft& found) {
    // Both are sums of some thousand squares: rounding alone, but of what nearly nothing is left. Of the lines that are looked along one is
    // within a 32nd of half a turn of the right one: cos^2 of it is 1 - 0.0024, half of it in a root.
    constexpr double between_lines = 1.3e-3;
    const auto expect_largest = [](double largest, double seen) {
        EXPECT_GE(largest, seen * (1 - 1e-6) - 1e-9);
        EXPECT_LE(largest, seen * (1 + between_lines) + 1e-9);
    };
    EXPECT_NEAR(stated.height_m, found.height_m, 1e-9 + 1e-6 * found.height_m);
    expect_largest(stated.displacement_m, found.displacement_m);
    expect_largest(stated.slope, found.slope);
}

TEST(QuantisedSpectrum, says_after_each_block_what_is_still_missed) {
    const SeaState state = windy_sea();
    const RealizationPtr sea = realized(state, three_cascades);
    const QuantisedSpectrum waves = quantise(*sea, {0.02, 0.01});
    ASSERT_GT(waves.blocks.size(), 20u);
    SpectrumBuilder builder = begun(*sea, state, waves);
    expect_near(waves.without, difference(*sea, builder.sea()));
    for (std::size_t b = 0; b < waves.blocks.size(); ++b) {
        ASSERT_TRUE(builder.add(waves.blocks[b]));
        expect_near(waves.left[b], difference(*sea, builder.sea()));
    }
}

TEST(QuantisedSpectrum, keeps_what_is_wanted_and_is_hardly_finer_than_that) {
    const SeaState state = windy_sea();
    const RealizationPtr sea = realized(state, three_cascades);
    double rms_slope = 0;
    {
        Realization calm = *sea;
        for (CascadeModes& modes : calm.cascades)
            std::fill(modes.h0.begin(), modes.h0.end(), 0.0);
        rms_slope = 1.5 * difference(*sea, calm).slope; // at most sqrt(2) of one component
    }
    for (const SpectrumAccuracy wanted :
         {SpectrumAccuracy{0.02}, {0.02, 0.01}, {0.02, 0.2}, {0.001, 0.01}, {0.1}}) {
        const QuantisedSpectrum waves = quantise(*sea, wanted);
        const SpectrumLeft left = difference(*sea, rebuilt(*sea, state, waves));
        const double height_m = spectrum_sigmas * left.height_m;
        const double slope = spectrum_sigmas * left.slope;
        EXPECT_LE(height_m, wanted.height_m);
        EXPECT_LE(slope, wanted.slope);
        const double sideways_m = spectrum_sigmas * left.displacement_m * rms_slope;
        EXPECT_GE(
            std::max(std::hypot(height_m, sideways_m) / wanted.height_m, slope / wanted.slope),
            0.98)
            << wanted.height_m << " and " << wanted.slope;
    }
}

// Naive: by the larger of the components along x and y, of which a wave between them has less, by the root of two.
TEST(QuantisedSpectrum, of_waves_that_run_between_the_axes_as_much_is_missed_as_along_them) {
    for (const bool given : {false, true})
        for (const auto& [nx, ny] : {std::pair(5, 0), {3, 4}, {4, -3}, {0, 5}}) {
            const RealizationPtr sea = realized(windy_sea(), {{100.0, 64}});
            Realization one = *sea;
            CascadeModes& modes = one.cascades[0];
            std::ranges::fill(modes.h0, 0.0);
            const auto at = static_cast<std::size_t>((ny + 64) % 64 * 64 + nx);
            modes.h0[at] = 0.5;
            if (given) {
                modes.given.assign(modes.h0.size(), 0);
                modes.given[at] = 1;
            }
            const double k_radpm = 5 * modes.spec.wavenumber_step_radpm();
            // Amplitude 1: its deviation, or a fifth where all of it may stand anywhere.
            const double height_m = given ? 1 / bound_sigmas : std::sqrt(0.5);
            const SpectrumLeft left = quantise(one, {0.02, 0.01}).without;
            EXPECT_NEAR(left.height_m, height_m, 1e-12) << nx << ' ' << ny;
            EXPECT_NEAR(left.slope, height_m * k_radpm, 1e-12) << nx << ' ' << ny;
            EXPECT_NEAR(left.displacement_m,
                        height_m * modes.displacement_over_k(k_radpm) * k_radpm, 1e-12)
                << nx << ' ' << ny;
        }
}

// 6 standard deviations at each of 20 000 places and times: one sea of 25 000 exceeds them somewhere.
TEST(QuantisedSpectrum, a_rebuilt_sea_keeps_its_bound_at_1000_times_of_a_day) {
    const SeaState state = windy_sea();
    const RealizationPtr sea = realized(state, three_cascades);
    const QuantisedSpectrum waves = quantise(*sea, {0.01, 0.005});
    const auto copy = std::make_shared<const Realization>(rebuilt(*sea, state, waves));
    const DirectSum truth(sea), own(copy);
    double worst_m = 0, worst_slope = 0;
    for (int t = 0; t < 1000; ++t) {
        const TimeUs time_us = t * TimeUs{86'400'000};
        const DirectSum::Moment then = truth.at_time(time_us), mine = own.at_time(time_us);
        for (int p = 0; p < 20; ++p) {
            const double x_m = 37.7 * p, y_m = -91.3 * p;
            const LagrangianPoint a = then.at(x_m, y_m), b = mine.at(x_m, y_m);
            worst_m = std::max(worst_m, std::abs(a.height - b.height));
            worst_slope = std::max(
                {worst_slope, std::abs(a.slope_x - b.slope_x), std::abs(a.slope_y - b.slope_y)});
        }
    }
    EXPECT_LE(worst_m, 0.01);
    EXPECT_LE(worst_slope, 0.005);
    EXPECT_GE(std::max(worst_m / 0.01, worst_slope / 0.005), 0.4) << "no finer than it must be";
}

// The frequency of a wave is not sent: it must come out the same, or phases part within days.
TEST(QuantisedSpectrum, a_rebuilt_sea_has_the_frequencies_of_the_sea_to_the_bit) {
    for (const double loop_s : {0.0, 90.0}) {
        SeaState state = windy_sea();
        state.loop_period_s = loop_s;
        state.gravity_mps2 = 3.7;
        state.surface_tension = loop_s > 0;
        const RealizationPtr sea = realized(state, three_cascades);
        const Realization copy = rebuilt(*sea, state, quantise(*sea, {0.01}));
        EXPECT_EQ(copy.loop_period_us, sea->loop_period_us);
        for (std::size_t c = 0; c < copy.cascades.size(); ++c) {
            const CascadeModes& modes = copy.cascades[c];
            EXPECT_EQ(modes.depth_m, sea->cascades[c].depth_m);
            for (std::size_t i = 0; i < modes.rate.size(); ++i)
                ASSERT_TRUE(modes.rate[i] == 0 || modes.rate[i] == sea->cascades[c].rate[i]) << i;
        }
    }
}

TEST(QuantisedSpectrum, the_coarse_layer_comes_first_and_each_layer_most_energetic_first) {
    const RealizationPtr sea = realized(windy_sea(), {{2048.0, 256}, {317.0, 256}, {53.0, 256}});
    const QuantisedSpectrum waves = quantise(*sea, {0.01, 0.005});
    ASSERT_GT(waves.blocks.front().shift, 0);
    EXPECT_EQ(waves.blocks.back().shift, 0);
    bool fine = false;
    for (const WaveBlock& block : waves.blocks) {
        fine = fine || block.shift == 0;
        EXPECT_EQ(block.shift == 0, fine) << "no coarse block after a fine one";
    }
    // A tenth of the blocks tell more of the sea than half of the last ones.
    const std::size_t tenth = waves.blocks.size() / 10, half = waves.blocks.size() / 2;
    EXPECT_GT(waves.without.height_m - waves.left[tenth].height_m,
              10 * (waves.left[half].height_m - waves.left.back().height_m));
}

// Naive: a sea of which nothing is worth a code is no chunk, and who gets none takes it that nothing is missed.
TEST(QuantisedSpectrum, a_sea_that_rounds_to_nothing_says_what_is_missed) {
    const SeaState state = windy_sea();
    const RealizationPtr sea = realized(state, three_cascades);
    const QuantisedSpectrum waves = quantise(*sea, {1e3});
    ASSERT_EQ(waves.blocks.size(), 1u);
    ASSERT_EQ(waves.bits.size(), 1u);
    expect_near(waves.left.at(0), waves.without);
    expect_near(waves.left[0], difference(*sea, rebuilt(*sea, state, waves)));
    EXPECT_GT(waves.left[0].height_m, 0.0);
}

// Naive: the first layer that is small enough comes first, also where it is so coarse that all of it is 0: then nothing comes, and a
// client has a flat sea of which it is told that nothing is missed.
TEST(QuantisedSpectrum, is_as_good_as_wanted_of_every_narrow_swell) {
    int two_layers = 0;
    for (const double period_s : {4.0, 6.0, 9.0})
        for (const double height_m : {0.3, 0.5, 1.0})
            for (const double exponent : {5.0, 30.0}) {
                const SeaState state = swell_sea(height_m, period_s, 0.3, exponent);
                const RealizationPtr sea = realized(state, {{700.0, 256}, {90.0, 128}});
                for (const double wanted_m : {0.02, 0.05, 0.15, 0.3}) {
                    const QuantisedSpectrum waves = quantise(*sea, {wanted_m, 0.005});
                    const SpectrumLeft left = difference(*sea, rebuilt(*sea, state, waves));
                    expect_near(waves.left.back(), left);
                    EXPECT_LE(spectrum_sigmas * left.height_m, wanted_m)
                        << height_m << " m, " << period_s << " s, " << exponent;
                    EXPECT_LE(spectrum_sigmas * left.slope, 0.005);
                    two_layers += waves.blocks.front().shift > 0;
                }
            }
    EXPECT_GT(two_layers, 0);
}

// Naive: the step of the shortest waves is so much finer than that of the longest that a code of theirs is no int any more, and what
// is told is off by the wave itself.
TEST(QuantisedSpectrum, waves_so_steep_that_no_step_is_fine_enough_say_what_is_missed) {
    CascadeModes modes = tests::calm_cascade(0.1, 64);
    for (int n = 1; n <= 20; ++n)
        tests::add_wave(modes, n, 7, 20.0, 0.3 * n);
    const Realization sea{{modes}, {}, 0};
    const SpectrumAccuracy wanted{0.01, 0.005};
    const QuantisedSpectrum waves = quantise(sea, wanted);
    for (const WaveBlock& block : waves.blocks)
        for (const std::int32_t code : block.codes)
            ASSERT_LE(std::abs(static_cast<double>(code)), 0x1p30);
    ASSERT_FALSE(waves.left.empty());
    // By the steps that it tells: half of one, of each part, is left of each wave.
    const double step = waves.steps.of(two_pi / 0.1 * std::hypot(1, 7), 0);
    EXPECT_LT(waves.left.back().height_m, 20 * step * 20);
}

TEST(QuantisedSpectrum, a_sea_without_waves_needs_no_block) {
    Realization calm = *realized(windy_sea(), three_cascades);
    for (CascadeModes& modes : calm.cascades)
        std::fill(modes.h0.begin(), modes.h0.end(), 0.0);
    const QuantisedSpectrum none = quantise(calm, {0.01, 0.005});
    EXPECT_TRUE(none.blocks.empty());
    EXPECT_EQ(none.without.height_m, 0);
}

// Naive: block numbers by dividing towards zero, which puts -1 and 1 into one block; the last row forgotten.
TEST(QuantisedSpectrum, a_wave_at_every_edge_of_the_lattice_comes_back_where_it_was) {
    SeaState state;
    for (const auto& [nx, ny] : {std::pair(1, 0),
                                 {-1, 0},
                                 {0, -1},
                                 {7, 8},
                                 {-8, -9},
                                 {31, -31},
                                 {-31, 31},
                                 {-31, -31},
                                 {8, 0}}) {
        const RealizationPtr sea = one_wave(100.0, 64, nx, ny, 1.0, 0.7);
        const Realization copy = rebuilt(*sea, state, quantise(*sea, {0.001}));
        for (std::size_t i = 0; i < sea->cascades[0].h0.size(); ++i)
            EXPECT_NEAR(std::abs(copy.cascades[0].h0[i] - sea->cascades[0].h0[i]), 0, 1e-3)
                << nx << ", " << ny;
    }
}

// Naive: a variance of what was rounded off. Waves that are given alike are rounded alike, and where they meet so do the
// errors of all.
TEST(QuantisedSpectrum, waves_that_were_given_alike_keep_the_bound_where_they_meet) {
    const SeaState state = windy_sea();
    for (const double height_m : {0.5, 0.02}) {
        const auto sea = std::make_shared<Realization>(*one_wave(100.0, 64, 4, 0, 0.0));
        CascadeModes& modes = sea->cascades[0];
        modes.given.assign(modes.h0.size(), 0);
        for (int ny = 1; ny < 20; ++ny)
            for (int nx = -20; nx < 20; ++nx) {
                const auto at = static_cast<std::size_t>(ny * 64 + (nx + 64) % 64);
                modes.h0[at] = 0.0031;
                modes.given[at] = 1;
            }
        const QuantisedSpectrum waves = quantise(*sea, {height_m, 1.0});
        SpectrumBuilder builder = begun(*sea, state, waves);
        std::size_t block = 0;
        for (;;) {
            const Realization there = builder.sea();
            double off_m = 0; // at the origin, at time 0
            for (std::size_t i = 0; i < modes.h0.size(); ++i)
                off_m += 2 * (modes.h0[i] - there.cascades[0].h0[i]).real();
            const SpectrumLeft& left = block == 0 ? waves.without : waves.left[block - 1];
            EXPECT_LE(std::abs(off_m), bound_sigmas * left.height_m * (1 + 1e-9)) << block;
            if (block == waves.blocks.size())
                break;
            ASSERT_TRUE(builder.add(waves.blocks[block++]));
        }
        EXPECT_LE(spectrum_sigmas * waves.left.back().height_m, height_m);
    }
}

TEST(QuantisedSpectrum, waves_whose_phases_were_given_are_known_by_their_blocks) {
    auto sea = std::make_shared<Realization>(*one_wave(100.0, 64, 3, 4, 1.0));
    sea->cascades[0].given.resize(64 * 64);
    sea->cascades[0].given[4 * 64 + 3] = 1;
    SeaState state;
    const Realization copy = rebuilt(*sea, state, quantise(*sea, {0.01}));
    EXPECT_TRUE(copy.cascades[0].is_given(4 * 64 + 3));
    const Realization drawn = rebuilt(*one_wave(100.0, 64, 3, 4, 1.0), state,
                                      quantise(*one_wave(100.0, 64, 3, 4, 1.0), {0.01}));
    EXPECT_FALSE(drawn.cascades[0].is_given(4 * 64 + 3));
}

// ---- what comes from elsewhere ---------------------------------------------------------------

TEST(SpectrumBuilder, refuses_blocks_of_no_cascade_and_waves_of_no_lattice_by_name) {
    const SpectrumFrame frame{
        .tiles = {{{100.0, 64}, {0.0, 2.0}}}, .choppiness = {}, .dispersion = {}};
    SpectrumBuilder builder = *SpectrumBuilder::create(frame, {0.001, 0});
    const auto why = [&](const WaveBlock& block) {
        const Result<void> fine = builder.add(block);
        return fine ? std::string() : fine.error().message;
    };
    WaveBlock block;
    block.codes.fill(1);
    block.cascade = 1;
    EXPECT_NE(why(block).find("cascade 1"), std::string::npos);
    block.cascade = -1;
    EXPECT_NE(why(block).find("cascade -1"), std::string::npos);
    block.cascade = 0;
    block.bx = 4;
    EXPECT_NE(why(block).find("(32, 0)"), std::string::npos) << why(block);
    block.bx = -4;
    EXPECT_NE(why(block).find("(-32, 0)"), std::string::npos)
        << "row and column -size/2 are nobody's";
    block.bx = 0;
    EXPECT_NE(why(block).find("(0, 0)"), std::string::npos);
    block.codes[0] = block.codes[1] = 0;
    EXPECT_EQ(why(block), "");
    EXPECT_EQ(why({0, 127, 127, 0, false, {}}), "") << "beyond, but nothing is there";
}

TEST(SpectrumBuilder, knows_the_rate_of_every_wave_of_a_band_as_the_sea_that_was_realised_does) {
    SeaState state = windy_sea();
    state.systems.emplace_back(ExplicitModes{.length_m = 77.0, .modes = {{3, 0, 0.1, 0.0}}});
    // Longer than its tile's band, of which the waves beside it are told to be a part.
    state.systems.emplace_back(
        ExplicitModes{.length_m = three_cascades[1].length_m, .modes = {{1, 0, 0.1, 0.0}}});
    for (const double loop_s : {0.0, 60.0}) {
        state.loop_period_s = loop_s;
        const RealizationPtr sea = realized(state, three_cascades);
        const Realization told = begun(*sea, state, quantise(*sea, {0.02})).sea();
        ASSERT_EQ(told.cascades.size(), 4u);
        for (std::size_t c = 0; c < 4; ++c)
            if (sea->cascades[c].carries_spectra)
                EXPECT_EQ(told.cascades[c].rate, sea->cascades[c].rate) << c;
            else
                EXPECT_EQ(std::ranges::count(told.cascades[c].rate, 0u),
                          std::ssize(told.cascades[c].rate));
    }
}

// A rate that no rate holds would abort where seas are realised.
TEST(SpectrumBuilder, refuses_waves_that_turn_too_fast_and_tiles_that_are_too_many) {
    SpectrumFrame frame{
        .tiles = {{{1e-3, 64}, {0.0, 1e9}}}, .choppiness = {}, .dispersion = {1e3, 1.0}};
    const auto band = SpectrumBuilder::create(frame, {0.001, 0});
    ASSERT_FALSE(band);
    EXPECT_NE(band.error().message.find("rad/s"), std::string::npos);
    frame.tiles[0].carries_spectra = false; // no wave is known of before it comes
    SpectrumBuilder fast = *SpectrumBuilder::create(frame, {0.001, 0});
    WaveBlock block{0, 1, 1, 0, false, {}};
    block.codes[0] = 1;
    const Result<void> fine = fast.add(block);
    ASSERT_FALSE(fine);
    EXPECT_NE(fine.error().message.find("rad/s"), std::string::npos);
    frame.tiles.assign(9, {{100.0, 1024}, {0.0, 1.0}});
    EXPECT_FALSE(SpectrumBuilder::create(frame, {0.001, 0}));
}

} // namespace
} // namespace seaway::sea
