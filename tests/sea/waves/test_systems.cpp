// SPDX-License-Identifier: Apache-2.0
// Measured, explicit and stylised seas, and presets.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include <fmt/format.h>

#include "sea/scene/presets.h"
#include "sea/scene/scene.h"
#include "sea/surface/maps/sine_maps.h"
#include "sea/waves/directional_spectrum.h"
#include "sea/waves/statistics/moments.h"
#include "tests/sea/csv.h"
#include "tests/sea/scene_of.h"
#include "tests/sea/sea_fixture.h"
#include "tests/sea/warnings_of.h"

namespace seaway::sea {
namespace {

using testing::error_of;
using ::testing::HasSubstr;
using testing::scene_of;
using testing::Table;

std::string measured_scene(const std::string& csv, const std::string& more = "") {
    return "[sea]\n[[sea.system]]\ntype = \"measured\"\n" + more + "data = '''\n" + csv + "'''\n";
}

/// A buoy table of one record of a reference file.
std::string buoy_csv(const Table& table, const std::string& record) {
    std::string csv = "f_hz,df_hz,s_m2_hz\n";
    for (std::size_t r = 0; r < table.size(); ++r)
        if (table.text(r, table.header()[0]) == record)
            csv += table.text(r, "f_Hz") + "," + table.text(r, "df_Hz") + "," +
                   table.text(r, "S_m2_Hz") + "\n";
    return csv;
}

TEST(Measured, P07_cdip_spectra_give_the_reported_moments) {
    const Table spectra("P07_cdip_spectra");
    const Table expected("P07_cdip_expected");
    for (const char* buoy : {"CDiP1", "CDiP6"}) {
        const auto value = [&](const char* quantity) {
            return expected.number(expected.find(buoy, quantity), "value");
        };
        const Scene scene = scene_of(measured_scene(buoy_csv(spectra, buoy), "from_deg = 270\n"));
        const auto realization = realize(scene);
        ASSERT_TRUE(realization);
        const SeaStatistics s = summarize(scene.sea, *realization).requested;
        // m0 = sum S df exactly; the first bin's lowest 0.1 % is left out of the logarithm.
        EXPECT_NEAR(std::pow(s.significant_height_m / 4, 2) / value("m0"), 1.0, 1e-9);
        EXPECT_NEAR(s.significant_height_m / value("Hm0"), 1.0, 0.01);
        // Higher moments see the bin's width, the buoy's own sums only its middle: 1 %.
        EXPECT_NEAR(s.zero_crossing_period_s / value("T0"), 1.0, 0.01);
        EXPECT_NEAR(s.mean_period_s / value("Tm"), 1.0, 0.01);
        EXPECT_NEAR(s.peak_period_s / value("Tp"), 1.0, 0.06); // anywhere in the highest bin
    }
}

TEST(Measured, P09_datawell_spectra_give_the_reported_height_and_period) {
    const Table spectra("P09_datawell_spectra");
    const Table expected("P09_datawell_expected");
    for (std::size_t r = 0; r < expected.size(); ++r) {
        const Scene scene = scene_of(
            measured_scene(buoy_csv(spectra, expected.text(r, "record")), "from_deg = 270\n"));
        const SeaStatistics s = summarize(scene.sea, *realize(scene)).requested;
        EXPECT_NEAR(s.significant_height_m / expected.number(r, "Hm0_reported_m"), 1.0, 0.005);
        EXPECT_NEAR(s.zero_crossing_period_s / expected.number(r, "Tz_reported_s"), 1.0, 0.005);
    }
}

TEST(Measured, maximum_entropy_keeps_all_four_coefficients_and_is_nowhere_negative) {
    for (const double r1 : {0.0, 0.3, 0.7, 0.95})
        for (const double r2 : {0.0, 0.5, 0.9}) {
            const std::complex<double> c1 = std::polar(r1, 0.7);
            const std::complex<double> c2 =
                c1 * c1 + std::polar(r2 * (1.0 - r1 * r1), 2.0); // a density can have these
            const auto d = MeasuredDirections::from_moments(c1, c2);
            EXPECT_FALSE(d.changed());
            std::complex<double> m0, m1, m2;
            const int n = 200000; // trapezoid on a circle converges exponentially
            for (int i = 0; i < n; ++i) {
                const double phi = two_pi * i / n, density = d(phi);
                ASSERT_GE(density, 0.0);
                m0 += density * two_pi / n;
                m1 += std::polar(density * two_pi / n, phi);
                m2 += std::polar(density * two_pi / n, 2 * phi);
            }
            EXPECT_NEAR(std::abs(m0 - 1.0), 0.0, 1e-9);
            EXPECT_NEAR(std::abs(m1 - c1), 0.0, 1e-9);
            EXPECT_NEAR(std::abs(m2 - c2), 0.0, 1e-9);
        }
}

TEST(Measured, coefficients_that_no_density_has_are_moved_and_counted) {
    const auto noisy = MeasuredDirections::from_moments({0.9, 0.0}, std::complex(-0.9, 0.0));
    EXPECT_TRUE(noisy.changed());
    EXPECT_EQ(noisy.first_moment(), std::complex(0.9, 0.0)); // c1 stays
    for (double phi = 0.0; phi < two_pi; phi += 0.01)
        ASSERT_TRUE(noisy(phi) >= 0.0 && std::isfinite(noisy(phi)));
    const Scene scene = scene_of(measured_scene("f_hz,df_hz,s_m2_hz,a1,b1,a2,b2\n"
                                                "0.1,0.01,4,0.9,0,-0.9,0\n"
                                                "0.11,0.01,4,0.5,0,0.1,0\n"));
    EXPECT_THAT(testing::warnings_of(scene), ::testing::Contains(HasSubstr("1 of 2 frequencies")));
}

// A buoy's angles are "from, clockwise from north": a wave from the west (270) goes east (0).
TEST(Measured, buoy_angles_become_directions_of_travel) {
    const double a1 = 0.8 * std::cos(270 * pi / 180), b1 = 0.8 * std::sin(270 * pi / 180);
    const double a2 = 0.5 * std::cos(540 * pi / 180), b2 = 0.5 * std::sin(540 * pi / 180);
    for (const bool second : {false, true}) {
        const Scene scene = scene_of(measured_scene(
            second ? fmt::format("f_hz,df_hz,s_m2_hz,a1,b1,a2,b2\n0.1,0.02,5,{},{},{},{}\n", a1, b1,
                                 a2, b2)
                   : fmt::format("f_hz,df_hz,s_m2_hz,a1,b1\n0.1,0.02,5,{},{}\n", a1, b1)));
        const SeaStatistics s = summarize(scene.sea, *realize(scene)).requested;
        EXPECT_NEAR(s.mean_towards_rad, 0.0, 1e-9);
        EXPECT_NEAR(s.spread_rad, std::sqrt(2 * (1 - 0.8)), 1e-9);
        const DirectionalSpectrum spectrum(scene.sea.systems[0], scene.sea);
        const double k = scene.sea.dispersion().wavenumber(two_pi * 0.1);
        EXPECT_GT(spectrum.density(k, 0), 10 * spectrum.density(-k, 0));
        EXPECT_NEAR(spectrum.density(0, k) / spectrum.density(0, -k), 1.0, 1e-6);
    }
}

TEST(Measured, two_dimensional_table_keeps_its_energy_and_direction) {
    std::string csv = "f_hz,dir_from_deg,e_m2_hz_deg\n";
    double sum = 0.0;
    for (const double f : {0.08, 0.10, 0.12})
        for (int dir = 0; dir < 360; dir += 10) {
            const double e = std::exp(-std::pow(std::remainder(dir - 300, 360.0) / 25.0, 2)) * f;
            csv += fmt::format("{},{},{}\n", f, dir, e);
            sum += e * 10 * 0.02;
        }
    const Scene scene = scene_of(measured_scene(csv));
    const SeaStatistics s = summarize(scene.sea, *realize(scene)).requested;
    EXPECT_NEAR(std::pow(s.significant_height_m / 4, 2) / sum, 1.0, 1e-9);
    EXPECT_NEAR(s.mean_towards_rad, -30.0 * pi / 180, 1e-9);
}

TEST(Measured, realised_sea_has_the_variance_and_the_direction_of_the_buoy) {
    const Scene scene =
        scene_of(measured_scene("f_hz,df_hz,s_m2_hz,a1,b1,a2,b2\n"
                                "0.10,0.02,8,0.0,-0.9,-0.66,0.0\n0.12,0.02,5,0.0,-0.8,-0.5,0.0\n"
                                "0.14,0.02,2,0.0,-0.7,-0.4,0.0\n") +
                 "[[cascade]]\nlength_m = 2000\nsize = 128\n");
    double variance = 0.0;
    std::complex<double> direction;
    for (std::uint64_t seed = 0; seed < 8; ++seed) {
        SeaState sea = scene.sea;
        sea.seed = seed;
        const SeaStatistics s = summarize(sea, *realize(sea, scene.cascades)).realised;
        variance += std::pow(s.significant_height_m / 4, 2) / 8;
        direction += std::polar(1.0 / 8, s.mean_towards_rad);
    }
    EXPECT_NEAR(variance / 0.3, 1.0, 0.08);     // 3 standard errors of 8 seeds of 8 % in m0
    EXPECT_NEAR(std::arg(direction), 0.0, 0.1); // b1 < 0: from the west
}

TEST(Measured, errors_name_the_line) {
    EXPECT_THAT(error_of(measured_scene("f_hz,df_hz,s_m2_hz\n0.1,0.01,x\n", "from_deg=0\n")),
                HasSubstr("data:2: s_m2_hz = 'x'"));
    EXPECT_THAT(error_of(measured_scene("f_hz,df_hz,s_m2_hz\n0.1,0.01,-4\n", "from_deg=0\n")),
                HasSubstr("s_m2_hz = -4"));
    EXPECT_THAT(error_of(measured_scene("f_hz,df_hz\n0.1,0.01\n")), HasSubstr("header must be"));
    EXPECT_THAT(error_of(measured_scene("f_hz,df_hz,s_m2_hz\n0.1,0.01,nan\n")), HasSubstr("nan"));
    EXPECT_THAT(error_of(measured_scene("f_hz,df_hz,s_m2_hz\n0.2,0.01,1\n0.1,0.01,1\n")),
                HasSubstr("ascend"));
    EXPECT_THAT(error_of("[sea]\n[[sea.system]]\ntype=\"measured\"\nfile=\"none.csv\""),
                HasSubstr("none.csv"));
    EXPECT_THAT(error_of(measured_scene("f_hz,df_hz,s_m2_hz\n0.1,0.01,1\n")),
                HasSubstr("from_deg: missing"));
}

std::string modes_scene(const std::string& rows, const std::string& cascades = "") {
    return "[sea]\nchoppiness = 0\n[[sea.system]]\ntype = \"modes\"\nlength_m = 300\ndata = '''\n"
           "nx,ny,amplitude_m,phase_rad\n" +
           rows + "'''\n" + cascades;
}

TEST(Modes, each_explicit_wave_is_its_cosine) {
    const Scene scene = scene_of(modes_scene("2,0,1.5,0.3\n-1,3,0.5,-2\n"));
    const auto sea = std::make_shared<const Realization>(*realize(scene));
    ASSERT_EQ(sea->cascades.size(), 4u); // three of the default and one of 300 m
    EXPECT_EQ(sea->cascades[1].spec.length_m, 300.0);
    EXPECT_EQ(sea->cascades[1].spec.size, 64);
    const DirectSum sum(sea);
    const Dispersion d = scene.sea.dispersion();
    for (const double t : {0.0, 3.25}) {
        const double x = 12.5, y = -40.0;
        double expected = 0.0;
        for (const auto& [nx, ny, a, phase] :
             {std::tuple{2, 0, 1.5, 0.3}, std::tuple{-1, 3, 0.5, -2.0}}) {
            const double step = two_pi / 300.0;
            const double omega = d.omega(step * std::hypot(nx, ny));
            expected += a * std::cos(step * (nx * x + ny * y) - omega * t + phase);
        }
        EXPECT_NEAR(sum.at(x, y, us_from_seconds(t)).height, expected, 1e-9);
    }
    EXPECT_THAT(testing::warnings_of(scene),
                ::testing::Contains(HasSubstr("300 m; one of size 64")));
    const SeaSummary summary = summarize(scene.sea, *sea);
    EXPECT_NEAR(summary.requested.significant_height_m, 4 * std::sqrt(1.125 + 0.125), 1e-12);
    EXPECT_NEAR(summary.realised.significant_height_m, summary.requested.significant_height_m,
                1e-12);
}

TEST(Modes, live_on_a_cascade_of_their_length_whatever_its_band) {
    const Scene scene =
        scene_of(modes_scene("20,20,1,0\n", "[[cascade]]\nlength_m=300\nsize=64\n"));
    const auto sea = realize(scene);
    ASSERT_EQ(sea->cascades.size(), 1u);
    EXPECT_EQ(sea->cascades[0].h0[20 * 64 + 20], 0.5);
    EXPECT_NE(sea->cascades[0].rate[20 * 64 + 20], 0u);
    const Scene coarse =
        scene_of(modes_scene("40,0,1,0\n", "[[cascade]]\nlength_m=300\nsize=64\n"));
    const auto error = realize(coarse);
    ASSERT_FALSE(error);
    EXPECT_THAT(error.error().message, HasSubstr("sea.system[1]"));
    EXPECT_THAT(error_of(modes_scene("0,0,1,0\n")), HasSubstr("not both 0"));
    EXPECT_THAT(error_of(modes_scene("1.5,0,1,0\n")), HasSubstr("whole numbers"));
}

std::string sines_scene(const std::string& more) {
    return "[sea]\nseed = 3\n[[sea.system]]\ntype = \"sines\"\nfrom_deg = 270\n" + more;
}

TEST(Sines, gerstner_waves_become_modes_that_obey_dispersion) {
    const Scene scene = scene_of(sines_scene("count = 6\namplitude_m = 2\nlength_m = 256\n"));
    const auto sea = realize(scene);
    double amplitudes = 0.0;
    for (const CascadeModes& tile : sea->cascades)
        for (std::size_t i = 0; i < tile.h0.size(); ++i)
            if (tile.h0[i] != 0.0) {
                amplitudes += 2.0 * std::abs(tile.h0[i]);
                const int size = tile.spec.size;
                const double k = tile.spec.wavenumber_step_radpm() *
                                 std::hypot(signed_index(int(i) % size, size),
                                            signed_index(int(i) / size, size));
                EXPECT_NEAR(omega_from_rate(tile.rate[i]), scene.sea.dispersion().omega(k), 1e-9);
            }
    EXPECT_NEAR(amplitudes, 2.0, 1e-9); // normalised; two waves on one vector would only add less
}

// T52, T53, T54: normalised heights with unnormalised slopes, a derivative without A, a warp that
// ignores the chain rule, a sea level that is not zero.
TEST(Sines, T52_T53_T54_exponential_sines_have_exact_derivatives_and_mean_zero) {
    for (const double drag : {0.0, 0.4}) {
        const Scene scene = scene_of(
            sines_scene(fmt::format("shape = \"exponential\"\ncount = 8\namplitude_m = 1.5\n"
                                    "length_m = 128\nwavelength_m = 50\ndrag = {}\n"
                                    "sharpness = 1.7\nspeed_ratio = 1.05\n",
                                    drag)));
        const auto sea = std::make_shared<const Realization>(*realize(scene));
        const DirectSum sum(sea);
        const double h = 1e-4;
        double mean = 0.0;
        for (int i = 0; i < 50; ++i) {
            const double x = 2.3 * i, y = 1.1 * i * i;
            const TimeUs t = us_from_seconds(0.37 * i);
            const LagrangianPoint p = sum.at(x, y, t);
            // h^2 / 6 times third derivatives below 10, rounding 1e-15 / h.
            EXPECT_NEAR((sum.at(x + h, y, t).height - sum.at(x - h, y, t).height) / (2 * h),
                        p.slope_x, 1e-7);
            EXPECT_NEAR((sum.at(x, y + h, t).height - sum.at(x, y - h, t).height) / (2 * h),
                        p.slope_y, 1e-7);
            EXPECT_NEAR((sum.at(x, y, t + 100).height - sum.at(x, y, t - 100).height) / 2e-4,
                        p.height_rate, 1e-6);
            // Periodic on its tile.
            EXPECT_NEAR(sum.at(x + 128, y - 256, t).height, p.height, 1e-10);
        }
        const int n = 128; // beyond the 8th harmonic of the shortest wave
        const DirectSum::Moment start = sum.at_time(0);
        for (int iy = 0; iy < n; ++iy)
            for (int ix = 0; ix < n; ++ix)
                mean += start.at(128.0 * ix / n, 128.0 * iy / n).height / (n * n);
        EXPECT_NEAR(mean, 0.0, drag == 0.0 ? 1e-9 : 0.05); // drag shifts waves, hardly the level
    }
}

// T54: speeds that have nothing to do with the wavelength.
TEST(Sines, T54_speeds_follow_dispersion_times_the_ramp) {
    SineRamps ramps;
    ramps.kind = SineKind::exponential;
    ramps.speed_ratio = 1.1;
    double ramp = 1.0;
    for (const SineWave& wave : sine_waves(ramps, 3, 0, Dispersion{})) {
        const double k = two_pi / ramps.length_m * std::hypot(wave.nx, wave.ny);
        EXPECT_NEAR(wave.omega_radps / (Dispersion{}.omega(k) * ramp), 1.0, 1e-12);
        ramp *= 1.1;
    }
}

TEST(Sines, keyframes_get_the_same_sines_as_the_sum) {
    const Scene scene = scene_of(
        sines_scene("shape = \"exponential\"\nlength_m = 128\nwavelength_m = 60\ncount = 5\n"));
    const auto sea = std::make_shared<const Realization>(*realize(scene));
    const DirectSum sum(sea);
    const auto tile = std::find_if(sea->cascades.begin(), sea->cascades.end(),
                                   [](const CascadeModes& c) { return !c.sines.empty(); });
    ASSERT_NE(tile, sea->cascades.end());
    Keyframe frame;
    frame.size = 16;
    frame.length_m = 128.0;
    frame.fields = {Field::height, Field::slope_y};
    frame.values.assign(2 * 256, 0.0f);
    add_sines(tile->sines[0], us_from_seconds(7.0), frame);
    const LagrangianPoint p = sum.at(3 * 8.0, 5 * 8.0, us_from_seconds(7.0));
    EXPECT_NEAR(frame.plane(Field::height)[5 * 16 + 3], p.height, 1e-6); // float
    EXPECT_NEAR(frame.plane(Field::slope_y)[5 * 16 + 3], p.slope_y, 1e-6);
}

TEST(Sines, exponential_sine_level_and_variance_are_integrals) {
    for (const double p : {0.1, 1.0, 10.0}) {
        double mean = 0.0, square = 0.0;
        const int n = 4096;
        for (int i = 0; i < n; ++i) {
            const double e = std::exp(p * (std::sin(two_pi * i / n) - 1.0));
            mean += e / n;
            square += e * e / n;
        }
        EXPECT_NEAR(exponential_sine(p).mean, mean, 1e-12);
        EXPECT_NEAR(exponential_sine(p).variance, square - mean * mean, 1e-12);
    }
    EXPECT_NEAR(exponential_sine(1.0).mean, 0.466, 0.001); // the offset that trap T52 names
}

TEST(Presets, P17_sea_state_codes_have_the_published_bounds) {
    const Table table("P17_wmo_sea_state_3700");
    for (std::size_t r = 1; r < table.size(); ++r) {
        const int code = static_cast<int>(table.number(r, "code"));
        const double lo = table.number(r, "Hs_min_m");
        // A height on the boundary belongs to the lower code.
        EXPECT_EQ(wmo_sea_state(lo).code, code - 1);
        EXPECT_EQ(wmo_sea_state(std::nextafter(lo, 1e9)).code, code);
        EXPECT_EQ(wmo_sea_state(lo + 0.01).name, table.text(r, "name"));
        const auto preset = preset_sea("wmo:" + table.text(r, "code"));
        ASSERT_TRUE(preset);
        EXPECT_GE(preset->significant_height_m, lo);
        EXPECT_EQ(wmo_sea_state(preset->significant_height_m).code, code);
        if (!table.text(r, "Hs_max_m").empty()) {
            EXPECT_LE(preset->significant_height_m, table.number(r, "Hs_max_m"));
        }
    }
    EXPECT_EQ(wmo_sea_state(0.0).code, 0);
    EXPECT_EQ(wmo_sea_state(1e30).code, 9);
}

TEST(Presets, P18_beaufort_heights_are_the_probable_ones_and_grow_like_a_developed_sea) {
    const Table table("P18_beaufort");
    for (std::size_t r = 0; r < table.size(); ++r) {
        const auto preset = preset_sea("beaufort:" + table.text(r, "force"));
        ASSERT_TRUE(preset);
        EXPECT_EQ(preset->significant_height_m, table.number(r, "probable_wave_height_m_rounded"));
        const double wind =
            0.514444 * (table.number(r, "wind_min_kn") + table.number(r, "wind_max_kn")) / 2;
        if (r < 4 || r > 8) // below, feet are rounded to nothing; above, seas are never developed
            continue;
        const auto grown = FrequencySpectrum::pierson_moskowitz(wind * wind_19m5_over_10m, 9.81);
        const double hs = 0.20925 * std::pow(0.877163 / grown.peak_omega_radps(), 2) * 9.81;
        EXPECT_NEAR(preset->significant_height_m / hs, 1.0, 0.5); // the header's band
    }
    EXPECT_FALSE(preset_sea("beaufort:13"));
}

TEST(Presets, P16_north_atlantic_rows_are_the_tables) {
    const Table table("P16_bales1983_north_atlantic");
    for (std::size_t r = 0; r < table.size(); ++r) {
        const auto preset = preset_sea("north_atlantic:" + std::to_string(r + 1));
        ASSERT_TRUE(preset);
        EXPECT_EQ(preset->significant_height_m, table.number(r, "Hs_mean_m"));
        if (table.text(r, "Tp_most_probable_s").empty())
            continue;
        EXPECT_EQ(preset->peak_period_s, table.number(r, "Tp_most_probable_s"));
    }
}

TEST(Presets, scenes_take_them_by_name) {
    const Scene whole = scene_of("[sea]\npreset = \"beaufort:7\"\n");
    EXPECT_EQ(std::get<Swell>(whole.sea.systems.at(0)).significant_height_m, 4.0);
    const Scene one = scene_of("[sea]\n[[sea.system]]\npreset = \"hs_tp:3.5,9\"\nfrom_deg = 0\n");
    EXPECT_EQ(std::get<Swell>(one.sea.systems.at(0)).peak_period_s, 9.0);
    for (const char* bad : {"beaufort:-1", "wmo:10", "north_atlantic:0", "hs_tp:3", "hs_tp:nan,9",
                            "storm", "beaufort:7x"})
        EXPECT_THAT(error_of(fmt::format("[sea]\npreset = \"{}\"\n", bad)),
                    HasSubstr("north_atlantic:1 .. 9"));
    EXPECT_NEAR(fully_developed_period_s(4.0), 10.0, 0.02);
}

TEST(Systems, all_kinds_survive_a_round_trip_through_the_effective_scene) {
    const std::string text =
        "[sea]\npreset = \"wmo:5\"\n"
        "[[sea.system]]\ntype=\"measured\"\ndata='''\n# it's '' a note\nf_hz,df_hz,s_m2_hz,a1,b1\n"
        "0.1,0.02,5,0.1,0.2\n'''\n"
        "[[sea.system]]\ntype=\"measured\"\nfrom_deg=33\ndata='''\nf_hz,df_hz,s_m2_hz\n"
        "0.1,0.02,5\n'''\n"
        "[[sea.system]]\ntype=\"measured\"\ncoefficients=\"towards_anticlockwise_east\"\n"
        "data='''\nf_hz,df_hz,s_m2_hz,a1,b1\n0.12,0.02,3,0.3,0.4\n'''\n"
        "[[sea.system]]\ntype=\"modes\"\nlength_m=77\ndata='''\nnx,ny,amplitude_m,phase_rad\n"
        "1,2,0.1,0.7\n'''\n"
        "[[sea.system]]\ntype=\"sines\"\nshape=\"exponential\"\nfrom_deg=12.3\nlength_m=99\n"
        "direction_spread_deg=17.7\n"
        "[[sea.system]]\ntype=\"wind\"\nspectrum=\"phillips\"\nwind_speed_10m_mps=9\nfrom_deg=1\n"
        "significant_height_m=1.2\nphillips_upwind=true\n";
    const Scene scene = scene_of(text);
    const Scene again = scene_of(to_toml(scene));
    EXPECT_EQ(to_toml(again), to_toml(scene));
    const auto a = realize(scene), b = realize(again);
    ASSERT_EQ(a->cascades.size(), b->cascades.size());
    for (std::size_t c = 0; c < a->cascades.size(); ++c)
        EXPECT_EQ(a->cascades[c].h0, b->cascades[c].h0);
}

TEST(Systems, phillips_by_height_has_that_height_one_way_or_both) {
    for (const char* upwind : {"false", "true"}) {
        const Scene scene =
            scene_of(fmt::format("[sea]\n[[sea.system]]\ntype=\"wind\"\nspectrum=\"phillips\"\n"
                                 "wind_speed_10m_mps=8\nfrom_deg=270\nsignificant_height_m=1.5\n"
                                 "phillips_upwind={}\n[[cascade]]\nlength_m=800\nsize=256\n",
                                 upwind));
        const SeaSummary s = summarize(scene.sea, *realize(scene));
        // The quadrature ends at 1000 peaks, where 1/k^3 leaves 1e-12.
        EXPECT_NEAR(s.requested.significant_height_m, 1.5, 1e-5);
        const DirectionalSpectrum spectrum(scene.sea.systems[0], scene.sea);
        EXPECT_EQ(spectrum.density(-0.3, 0.0) > 0.0, upwind == std::string("true"));
        if (upwind == std::string("true")) {
            EXPECT_NEAR(spectrum.density(-0.3, 0.1) / spectrum.density(0.3, -0.1), 1.0, 1e-12);
        }
    }
}

} // namespace
} // namespace seaway::sea
