// SPDX-License-Identifier: Apache-2.0
// Hard cases of hard_cases.md, sections A and B, that no other test bears the id of. Each says what
// naive code does.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "sea/scene/scene.h"
#include "sea/surface/inverse.h"
#include "sea/waves/directional_spectrum.h"
#include "sea/waves/mode_variances.h"
#include "sea/waves/statistics/moments.h"
#include "sea/waves/transition.h"
#include "tests/hard_cases/maps.h"
#include "tests/sea/scene_of.h"
#include "tests/sea/sea_fixture.h"
#include "tests/sea/warnings_of.h"

namespace seaway::sea {
namespace {

using testing::energy_of;
using ::testing::HasSubstr;
using testing::hs_of;
using testing::realized;
using testing::swell_sea;
using testing::three_cascades;
using testing::windy_sea;

SeaState wind_sea(double wind_mps) {
    SeaState state = windy_sea();
    std::get<WindSea>(state.systems[0]).wind_speed_10m_mps = wind_mps;
    return state;
}

// Naive: tanh's fit of the depth factor gives 0.018 in place of 5e-5, and Hs above the depth.
TEST(HardCase, A5_one_centimetre_of_water_carries_almost_nothing_and_warns) {
    const auto scene = parse_scene("[sea]\ndepth_m = 0.01\n[[sea.system]]\ntype = \"wind\"\n"
                                   "spectrum = \"tma\"\nwind_speed_10m_mps = 15\nfrom_deg = 0\n"
                                   "fetch_m = 100e3\n",
                                   "s", "");
    ASSERT_TRUE(scene);
    const SeaSummary s = summarize(scene->sea, *realize(*scene));
    EXPECT_GT(s.requested.significant_height_m, 0.0);
    EXPECT_LT(s.requested.significant_height_m, 0.1);
    EXPECT_THAT(testing::warnings_of(*scene), ::testing::Contains(HasSubstr("such waves break")));
}

// Naive: GPU tanh is NaN above 88. Ours never leaves the processor; shaders are given frequencies.
TEST(HardCase, A8_frequencies_are_finite_at_every_depth_and_wave) {
    for (const double depth : {0.01, 10.0, 1.1e4, deep_water_m})
        for (const double kd : {0.0, 1.0, 9.0, 15.0, 44.0, 89.0, 1e4, 1e8}) {
            const double k = std::isinf(depth) ? kd : kd / depth;
            EXPECT_TRUE(std::isfinite(Dispersion{9.81, 7.4e-5, depth}.omega(k)));
        }
}

// Naive: omega^5 overflows at a peak of 1e7 rad/m.
TEST(HardCase, A10_a_breath_of_wind_raises_less_than_a_micrometre_and_grows_steadily) {
    EXPECT_LT(hs_of(realized(wind_sea(1e-3), three_cascades)), 1e-6);
    double last = -1.0;
    for (double wind = 1e-6; wind <= 1.0; wind *= 2.0) {
        const double height = 4.0 * std::sqrt(requested_variance(wind_sea(wind), 0.0, 1e30));
        EXPECT_GE(height, last);
        last = height;
    }
}

// Naive: a peak of 9 km folds into the tile, or vanishes without a word.
TEST(HardCase, A11_wind_of_100_mps_is_finite_and_says_what_it_lost) {
    const Scene scene =
        testing::scene_of("[sea]\n[[sea.system]]\ntype = \"wind\"\nwind_speed_10m_mps = 100\n"
                          "from_deg = 247\nfetch_m = inf\n[[cascade]]\nlength_m = 8000\n"
                          "size = 256\n[[cascade]]\nlength_m = 300\nsize = 256\n");
    const auto sea = realize(scene);
    const SeaSummary s = summarize(scene.sea, *sea);
    ASSERT_TRUE(std::isfinite(s.realised.significant_height_m));
    const double total = std::pow(s.requested.significant_height_m / 4, 2);
    const DirectionalSpectrum spectrum(scene.sea.systems[0], scene.sea);
    double reported = 0.0, kept = 0.0;
    for (std::size_t c = 0; c < sea->cascades.size(); ++c) {
        const CascadeModes& modes = sea->cascades[c];
        reported += s.cascades[c].requested_m2;
        for (const double of_mode : mode_variances(spectrum, modes.spec, modes.band))
            kept += of_mode;
    }
    // The case's 1 %: of what modes hold, and of everything, which is in a band or reported as lost.
    EXPECT_NEAR(kept / reported, 1.0, 0.01);
    EXPECT_NEAR((reported + s.lost_below_m2 + s.lost_above_m2) / total, 1.0, 0.01);
    EXPECT_GT(s.lost_below_m2, 0.01 * total);
    const std::vector<std::string> warnings = testing::warnings_of(scene);
    EXPECT_THAT(warnings,
                ::testing::Contains(HasSubstr("longer than the largest cascade can hold")));
    EXPECT_THAT(warnings, ::testing::Contains(HasSubstr("peak wavelengths")));
}

// Naive: 1 - 0.287 ln(gamma) turns negative, log(0).
TEST(HardCase, A14_A17_shape_parameters_out_of_range_are_refused_by_name) {
    const std::string wind = "[sea]\n[[sea.system]]\ntype = \"wind\"\nwind_speed_10m_mps = 9\n"
                             "from_deg = 0\n";
    for (const char* bad : {"gamma = 0", "gamma = -1", "gamma = 0.99", "gamma = 21", "gamma = nan",
                            "swell = -0.1", "swell = 1.1", "isotropic = 2", "fetch_m = -1"}) {
        const auto scene = parse_scene(wind + bad, "s", "");
        ASSERT_FALSE(scene) << bad;
        EXPECT_THAT(scene.error().message, HasSubstr(std::string(bad).substr(0, 5)));
    }
    for (const char* good :
         {"gamma = 1", "gamma = 20", "swell = 0", "swell = 1", "fetch_m = 0", "fetch_m = inf"})
        EXPECT_TRUE(parse_scene(wind + good, "s", "")) << good;
}

// Naive: theta - theta0 is not wrapped and half the sea goes missing at +-180 degrees. Weighed alike in all directions down to
// nothing at the edge of the lattice, which therefore has no corners.
TEST(HardCase, A20_a_turn_of_the_wind_by_a_full_circle_changes_nothing) {
    for (const SpreadingKind kind :
         {SpreadingKind::cos2, SpreadingKind::hasselmann, SpreadingKind::donelan_banner}) {
        const auto variance = [kind](double degrees) {
            SeaState state = windy_sea();
            auto& wind = std::get<WindSea>(state.systems[0]);
            wind.towards_rad = degrees * pi / 180.0;
            wind.spreading.kind = kind;
            const DirectionalSpectrum spectrum(state.systems[0], state);
            const double step = 0.01;
            double sum = 0.0;
            for (int ny = -40; ny <= 40; ++ny)
                for (int nx = -40; nx <= 40; ++nx) {
                    const double kx = step * nx, ky = step * ny;
                    sum += spectrum.density(kx, ky) * std::exp(-(kx * kx + ky * ky) / 0.02);
                }
            return sum * step * step;
        };
        EXPECT_NEAR(variance(179.9) / variance(-179.9), 1.0, 1e-3);
        EXPECT_NEAR(variance(37.0) / variance(37.0 + 360.0), 1.0, 1e-12);
        double low = 1e30, high = 0.0;
        for (int degrees = 0; degrees < 360; degrees += 15) {
            low = std::min(low, variance(degrees));
            high = std::max(high, variance(degrees));
        }
        EXPECT_LT(high / low, 1.005); // the case's
    }
}

TEST(HardCase, A20_a_wind_turned_by_a_full_circle_makes_the_same_waves) {
    for (const SpreadingKind kind :
         {SpreadingKind::cos2, SpreadingKind::hasselmann, SpreadingKind::donelan_banner})
        for (const double degrees : {-179.9, -37.0, 143.0, 179.9}) {
            const auto blown = [kind](double towards_deg) {
                SeaState state = windy_sea();
                auto& wind = std::get<WindSea>(state.systems[0]);
                wind.towards_rad = towards_deg * pi / 180.0;
                wind.spreading.kind = kind;
                return realized(state, three_cascades);
            };
            const RealizationPtr once = blown(degrees), again = blown(degrees + 360.0);
            for (std::size_t c = 0; c < three_cascades.size(); ++c) {
                const CascadeModes &a = once->cascades[c], &b = again->cascades[c];
                // Of the rms of heights; the two angles differ by rounding, some 1e-15.
                const double off_m = 1e-9 * std::sqrt(energy_of(a));
                ASSERT_GT(off_m, 0);
                for (std::size_t i = 0; i < a.h0.size(); ++i)
                    ASSERT_LE(std::abs(a.h0[i] - b.h0[i]), off_m) << degrees << ' ' << i;
            }
        }
}

// Naive: one NaN poisons every mode. The case asks for 1e5 sets, each of which is a scene to read and a sea to make: 5000
// here, in two seconds; the fuzzer of scenes tries millions.
TEST(HardCase, A21_any_parameters_give_an_error_or_a_finite_sea) {
    const char* const values[] = {"nan", "inf", "-inf", "-1", "-0.0", "1e-45", "1e38", "3.7"};
    struct Table {
        const char* head;
        std::vector<std::pair<const char*, const char*>> keys; // with a value that is good
    };
    const Table tables[] = {{"[sea]",
                             {{"depth_m", "30"},
                              {"choppiness", "0.8"},
                              {"height_scale", "1.5"},
                              {"loop_period_s", "100"}}},
                            {"[[sea.system]]\ntype = \"wind\"\nspectrum = \"tma\"",
                             {{"wind_speed_10m_mps", "9"},
                              {"from_deg", "37"},
                              {"fetch_m", "1e5"},
                              {"gamma", "3.7"},
                              {"swell", "0.7"},
                              {"isotropic", "0.7"}}},
                            {"[[sea.system]]\ntype = \"swell\"\nspreading = \"cos2s\"",
                             {{"significant_height_m", "1.2"},
                              {"peak_period_s", "9"},
                              {"from_deg", "200"},
                              {"gamma", "2"},
                              {"spreading_exponent", "20"}}},
                            {"[[cascade]]\nsize = 16", {{"length_m", "300"}}}};
    std::uint32_t dice = 12345;
    const auto roll = [&dice](std::uint32_t n) {
        dice = dice * 1664525u + 1013904223u;
        return (dice >> 16) % n;
    };
    int accepted = 0;
    for (int set = 0; set < 5000; ++set) {
        std::string text;
        for (const Table& table : tables) {
            text += std::string(table.head) + "\n";
            for (const auto& [key, good] : table.keys)
                text += std::string(key) + " = " + (roll(6) != 0 ? good : values[roll(8)]) + "\n";
        }
        const auto scene = parse_scene(text, "s", "");
        if (!scene) {
            ASSERT_THAT(scene.error().message, HasSubstr("not allowed")) << text;
            continue;
        }
        ++accepted;
        const auto sea = realize(*scene);
        ASSERT_TRUE(std::isfinite(energy_of(sea->cascades[0]))) << text;
        const auto tile = hard_cases::maps(sea->cascades[0], {Field::height, Field::jacobian},
                                           3'000'000, sea->choppiness);
        ASSERT_TRUE(std::all_of(tile.begin(), tile.end(), [](float v) { return std::isfinite(v); }))
            << text;
    }
    EXPECT_GT(accepted, 500);
}

// Naive: division by dt = 0. Velocity is a field of its own here.
TEST(HardCase, B1_time_zero_is_a_time_like_any_other) {
    const DirectSum sum(realized(windy_sea(), three_cascades));
    constexpr TimeUs delta_us = 1000;
    double fastest = 0;
    for (int i = 0; i < 20; ++i) {
        const double x_m = 13.0 * i, y_m = 5.0 * i;
        const double rate = sum.at(x_m, y_m, 0).height_rate;
        // Central differences over 2 ms miss w^2 dt^2 / 6: 2e-5 of the shortest waves here, of 10 rad/s.
        EXPECT_NEAR(rate,
                    (sum.at(x_m, y_m, delta_us).height - sum.at(x_m, y_m, -delta_us).height) /
                        seconds_from_us(2 * delta_us),
                    1e-4);
        fastest = std::max(fastest, std::abs(rate));
    }
    EXPECT_GT(fastest, 0.1) << "m/s: the sea moves";
}

// Naive: t in float has a step of 62 ms at 1e6 s; motion becomes a staircase.
TEST(HardCase, B3_motion_is_as_smooth_after_30_years_as_at_the_start) {
    const DirectSum sum(realized(windy_sea(), three_cascades));
    const auto frame_rms = [&sum](double start_s) {
        double square = 0.0;
        const TimeUs start = us_from_seconds(start_s);
        for (int i = 0; i < 300; ++i) {
            const double difference = sum.at(0, 0, start + (i + 1) * 16'667).height -
                                      sum.at(0, 0, start + i * 16'667).height;
            const double velocity = sum.at(0, 0, start + i * 16'667 + 8'333).height_rate;
            square += std::pow(difference / 0.016667 - velocity, 2);
        }
        return std::sqrt(square / 300);
    };
    // Midpoint velocity against the difference: (w dt)^2 / 24 of velocity, at any age.
    EXPECT_LT(frame_rms(0.0), 1e-3);
    EXPECT_LT(frame_rms(1e6), 1e-3);
    EXPECT_LT(frame_rms(1e9), 1e-3);
}

// Naive: sines outside [-pi, pi) lose accuracy on a GPU. The wrapped phase is all that is made
// float.
TEST(HardCase, B4_the_wrapped_phase_stays_within_half_a_turn) {
    const Rate rate = rate_from_omega(3.21);
    for (const TimeUs t : {TimeUs{0}, TimeUs{1}, us_from_seconds(1e9), us_from_seconds(-1e9),
                           std::numeric_limits<TimeUs>::max()}) {
        EXPECT_GE(phase_rad(rate, t), -pi);
        EXPECT_LE(phase_rad(rate, t), pi);
    }
    // After 1000 s, 510.9 turns: a rate is rounded by 2^-65 turns/us, which are 2e-10 rad by then.
    for (const double t_s : {0.25, 1.0, -1.0, 1000.0, -1000.0})
        EXPECT_NEAR(phase_rad(rate, us_from_seconds(t_s)), std::remainder(3.21 * t_s, two_pi), 1e-9)
            << t_s;
}

// Naive: rotating by e^{i w dt} a million times drifts; dt that jumps blows up. Of foam: FoamOn.
TEST(HardCase, B5_B6_the_way_to_a_time_does_not_matter) {
    const auto sea = realized(windy_sea(), {{200.0, 32}});
    const auto cascade = NativeTransform::create(sea->cascades[0], {});
    const TimeUs end = us_from_seconds(100.0);
    const auto after = [&](int steps) {
        NativeRunner runner(1);
        std::vector<float> map(32 * 32);
        for (int step = 1; step <= steps; ++step) {
            const NativeTask task{&*cascade, end * step / steps, {Field::height}, map};
            runner.run({&task, 1});
        }
        return map;
    };
    const std::vector<float> at_once = after(1);
    EXPECT_EQ(at_once, after(100));
    EXPECT_EQ(at_once, after(6000));
    const DirectSum sum(sea); // 2e-6 of Hs: single precision
    EXPECT_NEAR(at_once[5 * 32 + 3], sum.at(3 * 6.25, 5 * 6.25, end).height, 1e-5);
    const Rate rate = sea->cascades[0].rate[5];
    EXPECT_EQ(phase_turns(rate, end), phase_turns(rate, end - 7) + phase_turns(rate, 7));
}

// Naive: floor() freezes long swell; a common divisor brings everything back early.
TEST(HardCase, B7_a_loop_returns_exactly_and_not_before) {
    SeaState state = swell_sea(3.0, 8.0);
    state.loop_period_s = 1600.0; // 200 peak periods: the case's shortest
    const auto sea = realized(state, {{900.0, 64}});
    const DirectSum sum(sea);
    for (int i = 0; i < 20; ++i) {
        const TimeUs t = us_from_seconds(7.3 * i);
        EXPECT_EQ(sum.at(5, 6, t).height, sum.at(5, 6, t + us_from_seconds(1600.0)).height);
        EXPECT_EQ(sum.at(5, 6, t).height, sum.at(5, 6, t - us_from_seconds(16'000.0)).height);
    }
    // Correlation of whole maps.
    const auto map_at = [&](double t) {
        return hard_cases::maps(sea->cascades[0], {Field::height}, us_from_seconds(t));
    };
    const auto start = map_at(0.0);
    for (double shift = 8.0; shift <= 1592.0; shift += 1.0) {
        const auto then = map_at(shift);
        double same = 0.0;
        for (std::size_t i = 0; i < then.size(); ++i)
            same += static_cast<double>(start[i]) * then[i];
        same /= static_cast<double>(then.size()) * hard_cases::rms(start) * hard_cases::rms(then);
        // The case's half; a swell is like itself one period on, in a loop or not.
        ASSERT_LT(same, std::min(shift, 1600.0 - shift) < 16.0 ? 0.75 : 0.5) << shift;
    }
}

// Naive: each cascade loops by itself and pops.
TEST(HardCase, B8_all_cascades_share_the_loop) {
    SeaState state = windy_sea();
    state.loop_period_s = 120.0;
    const auto sea = realized(state, three_cascades);
    for (const CascadeModes& modes : sea->cascades) {
        int turning = 0;
        for (std::size_t i = 0; i < modes.h0.size(); ++i)
            if (modes.h0[i] != 0.0) {
                const double turns = omega_from_rate(modes.rate[i]) * 120.0 / two_pi;
                ASSERT_NEAR(turns, std::round(turns), 1e-8);
                turning += turns > 0.5;
            }
        EXPECT_GT(turning, 100) << modes.spec.length_m;
    }
    const DirectSum sum(sea);
    const TimeUs end = us_from_seconds(120.0);
    EXPECT_GT(std::abs(sum.at(5, 6, end / 2).height - sum.at(5, 6, 0).height), 0.05);
    const LagrangianPoint before = sum.at(5, 6, end - 1000), after = sum.at(5, 6, end + 1000);
    EXPECT_NEAR(after.height - before.height, 2e-3 * sum.at(5, 6, end).height_rate, 1e-4);
    EXPECT_NEAR(after.height_rate, before.height_rate, 0.1);
}

// Naive: seconds since 1970 in float stand still for two minutes. Where no wave meets one that comes against it, the mean
// square of velocities over a tile is the same at all times.
TEST(HardCase, B9_clock_time_moves_like_any_other) {
    constexpr int size = 32;
    auto sea = *realized(windy_sea(), {{200.0, size}});
    CascadeModes& modes = sea.cascades[0];
    for (int i = 0; i < size * size; ++i)
        if (signed_index(i % size, size) < 0 || (i % size == 0 && signed_index(i / size, size) < 0))
            modes.h0[static_cast<std::size_t>(i)] = 0;
    const auto map_at = [&](Field field, double t_s) {
        return hard_cases::maps(modes, {field}, us_from_seconds(t_s));
    };
    const double first = hard_cases::rms(map_at(Field::height_rate, 3.25));
    const double later = hard_cases::rms(map_at(Field::height_rate, 1.7e9 + 3.25));
    EXPECT_NEAR(later / first, 1.0, 1e-5); // single precision of maps
    // And heights move by that from frame to frame, but for (w dt)^2 / 24 at up to 3.5 rad/s.
    auto moved = map_at(Field::height, 1.7e9 + 3.25 + 1.0 / 60);
    const auto before = map_at(Field::height, 1.7e9 + 3.25);
    for (std::size_t i = 0; i < moved.size(); ++i)
        moved[i] = 60 * (moved[i] - before[i]);
    EXPECT_NEAR(hard_cases::rms(moved) / first, 1.0, 1e-3);
}

} // namespace
} // namespace seaway::sea
