// SPDX-License-Identifier: Apache-2.0
// Stylised waves: what each shape and each ramp does; noise; lists in physical units.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include <fmt/format.h>

#include "sea/scene/scene.h"
#include "sea/surface/budget/error_budget.h"
#include "sea/surface/maps/sine_maps.h"
#include "sea/surface/surface.h"
#include "sea/waves/reference.h"
#include "sea/waves/statistics/moments.h"
#include "sea/waves/transition.h"
#include "tests/sea/scene_of.h"
#include "tests/sea/warnings_of.h"
#include "tests/support/explicit_sea.h"

namespace seaway::sea {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

Scene scene_of_sines(const std::string& system, const std::string& sea_keys = "") {
    return testing::scene_of("[sea]\nseed = 3\n" + sea_keys + "[[sea.system]]\ntype = \"sines\"\n" +
                             system);
}

std::string error_of_sines(const std::string& system) {
    return testing::error_of("[sea]\n[[sea.system]]\ntype = \"sines\"\n" + system);
}

RealizationPtr sea_of(const Scene& scene) {
    Result<Realization> sea = realize(scene);
    EXPECT_TRUE(sea) << (sea ? "" : sea.error().message);
    return std::make_shared<const Realization>(*std::move(sea));
}

const SineRamps& ramps_of(const Scene& scene) {
    return std::get<SineRamps>(scene.sea.systems[0]);
}

const SineField& field_of(const Realization& sea) {
    for (const CascadeModes& cascade : sea.cascades)
        if (!cascade.sines.empty())
            return cascade.sines[0];
    static const SineField none;
    return none;
}

const std::string six_waves = "from_deg = 200\ncount = 6\nlength_m = 256\namplitude_m = 2\n";

TEST(Sines, a_sine_has_the_height_of_a_gerstner_wave_and_moves_nothing_sideways) {
    const DirectSum sine(sea_of(scene_of_sines("shape = \"sine\"\n" + six_waves)));
    const DirectSum gerstner(sea_of(scene_of_sines("shape = \"gerstner\"\n" + six_waves)));
    double sideways = 0.0;
    for (int i = 0; i < 30; ++i) {
        const TimeUs t = us_from_seconds(1.7 * i);
        const LagrangianPoint a = sine.at(11.0 * i, -7.0 * i * i, t);
        const LagrangianPoint b = gerstner.at(11.0 * i, -7.0 * i * i, t);
        EXPECT_NEAR(a.height, b.height, 1e-10);
        EXPECT_NEAR(a.slope_x, b.slope_x, 1e-10);
        EXPECT_NEAR(a.slope_y, b.slope_y, 1e-10);
        EXPECT_NEAR(a.height_rate, b.height_rate, 1e-10);
        for (const double none : {a.displacement_x, a.displacement_y, a.displacement_x_rate,
                                  a.strain_xx, a.strain_yy, a.strain_xy})
            EXPECT_EQ(none, 0.0);
        sideways = std::max(sideways, std::hypot(b.displacement_x, b.displacement_y));
    }
    EXPECT_GT(sideways, 0.5);
}

/// Of a ramp on a tile so long that snapping to its lattice changes little.
std::vector<SineWave> long_ramp(const std::string& keys) {
    const Scene scene =
        scene_of_sines("shape = \"sine\"\nlength_m = 10000\nfrom_deg = 270\nnormalise = "
                       "false\ncount = 5\nwavelength_m = 200\namplitude_m = 2\n" +
                       keys);
    return sine_waves(ramps_of(scene), 3, 0, Dispersion{});
}

// Each ramp alone: 50 steps and more a tile, so an angle is off by 1/50 rad at most, a length by 1 %.
TEST(Sines, every_ramp_has_its_effect_and_no_other) {
    const auto k = [](const SineWave& w) { return two_pi / 10000 * std::hypot(w.nx, w.ny); };
    const auto angle = [](const SineWave& w) { return std::atan2(w.ny, w.nx); };
    const std::string one_way = "direction_spread_deg = 0\n";
    const auto turned = long_ramp(one_way + "direction_step_deg = 20\nwavenumber_ratio = 1\n");
    const auto shorter = long_ramp(one_way + "wavenumber_ratio = 1.3\namplitude_ratio = 1\n");
    const auto lower = long_ramp(one_way + "amplitude_ratio = 0.5\nwavenumber_ratio = 1\n");
    const auto faster = long_ramp(one_way + "speed_ratio = 1.3\nwavenumber_ratio = 1\n");
    const auto spread = long_ramp("direction_spread_deg = 60\nwavenumber_ratio = 1\n");
    double widest = 0.0;
    for (int i = 0; i < 5; ++i) {
        const auto at = static_cast<std::size_t>(i);
        EXPECT_NEAR(angle(turned[at]), i * 20 * pi / 180, 0.02);
        EXPECT_NEAR(angle(shorter[at]), 0.0, 1e-12);
        EXPECT_NEAR(k(shorter[at]) / (two_pi / 200 * std::pow(1.3, i)), 1.0, 0.01);
        EXPECT_EQ(shorter[at].amplitude_m, 2.0);
        EXPECT_EQ(lower[at].amplitude_m, 2.0 * std::pow(0.5, i));
        EXPECT_EQ(lower[at].nx, 50);
        EXPECT_NEAR(faster[at].omega_radps / Dispersion{}.omega(k(faster[at])), std::pow(1.3, i),
                    1e-12 * std::pow(1.3, i));
        EXPECT_NEAR(lower[at].omega_radps / Dispersion{}.omega(k(lower[at])), 1.0, 1e-12);
        EXPECT_LE(std::abs(angle(spread[at])), pi / 3 + 0.02);
        widest = std::max(widest, std::abs(angle(spread[at])));
    }
    EXPECT_GT(widest, 0.2);
    EXPECT_THAT(error_of_sines("shape = \"gerstner\"\nspeed_ratio = 1.1\n" + six_waves),
                HasSubstr("gerstner waves have the speed of their wavelength"));
    EXPECT_THAT(error_of_sines("shape = \"sine\"\ndrag = 0.1\n" + six_waves),
                HasSubstr("drag: only for shape = \"exponential\""));
}

TEST(Sines, a_list_is_what_it_says_in_metres_degrees_and_metres_a_second) {
    // Both fit the tile of 400 m exactly: 8 waves towards east, 5 towards north.
    const Scene scene = scene_of_sines("shape = \"sine\"\nlength_m = 400\ndata = '''\n"
                                       "wavelength_m,amplitude_m,from_deg,phase_rad,speed_mps\n"
                                       "50,1.5,270,0.4,3\n80,0.5,180,-1,12\n'''\n");
    const DirectSum sum(sea_of(scene));
    for (const double t : {0.0, 7.5}) {
        const double x = 33.0, y = -12.0;
        const double expected = 1.5 * std::cos(two_pi / 50 * (x - 3 * t) + 0.4) +
                                0.5 * std::cos(two_pi / 80 * (y - 12 * t) - 1.0);
        EXPECT_NEAR(sum.at(x, y, us_from_seconds(t)).height, expected, 1e-9);
    }
    EXPECT_THAT(testing::warnings_of(scene), ::testing::Not(Contains(HasSubstr("changed by"))));
    // Without speeds: the speed of the wavelength; a gerstner wave moves sideways.
    const std::string plain = "length_m = 400\ndata = '''\n"
                              "wavelength_m,amplitude_m,from_deg,phase_rad\n50,1.5,270,0.4\n'''\n";
    const DirectSum gerstner(sea_of(scene_of_sines("shape = \"gerstner\"\n" + plain)));
    const double omega = Dispersion{}.omega(two_pi / 50);
    EXPECT_NEAR(gerstner.at(10, 0, us_from_seconds(2)).height,
                1.5 * std::cos(two_pi / 50 * 10 - 2 * omega + 0.4), 1e-9);
    EXPECT_NEAR(gerstner.at(10, 0, us_from_seconds(2)).displacement_x,
                -1.5 * std::sin(two_pi / 50 * 10 - 2 * omega + 0.4), 1e-9);
    // The crest of an exponential one stands where the cosine's stands.
    const DirectSum sharp(
        sea_of(scene_of_sines("shape = \"exponential\"\nsharpness = 3\n" + plain)));
    EXPECT_NEAR(sharp.at(-0.4 * 50 / two_pi, 0, 0).height, 1.5 * (1.0 - exponential_sine(3.0).mean),
                1e-9);
    // 70 m does not fit 400 m: 6 waves of 66.7 m stand for it.
    const Scene off =
        scene_of_sines("length_m = 400\ndata = '''\n"
                       "wavelength_m,amplitude_m,from_deg,phase_rad\n74,1,270,0\n'''\n");
    EXPECT_THAT(testing::warnings_of(off), Contains(HasSubstr("changed by up to 8 % in length")));
    // Half a degree to either side of a wave that fits, whichever way it runs: no more than that.
    for (const double from_deg : {89.5, 90.5, 179.5, 180.5, 269.5, 270.5, 359.5, 0.5})
        EXPECT_THAT(testing::warnings_of(scene_of_sines(fmt::format(
                        "length_m = 400\ndata = '''\nwavelength_m,amplitude_m,from_deg,phase_rad\n"
                        "20,1,{},0\n'''\n",
                        from_deg))),
                    ::testing::Not(Contains(HasSubstr("changed by"))))
            << from_deg;
    EXPECT_THAT(error_of_sines("shape = \"noise\"\n" + plain), HasSubstr("noise has ramps only"));
    EXPECT_THAT(error_of_sines("count = 3\n" + plain), HasSubstr("count: belongs to ramps"));
    EXPECT_THAT(error_of_sines("length_m = 400\ndata = '''\n50,1.5,270,0.4\n'''\n"),
                HasSubstr("data:1: no header"));
    EXPECT_THAT(error_of_sines("shape = \"gerstner\"\nlength_m = 400\ndata = '''\nwavelength_m,"
                               "amplitude_m,from_deg,phase_rad,speed_mps\n50,1,0,0,2\n'''\n"),
                HasSubstr("speed_mps"));
    EXPECT_THAT(
        error_of_sines("length_m = 400\ndata = '''\nwavelength_m,amplitude_m,from_deg,phase_rad\n"
                       "50,101,0,0\n'''\n"),
        HasSubstr("amplitude_m = 101; allowed: 0 .. 100"));
}

const std::string noise = "shape = \"noise\"\nfrom_deg = 250\nlength_m = 200\nwavelength_m = 50\n"
                          "count = 3\namplitude_m = 1.5\n";

TEST(Noise, has_exact_derivatives_mean_zero_and_repeats_with_its_tile) {
    const DirectSum sum(sea_of(scene_of_sines(noise)));
    const double h = 1e-4;
    for (int i = 0; i < 60; ++i) {
        const double x = 2.33 * i, y = 1.17 * i * i;
        const TimeUs t = us_from_seconds(0.37 * i);
        const LagrangianPoint p = sum.at(x, y, t);
        // h^2 / 6 times third derivatives: 60 a / cell^3 in the shortest octave, cells of 6 m.
        EXPECT_NEAR((sum.at(x + h, y, t).height - sum.at(x - h, y, t).height) / (2 * h), p.slope_x,
                    1e-8);
        EXPECT_NEAR((sum.at(x, y + h, t).height - sum.at(x, y - h, t).height) / (2 * h), p.slope_y,
                    1e-8);
        EXPECT_NEAR((sum.at(x, y, t + 100).height - sum.at(x, y, t - 100).height) / 2e-4,
                    p.height_rate, 1e-6);
        EXPECT_NEAR(sum.at(x + 200, y - 400, t).height, p.height, 1e-10);
        EXPECT_EQ(p.displacement_x, 0.0);
    }
}

TEST(Noise, level_variance_and_slopes_are_what_the_summary_says) {
    const Scene scene = scene_of_sines(noise);
    const RealizationPtr sea = sea_of(scene);
    const SineField& field = field_of(*sea);
    ASSERT_EQ(field.octaves.size(), 3u);
    double mean = 0.0, square = 0.0, slopes = 0.0;
    const int n = 512; // 16 nodes in the smallest cell: the sums are integrals to 1e-4
    for (int iy = 0; iy < n; ++iy)
        for (int ix = 0; ix < n; ++ix) {
            const LagrangianPoint p = sines_at(field, 200.0 * ix / n, 200.0 * iy / n, 0);
            mean += p.height / (n * n);
            square += p.height * p.height / (n * n);
            slopes += (p.slope_x * p.slope_x + p.slope_y * p.slope_y) / (n * n);
        }
    EXPECT_NEAR(mean, 0.0, 1e-6);
    double variance = 0.0;
    for (const SineLine& line : sine_lines(field))
        variance += line.variance_m2();
    // Octaves are independent draws: their products over one tile leave a few per cent.
    EXPECT_NEAR(square / variance, 1.0, 0.1);
    const SeaSummary summary = summarize(scene.sea, *sea);
    EXPECT_NEAR(summary.realised.significant_height_m, 4 * std::sqrt(variance), 1e-9);
    EXPECT_NEAR(slopes / summary.realised.mean_square_slope, 1.0, 0.15);
    // Over seeds: the requested height. 32 seeds of 8 x 8 and more corners scatter by 2 % in the mean.
    double realised = 0.0;
    for (std::uint64_t seed = 0; seed < 32; ++seed) {
        SeaState state = scene.sea;
        state.seed = seed;
        realised +=
            std::pow(
                summarize(state, *realize(state, scene.cascades)).realised.significant_height_m,
                2) /
            32;
    }
    EXPECT_NEAR(realised / std::pow(summary.requested.significant_height_m, 2), 1.0, 0.06);
}

TEST(Noise, drifts_at_the_speed_of_its_wavelength_times_the_ramp) {
    const Scene scene =
        scene_of_sines("shape = \"noise\"\nfrom_deg = 270\nlength_m = 200\nwavelength_m = "
                       "50\ncount = 2\nspeed_ratio = 1.4\ndirection_spread_deg = 0\n");
    const SineField field = field_of(*sea_of(scene));
    const Dispersion d;
    EXPECT_NEAR(field.octaves[0].speed_x_mps, d.omega(two_pi / 50) / (two_pi / 50), 1e-6);
    EXPECT_NEAR(field.octaves[1].speed_x_mps, 1.4 * d.omega(two_pi / 25) / (two_pi / 25), 1e-6);
    SineField one = field;
    one.octaves.resize(1);
    const double moved = one.octaves[0].speed_x_mps * 3.0;
    EXPECT_NEAR(sines_at(one, 17.0 + moved, 5.0, 3'000'000).height,
                sines_at(one, 17.0, 5.0, 0).height, 1e-9);
}

// Naive: what is too slow for its loop stands still, or goes east and north whatever was asked for.
TEST(Noise, too_slow_for_its_loop_it_drifts_by_one_tile_the_way_that_it_was_given) {
    for (const auto& [from_deg, towards] :
         {std::pair{270, "east"}, {90, "west"}, {180, "north"}, {0, "south"}}) {
        // 8.8 m/s for 2 s are a tenth of the tile.
        const Scene scene = scene_of_sines(
            fmt::format("shape = \"noise\"\nfrom_deg = {}\nlength_m = 200\nwavelength_m = 50\n"
                        "count = 1\ndirection_spread_deg = 0\n",
                        from_deg),
            "loop_period_s = 2\n");
        const NoiseOctave octave = field_of(*sea_of(scene)).octaves[0];
        const bool along_x = from_deg % 180 == 90;
        const double sign = from_deg == 270 || from_deg == 180 ? 1.0 : -1.0;
        EXPECT_NEAR(along_x ? octave.speed_x_mps : octave.speed_y_mps, sign * 100.0, 1e-6)
            << towards;
        EXPECT_NEAR(along_x ? octave.speed_y_mps : octave.speed_x_mps, 0.0, 1e-6) << towards;
    }
}

TEST(Noise, closes_a_loop_and_glides_without_a_jump) {
    const Scene scene = scene_of_sines(noise, "loop_period_s = 40\n");
    const RealizationPtr sea = sea_of(scene);
    const DirectSum sum(sea);
    EXPECT_NEAR(sum.at(3, 4, us_from_seconds(39.999999)).height, sum.at(3, 4, 0).height, 1e-4);
    EXPECT_NE(sum.at(3, 4, us_from_seconds(20)).height, sum.at(3, 4, 0).height);
    // Another depth, so another speed: at the change the pattern stands where it stood.
    const Scene deep = scene_of_sines(noise), shallow = scene_of_sines(noise, "depth_m = 4\n");
    const TimeUs start = us_from_seconds(1000), end = us_from_seconds(1010);
    const auto glide = SeaTransition::create(sea_of(deep), sea_of(shallow), start, end);
    ASSERT_TRUE(glide);
    for (const TimeUs edge : {start, end}) {
        const double before = DirectSum(glide->at(edge - 1)).at(31, 7, edge - 1).height;
        const double after = DirectSum(glide->at(edge)).at(31, 7, edge).height;
        EXPECT_NEAR(before, after, 1e-4);
    }
    EXPECT_NE(field_of(*sea_of(shallow)).octaves[0].rate_x,
              field_of(*sea_of(deep)).octaves[0].rate_x);
}

// Every wave has turned a whole number of times when the loop ends, and in between the tile is what it
// was at no other time.
TEST(Sines, gerstner_waves_close_their_loop_and_without_one_do_not) {
    const std::string waves =
        "shape = \"gerstner\"\nfrom_deg = 270\ncount = 6\namplitude_m = 2\nlength_m = 256\n";
    const auto sea = sea_of(scene_of_sines(waves, "loop_period_s = 30\n"));
    const DirectSum looped(sea);
    const DirectSum endless(sea_of(scene_of_sines(waves)));
    const auto far_m = [](const DirectSum& sum, TimeUs t) {
        double far = 0.0;
        for (int i = 0; i < 20; ++i) {
            const LagrangianPoint then = sum.at(7.0 * i, 3.0 * i, t);
            const LagrangianPoint first = sum.at(7.0 * i, 3.0 * i, 0);
            far = std::max({far, std::abs(then.height - first.height),
                            std::abs(then.displacement_x - first.displacement_x)});
        }
        return far;
    };
    for (const TimeUs loops : {1, 2, -3, 1000})
        EXPECT_EQ(far_m(looped, loops * 30'000'000), 0.0) << loops;
    for (const TimeUs t_s : {7, 15, 29, 31})
        EXPECT_GT(far_m(looped, t_s * 1'000'000), 0.1) << t_s;
    EXPECT_GT(far_m(endless, 30'000'000), 0.1);
    // A sum begins its loop anew; the waves themselves have come round by then.
    int turning = 0;
    for (const CascadeModes& modes : sea->cascades)
        for (std::size_t i = 0; i < modes.h0.size(); ++i)
            if (modes.h0[i] != 0.0) {
                const double turns = omega_from_rate(modes.rate[i]) * 30.0 / two_pi;
                EXPECT_NEAR(turns, std::round(turns), 1e-9);
                turning += turns > 0.5;
            }
    EXPECT_GE(turning, 6);
}

// Each sea takes its phases at the time of its own loop. Naive: at the change the old waves jump to
// where that of the new loop has them.
TEST(Sines, glide_from_loop_to_loop_of_another_length_without_a_jump) {
    for (const std::string shape : {"sine", "exponential", "noise"}) {
        const std::string waves =
            "shape = \"" + shape +
            "\"\nfrom_deg = 200\ncount = 3\nlength_m = 256\namplitude_m = 2\n";
        const RealizationPtr from = sea_of(scene_of_sines(waves, "loop_period_s = 10\n"));
        const RealizationPtr to = sea_of(scene_of_sines(waves, "loop_period_s = 13\n"));
        // 2 s into the hundredth loop of one, 1 s into the 77th of the other.
        const TimeUs start = us_from_seconds(1002), end = us_from_seconds(1010);
        const auto glide = SeaTransition::create(from, to, start, end);
        ASSERT_TRUE(glide);
        for (const TimeUs edge : {start, end}) {
            const double before = DirectSum(glide->at(edge - 1)).at(31, 7, edge - 1).height;
            const double after = DirectSum(glide->at(edge)).at(31, 7, edge).height;
            EXPECT_NEAR(before, after, 1e-4) << shape; // waves of 2 m move 1e-5 m in a microsecond
        }
    }
}

TEST(Sines, keyframes_of_every_shape_are_the_sum_at_their_nodes) {
    for (const char* shape : {"sine", "exponential", "noise"}) {
        const RealizationPtr sea = sea_of(scene_of_sines(fmt::format(
            "shape = \"{}\"\nfrom_deg = 40\nlength_m = 128\nwavelength_m = 40\ncount = 3\n",
            shape)));
        const SineField& field = field_of(*sea);
        Keyframe frame;
        frame.size = 32;
        frame.length_m = 128.0;
        frame.fields = linear_fields;
        frame.values.assign(static_cast<std::size_t>(linear_field_count) * 1024, 0.0f);
        const TimeUs t = us_from_seconds(7.0);
        add_sines(field, t, frame);
        for (const int node : {0, 5 * 32 + 3, 31 * 32 + 17}) {
            const auto at = static_cast<std::size_t>(node);
            const int row = node / 32, column = node % 32;
            const LagrangianPoint p = sines_at(field, 4.0 * column, 4.0 * row, t);
            for (const Field f : linear_fields) // floats of about 1
                EXPECT_NEAR(frame.plane(f)[at], value_of(p, f), 1e-6) << info(f).name;
        }
    }
}

// Each field is what its row of the table says of the height: the row's derivative of it, or nothing
// where the row is of sideways motion. So a field that a shape forgets is seen, whichever is added.
TEST(Sines, every_field_of_every_shape_is_the_derivative_that_its_row_names) {
    for (const char* shape : {"sine", "exponential", "noise"}) {
        const RealizationPtr sea = sea_of(scene_of_sines(fmt::format(
            "shape = \"{}\"\nfrom_deg = 40\nlength_m = 128\nwavelength_m = 40\ncount = 3\n",
            shape)));
        const SineField& field = field_of(*sea);
        const double h = 1e-4;
        for (int i = 0; i < 40; ++i) {
            const double x = 3.17 * i, y = 1.3 * i * i;
            const TimeUs t = us_from_seconds(0.71 * i);
            for (const Field f : linear_fields) {
                const FieldInfo& row = info(f);
                const auto base = [&](double dx, double dy) {
                    const LagrangianPoint p = sines_at(field, x + dx, y + dy, t);
                    return row.time_rate ? p.height_rate : p.height;
                };
                double expected = 0; // sideways
                if (row.basis == Basis::one)
                    expected = base(0, 0);
                else if (row.basis == Basis::kx)
                    expected = (base(h, 0) - base(-h, 0)) / (2 * h);
                else if (row.basis == Basis::ky)
                    expected = (base(0, h) - base(0, -h)) / (2 * h);
                // h^2 / 6 times third derivatives, and rounding of heights over h.
                EXPECT_NEAR(value_of(sines_at(field, x, y, t), f), expected, 1e-7)
                    << shape << ", " << row.name;
            }
        }
    }
}

// Sampling between nodes and keyframes stays inside the bound that is stated, and comes near it.
TEST(Sines, sampled_sines_and_noise_stay_inside_the_stated_bound) {
    for (const char* shape : {"sine", "noise"}) {
        const Scene scene = scene_of_sines(
            fmt::format("shape = \"{}\"\nfrom_deg = 40\nlength_m = 200\nwavelength_m = 50\n"
                        "count = 3\namplitude_m = 1.5\n",
                        shape) +
            "[[cascade]]\nlength_m = 200\nsize = 256\n");
        const RealizationPtr sea = sea_of(scene);
        const ErrorBudget budget = plan_budget(*sea, 0.01);
        const TimeUs interval = budget.cascades[0].interval_us;
        const Surface surface(
            {{std::make_shared<SplineMap>(*tests::exact_keyframe(sea, 0, 0)),
              std::make_shared<SplineMap>(*tests::exact_keyframe(sea, 0, interval))}},
            sea->choppiness, fold_search(budget), map_error(budget, 0.0));
        const DirectSum sum(sea);
        std::mt19937 random(2);
        std::uniform_real_distribution<double> place(-1e4, 1e4);
        double worst_share = 0;
        for (int i = 0; i < 2000; ++i) {
            const TimeUs t = interval * (i % 16) / 16;
            const double x = place(random), y = place(random);
            const double error = std::abs(surface.at(x, y, t).height - sum.at(x, y, t).height);
            EXPECT_LE(error, budget.interpolation_m) << shape;
            worst_share = std::max(worst_share, error / budget.interpolation_m);
        }
        EXPECT_GT(worst_share, 0.02) << shape << ": a bound that nothing comes near says nothing";
    }
}

TEST(Sines, every_shape_survives_a_round_trip_through_the_effective_scene) {
    for (const std::string& system :
         {"shape = \"sine\"\nspeed_ratio = 1.07\ndirection_step_deg = 12.3\n" + six_waves,
          "shape = \"gerstner\"\ndirection_step_deg = -12.3\n" + six_waves,
          "shape = \"exponential\"\nspeed_ratio = 1.07\ndrag = 0.3\nsharpness = 1.9\n" + six_waves,
          noise,
          std::string("shape = \"sine\"\nlength_m = 400\ndata = '''\nwavelength_m,amplitude_m,"
                      "from_deg,phase_rad,speed_mps\n50,1.5,271.3,0.4,3.3\n'''\n"),
          std::string("shape = \"exponential\"\nsharpness = 2\nlength_m = 400\ndata = '''\n"
                      "wavelength_m,amplitude_m,from_deg,phase_rad\n51.7,1.5,33.3,0.4\n'''\n")}) {
        const Scene scene = scene_of_sines(system);
        const Result<Scene> again = parse_scene(to_toml(scene), "again", "");
        ASSERT_TRUE(again) << again.error().message << to_toml(scene);
        EXPECT_EQ(to_toml(*again), to_toml(scene));
        for (const double x : {0.0, 77.7})
            EXPECT_EQ(DirectSum(sea_of(*again)).at(x, 3, 5'000'000).height,
                      DirectSum(sea_of(scene)).at(x, 3, 5'000'000).height);
    }
}

} // namespace
} // namespace seaway::sea
