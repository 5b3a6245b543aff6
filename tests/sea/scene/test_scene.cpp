// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include <fmt/format.h>

#include "sea/scene/scene.h"
#include "sea/scene/scene_names.h"
#include "sea/waves/directional_spectrum.h"
#include "sea/waves/statistics/moments.h"
#include "tests/sea/scene_of.h"
#include "tests/sea/warnings_of.h"

namespace seaway::sea {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using testing::error_of;
using ::testing::HasSubstr;

const std::string wind_system = R"(
[sea]
[[sea.system]]
type = "wind"
wind_speed_10m_mps = 10
from_deg = 225
fetch_m = 100e3
)";

TEST(Scene, the_example_of_the_design_reads_as_it_says) {
    const Result<Scene> scene =
        read_scene(std::string(SEAWAY_SOURCE_DIR) + "/scenes/north_sea_gale.toml");
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(scene->sea.seed, 42u);
    EXPECT_EQ(scene->sea.systems.size(), 2u);
    EXPECT_EQ(scene->cascades.size(), 3u);
    const auto& wind = std::get<WindSea>(scene->sea.systems[0]);
    // From the north-west: towards the south-east, -45 degrees from east.
    EXPECT_NEAR(wind.towards_rad, -pi / 4, 1e-15);
    EXPECT_TRUE(testing::warnings_of(*scene).empty());
}

TEST(Scene, bearings_are_from_and_clockwise_and_become_towards_and_anticlockwise) {
    for (const auto& [from, towards] :
         {std::pair{0.0, -90.0}, {90.0, 180.0}, {180.0, 90.0}, {270.0, 0.0}, {225.0, 45.0}}) {
        std::string text = wind_system;
        text.replace(text.find("225"), 3, std::to_string(from));
        const Result<Scene> scene = parse_scene(text, "s", "");
        ASSERT_TRUE(scene);
        EXPECT_NEAR(std::get<WindSea>(scene->sea.systems[0]).towards_rad, towards * pi / 180,
                    1e-15);
    }
}

TEST(Scene, velocity_cannot_be_switched_off_and_says_why) {
    EXPECT_EQ(error_of(wind_system + "[effects]\nvelocity = true"), "no error");
    EXPECT_THAT(error_of(wind_system + "[effects]\nvelocity = false"),
                AllOf(HasSubstr("effects.velocity: false"), HasSubstr("time rates")));
}

TEST(Scene, errors_name_file_line_key_value_and_range) {
    EXPECT_THAT(error_of("[sea]\ndepth_m = -3"),
                AllOf(HasSubstr("s.toml:2"), HasSubstr("sea.depth_m"), HasSubstr("-3"),
                      HasSubstr("0.01 .. inf")));
    EXPECT_THAT(error_of("[sea]\ndeph_m = 3"),
                AllOf(HasSubstr("s.toml:2"), HasSubstr("sea.deph_m"), HasSubstr("unknown key"),
                      HasSubstr("the nearest is depth_m")));
    EXPECT_THAT(error_of("[sea]\nbanana = 3"), ::testing::EndsWith("sea.banana: unknown key"))
        << "nothing is like it";
    EXPECT_THAT(error_of("[sea]\n\nseed = \"x\""),
                AllOf(HasSubstr("s.toml:3"), HasSubstr("sea.seed"), HasSubstr("whole number")));
    EXPECT_THAT(error_of(wind_system + "spectrum = \"jonswop\""),
                AllOf(HasSubstr("sea.system[1].spectrum"), HasSubstr("jonswop"),
                      HasSubstr("jonswap | tma")));
    EXPECT_THAT(error_of("[sea\n"), HasSubstr("s.toml:1"));
    EXPECT_THAT(error_of("x = 1"), HasSubstr("sea: missing"));
    EXPECT_THAT(error_of("[sea]\n[[sea.system]]\ntype = \"wind\"\nfrom_deg = 1"),
                HasSubstr("wind_speed_10m_mps: missing"));
    EXPECT_THAT(error_of(wind_system + "significant_height_m = 3"), HasSubstr("unknown key"));
    EXPECT_THAT(error_of("[sea]\n[[cascade]]\nlength_m = 100\nsize = 100"),
                HasSubstr("power of two"));
    EXPECT_THAT(error_of("[sea]\n[[cascade]]\nlength_m=10\nsize=64\n[[cascade]]\nlength_m=100\n"
                         "size=64"),
                HasSubstr("longest tile to the shortest"));
    EXPECT_THAT(read_scene("/nowhere/x.toml").error().message, HasSubstr("/nowhere/x.toml"));
}

// T38: a loop of no time has no phase.
TEST(Scene, a_loop_is_none_or_lasts_a_second_at_least) {
    for (const char* period : {"0.5", "0.999999", "1e-300"})
        EXPECT_THAT(error_of(fmt::format("[sea]\nloop_period_s = {}", period)),
                    AllOf(HasSubstr("s.toml:2"), HasSubstr("sea.loop_period_s"), HasSubstr(period),
                          HasSubstr("1 .. 1e6")));
    EXPECT_THAT(error_of("[sea]\nloop_period_s = -1"), HasSubstr("sea.loop_period_s"));
    for (const char* period : {"0", "-0.0", "1", "1e6"})
        EXPECT_EQ(error_of(fmt::format("[sea]\nloop_period_s = {}", period)), "no error");
}

// A21: NaN passes a test written as x < 0.
TEST(Scene, A21_numbers_that_are_none_are_refused_by_name) {
    for (const char* bad : {"nan", "inf", "-inf", "-1", "1e38"}) {
        EXPECT_THAT(error_of(std::string("[sea]\nchoppiness = ") + bad), HasSubstr("choppiness"));
        EXPECT_THAT(error_of(std::string("[sea]\ngravity_mps2 = ") + bad), HasSubstr("gravity"));
        std::string text = wind_system;
        text.replace(text.find("= 10\n"), 4, std::string("= ") + bad);
        EXPECT_THAT(error_of(text), HasSubstr("wind_speed_10m_mps"));
    }
    EXPECT_TRUE(parse_scene("[sea]\nchoppiness = 1e-320", "s", ""));
    EXPECT_TRUE(parse_scene("[sea]\nchoppiness = -0.0", "s", ""));
}

// The TOML library aborts on these unless its assertions are off.
TEST(Scene, malformed_texts_are_errors_not_aborts) {
    for (const char* text : {"[$", "[[$]]", "[sea]\n[[\x01]]", "a.=1", "=", "[sea]\nseed = 0x", "[",
                             "[[", "\"", "\xff\xfe", "[sea]\nx = {", "[sea]\nseed = 1_",
                             "\xEF\xBB\xBE# x", "[sea]\nseed = 1 \xE1\x9A\x81"})
        EXPECT_NE(error_of(text), "no error") << text;
    EXPECT_THAT(error_of("# \xC3\xBC\n[sea]\nx = '\xC3\xBC' \xC3\xBC"),
                AllOf(HasSubstr("s.toml:3"), HasSubstr("0xc3")));
    EXPECT_TRUE(parse_scene("\xEF\xBB\xBF# \xC3\xBC \"\n[sea] # '\nseed = 1", "s", ""));
}

TEST(Scene, choppiness_is_a_number_or_a_pair) {
    EXPECT_EQ(parse_scene("[sea]\nchoppiness = 0.5", "s", "")->sea.choppiness.y, 0.5);
    const auto scene = parse_scene("[sea]\nchoppiness = [0.5, 2]", "s", "");
    EXPECT_EQ(scene->sea.choppiness.x, 0.5);
    EXPECT_EQ(scene->sea.choppiness.y, 2.0);
    EXPECT_THAT(error_of("[sea]\nchoppiness = [0.5, 4]"), HasSubstr("[x, y]"));
    EXPECT_THAT(error_of("[sea]\nchoppiness = [1]"), HasSubstr("[x, y]"));
}

TEST(Scene, effective_scene_reads_back_as_the_same_sea_bit_for_bit) {
    for (int from = 0; from < 360; from += 7) {
        std::string text = wind_system;
        text.replace(text.find("225"), 3, std::to_string(from + 0.1));
        const auto scene = parse_scene(text, "a", "");
        ASSERT_TRUE(scene);
        const std::string effective = to_toml(*scene);
        const auto again = parse_scene(effective, "b", "");
        ASSERT_TRUE(again) << again.error().message << "\n" << effective;
        EXPECT_EQ(std::get<WindSea>(scene->sea.systems[0]).towards_rad,
                  std::get<WindSea>(again->sea.systems[0]).towards_rad);
        EXPECT_EQ(to_toml(*again), effective);
    }
}

// Whoever warns has the sea, its summary and its budget already: they are not made once more. Naive: each
// start computes the sea twice.
TEST(Scene, warnings_speak_of_the_sea_the_summary_and_the_budget_that_are_given) {
    const auto scene = parse_scene(wind_system, "s", "");
    ASSERT_TRUE(scene);
    Realization sea = *realize(*scene);
    SeaSummary summary = summarize(scene->sea, sea);
    ErrorBudget budget = plan_budget(sea, scene->accuracy.height_error_m);
    sea.cascades[0].carries_spectra = false;
    sea.cascades[0].spec.length_m = 1234.0;
    summary.lost_above_m2 = summary.requested.significant_height_m; // more than there is
    budget.interpolation_m = budget.codec_error_m = 77.0;
    const auto warnings = scene_warnings(*scene, sea, summary, budget);
    EXPECT_THAT(warnings, Contains(HasSubstr("explicit waves, 1234 m")));
    EXPECT_THAT(warnings, Contains(HasSubstr("shorter than the finest cascade")));
    EXPECT_THAT(warnings, Contains(HasSubstr("interpolation alone costs 77 m")));
}

TEST(Scene, no_cascade_at_all_is_an_error_by_name) {
    EXPECT_THAT(error_of("cascade = []\n[sea]\npreset = \"beaufort:3\""),
                AllOf(HasSubstr("cascade: an empty array is not allowed"), HasSubstr("1 .. 8")));
    // A sea made by a program, without the reader.
    EXPECT_THAT(realize(SeaState{}, {}).error().message, HasSubstr("no cascade"));
}

TEST(Scene, a_rectangular_tile_is_refused_with_the_reason) {
    EXPECT_THAT(error_of("[sea]\n[[cascade]]\nlength_m = [100, 50]\nsize = 64"),
                AllOf(HasSubstr("s.toml:3"), HasSubstr("cascade[1].length_m"),
                      HasSubstr("tiles are square")));
}

// Nine lengths of explicit waves beside the three default tiles would be twelve.
TEST(Scene, tiles_of_explicit_waves_count_towards_the_limit) {
    const auto scene_with = [](int lengths, const std::string& cascades) {
        std::string text = "[sea]\n";
        for (int i = 0; i < lengths; ++i)
            text += fmt::format("[[sea.system]]\ntype=\"modes\"\nlength_m={}\ndata='''\n"
                                "nx,ny,amplitude_m,phase_rad\n1,0,0.1,0\n'''\n",
                                100 + 10 * i);
        return text + cascades;
    };
    EXPECT_THAT(error_of(scene_with(9, "")), AllOf(HasSubstr("12 tiles"), HasSubstr("at most 8")));
    EXPECT_EQ(error_of(scene_with(5, "")), "no error");
    EXPECT_THAT(error_of(scene_with(6, "")), HasSubstr("9 tiles"));
    // On a cascade of their own length they add none.
    EXPECT_EQ(error_of(scene_with(8, "[[cascade]]\nlength_m=110\nsize=64\n")), "no error");
}

TEST(Scene, a_key_of_another_kind_says_whose_it_is) {
    const std::string pm = "[sea]\n[[sea.system]]\ntype=\"wind\"\nspectrum=\"pierson_moskowitz\"\n"
                           "from_deg=0\nwind_speed_19m5_mps=10\n";
    EXPECT_EQ(error_of(pm), "no error");
    EXPECT_THAT(error_of(pm + "wind_speed_10m_mps=9\n"),
                HasSubstr("wind_speed_19m5_mps: excludes wind_speed_10m_mps"));
    EXPECT_THAT(error_of(wind_system + "wind_speed_19m5_mps = 3"),
                HasSubstr("only for spectrum = \"pierson_moskowitz\""));
    EXPECT_THAT(error_of(pm + "gamma = 2\n"), HasSubstr("gamma: only for spectrum = \"jonswap\""));
    EXPECT_THAT(error_of(wind_system + "narrow_share = 0.5"), HasSubstr("only for the blends"));
    EXPECT_THAT(error_of(wind_system + "spreading = \"cos2\"\nspreading_exponent = 3"),
                HasSubstr("only for spreading = \"cos2s\""));
}

// Divided by 1.06019733 and multiplied back, these speeds lose their last bit.
TEST(Scene, a_wind_at_19m5_reaches_its_spectrum_and_its_text_to_the_bit) {
    for (const double speed : {1.0, 1.7, 2.0, 3.4, 4.0}) {
        const auto scene = parse_scene(
            fmt::format("[sea]\n[[sea.system]]\ntype=\"wind\"\nspectrum=\"pierson_moskowitz\"\n"
                        "from_deg=0\nwind_speed_19m5_mps={}\n",
                        speed),
            "s", "");
        ASSERT_TRUE(scene);
        EXPECT_EQ(DirectionalSpectrum(scene->sea.systems[0], scene->sea).frequency_density(0.7),
                  FrequencySpectrum::pierson_moskowitz(speed, 9.81).density(0.7));
        EXPECT_THAT(to_toml(*scene), HasSubstr(fmt::format("wind_speed_19m5_mps = {}\n", speed)));
        EXPECT_EQ(to_toml(*parse_scene(to_toml(*scene), "again", "")), to_toml(*scene));
        EXPECT_NEAR(std::get<WindSea>(scene->sea.systems[0]).wind_speed_10m_mps, speed / 1.0602,
                    1e-4 * speed);
    }
}

// What is not written would be read back as its default.
TEST(Scene, every_value_that_is_given_stands_in_the_effective_scene) {
    const std::string shape = "from_deg = 33.5\nswell = 0.25\nisotropic = 0.125\n";
    const std::string wind = "type = \"wind\"\nwind_speed_10m_mps = 7.5\n" + shape;
    const std::string swell =
        "type = \"swell\"\nsignificant_height_m = 1.25\npeak_period_s = 7.5\n" + shape;
    const std::string ramps =
        "type = \"sines\"\nlength_m = 77.5\ncount = 7\namplitude_m = 0.375\nwavelength_m = 33.5\n"
        "amplitude_ratio = 0.75\nwavenumber_ratio = 1.125\nfrom_deg = 33.5\n"
        "direction_step_deg = 11.5\ndirection_spread_deg = 22.5\nnormalise = false\n";
    for (const std::string& system :
         {wind + "spectrum = \"jonswap\"\nfetch_m = 12345\ngamma = 2.5\n",
          wind + "spectrum = \"tma\"\nfetch_m = 12345\ngamma = 2.5\n",
          wind + "spectrum = \"phillips\"\nphillips_constant = 0.0125\nphillips_upwind = true\n",
          swell + "spectrum = \"jonswap\"\ngamma = 2.5\nspreading = \"cos2s\"\n"
                  "spreading_exponent = 7.5\n",
          swell + "spectrum = \"tma\"\ngamma = 2.5\nspreading = \"cos2_cos2s\"\n"
                  "spreading_exponent = 7.5\nnarrow_share = 0.375\n",
          swell + "spectrum = \"bretschneider\"\nspreading = \"cos2_hasselmann\"\n"
                  "narrow_share = 0.375\n",
          ramps + "shape = \"gerstner\"\n", ramps + "shape = \"sine\"\nspeed_ratio = 1.5\n",
          ramps + "shape = \"exponential\"\nspeed_ratio = 1.5\nsharpness = 1.75\ndrag = 0.5\n",
          ramps + "shape = \"noise\"\nspeed_ratio = 1.5\n"}) {
        const std::string text =
            "[sea]\nseed = 11\ndepth_m = 35.5\nchoppiness = [0.5, 0.25]\ngravity_mps2 = 9.5\n"
            "surface_tension = false\nloop_period_s = 64.5\nheight_scale = 1.5\n"
            "short_wave_fade_m = 0.25\nwavenumber_min_radpm = 0.0125\n"
            "wavenumber_max_radpm = 12.5\n[[sea.system]]\n" +
            system +
            "[[cascade]]\nlength_m = 123.5\nsize = 32\n[effects]\ndisplacement = \"height\"\n"
            "slopes = false\nfoam = false\n[foam]\nthreshold = 0.125\ndecay_s = 3.5\n"
            "gain_per_s = 0.75\nbias = 0.0625\n[accuracy]\nheight_error_m = 0.0125\n";
        const auto scene = parse_scene(text, "s", "");
        ASSERT_TRUE(scene) << scene.error().message << "\n" << text;
        const std::string effective = "\n" + to_toml(*scene);
        std::istringstream lines(text);
        for (std::string line; std::getline(lines, line);)
            EXPECT_THAT(effective, HasSubstr("\n" + line + "\n"));
    }
}

// Notes may hold anything, also what would end the table in the text that is written.
TEST(Scene, notes_in_a_table_wherever_they_begin_are_not_in_the_effective_scene) {
    const std::string rows = "f_hz,df_hz,s_m2_hz\n0.1,0.01,3\n0.11,0.01,4\n";
    for (const char* note : {"# ours: '''\n", "   # ours: '''\n", "\t# ours\r\n", " \t \n"}) {
        const auto scene = parse_scene(
            fmt::format("[sea]\n[[sea.system]]\ntype = \"measured\"\nfrom_deg = 10\ndata = "
                        "\"\"\"\n{0}{1}{0}\"\"\"\n",
                        note, rows),
            "s", "");
        ASSERT_TRUE(scene) << scene.error().message;
        const std::string effective = to_toml(*scene);
        EXPECT_THAT(effective, ::testing::Not(HasSubstr("ours")));
        const auto again = parse_scene(effective, "again", "");
        ASSERT_TRUE(again) << again.error().message << "\n" << effective;
        EXPECT_EQ(to_toml(*again), effective);
    }
}

// Both ways from one table: what a preset stands for, what the reader makes of it, what is written.
TEST(Scene, an_accuracy_preset_stands_for_its_tiles_its_budget_and_its_streams) {
    for (const AccuracyPreset preset : accuracy_presets()) {
        const std::string line = fmt::format("preset = \"{}\"\n", name_of(preset));
        const auto scene = parse_scene(wind_system + "[accuracy]\n" + line, "s", "");
        ASSERT_TRUE(scene) << scene.error().message;
        const PresetAccuracy meant = accuracy_of(preset);
        EXPECT_EQ(scene->accuracy.height_error_m, meant.height_error_m);
        EXPECT_EQ(scene->accuracy.streams(), meant.streams);
        ASSERT_EQ(scene->cascades.size(), meant.cascades.size());
        for (std::size_t c = 0; c < meant.cascades.size(); ++c) {
            EXPECT_EQ(scene->cascades[c].length_m, meant.cascades[c].length_m);
            EXPECT_EQ(scene->cascades[c].size, meant.cascades[c].size);
        }
        EXPECT_THAT(to_toml(*scene), HasSubstr("\n" + line));
        EXPECT_EQ(to_toml(*parse_scene(to_toml(*scene), "again", "")), to_toml(*scene));
    }
    EXPECT_FALSE(accuracy_of(AccuracyPreset::query_only).streams);
    EXPECT_EQ(accuracy_preset_names.size(), accuracy_presets().size());
}

TEST(Scene, what_a_scene_says_itself_wins_over_its_preset) {
    const auto scene = parse_scene(wind_system + "[[cascade]]\nlength_m = 500\nsize = 64\n"
                                                 "[accuracy]\nheight_error_m = 0.25\n"
                                                 "preset = \"query_only\"\n",
                                   "s", "");
    ASSERT_TRUE(scene) << scene.error().message;
    ASSERT_EQ(scene->cascades.size(), 1u);
    EXPECT_EQ(scene->cascades[0].length_m, 500.0);
    EXPECT_EQ(scene->accuracy.height_error_m, 0.25);
    EXPECT_FALSE(scene->accuracy.streams());
    // Without a preset all is as it was before there were any.
    const auto plain = parse_scene(wind_system, "s", "");
    EXPECT_EQ(plain->cascades.size(), 3u);
    EXPECT_EQ(plain->cascades[0].length_m, 1021.0);
    EXPECT_EQ(plain->accuracy.height_error_m, 0.01);
    EXPECT_TRUE(plain->accuracy.streams());
}

TEST(Scene, unknown_presets_and_unfit_names_of_certificates_are_refused) {
    EXPECT_THAT(
        error_of(wind_system + "[accuracy]\npreset = \"exact\"\n"),
        HasSubstr("accuracy.preset: \"exact\" is not allowed; allowed: precise | balanced | "
                  "fast | query_only"));
    for (const char* name : {"\"\"", "'a\"b'", "'a\\b'", "\"a\\nb\""})
        EXPECT_THAT(error_of(wind_system + "[accuracy]\ncertificate = " + name + "\n"),
                    HasSubstr("accuracy.certificate: "))
            << name;
}

TEST(Scene, a_certificate_lies_beside_its_scene_and_its_name_is_written_back) {
    const auto scene = parse_scene(wind_system + "[accuracy]\ncertificate = \"gale.json\"\n", "s",
                                   "/somewhere/else");
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(scene->accuracy.certificate.path, "/somewhere/else/gale.json");
    EXPECT_THAT(to_toml(*scene), HasSubstr("\ncertificate = \"gale.json\"\n"));
    const auto both = parse_scene(
        wind_system + "[accuracy]\npreset = \"fast\"\ncertificate = \"fast.json\"\n", "s", ".");
    ASSERT_TRUE(both) << both.error().message;
    const auto again = parse_scene(to_toml(*both), "written", ".");
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(again->accuracy.preset, AccuracyPreset::fast);
    EXPECT_EQ(again->accuracy.certificate.name, "fast.json") << "beside the preset";
}

// One table: what the reader takes, the writer writes.
TEST(Scene, every_spectrum_and_spreading_reads_back_under_its_name) {
    for (const auto& [spectrum, kind] : spectrum_names)
        for (const auto& [spreading, model] : spreading_names) {
            const bool wind = spectrum_name(kind).of_wind;
            const std::string text = fmt::format(
                "[sea]\n[[sea.system]]\ntype = \"{}\"\nspectrum = \"{}\"\nspreading = \"{}\"\n"
                "from_deg = 10\n{}",
                wind ? "wind" : "swell", spectrum, spreading,
                wind ? "wind_speed_10m_mps = 9\n"
                     : "significant_height_m = 1\npeak_period_s = 8\n");
            const auto scene = parse_scene(text, "s", "");
            ASSERT_TRUE(scene) << scene.error().message;
            EXPECT_THAT(to_toml(*scene), HasSubstr(fmt::format("spectrum = \"{}\"\n", spectrum)));
            EXPECT_THAT(to_toml(*scene), HasSubstr(fmt::format("spreading = \"{}\"\n", spreading)));
            EXPECT_EQ(to_toml(*parse_scene(to_toml(*scene), "again", "")), to_toml(*scene));
        }
    EXPECT_EQ(spectrum_names.size(), 5u);
    EXPECT_EQ(spreading_names.size(), 7u);
}

// A turn to a larger angle in our frame is anticlockwise, towards a smaller bearing.
TEST(Scene, a_beam_that_the_lattice_turns_is_told_of_in_degrees_clockwise) {
    for (const int from_deg : {20, 340}) {
        const Result<Scene> scene = parse_scene(
            fmt::format("[sea]\n[[sea.system]]\ntype=\"swell\"\nsignificant_height_m=1\n"
                        "peak_period_s=10\nfrom_deg={}\nspreading=\"cos2s\"\n"
                        "spreading_exponent=400\n[[cascade]]\nlength_m=300\nsize=128\n",
                        from_deg),
            "s", "");
        ASSERT_TRUE(scene);
        const LatticeBias bias = summarize(scene->sea, *realize(*scene)).lattice.at(0);
        ASSERT_GT(std::abs(bias.turned_rad), 0.01);
        EXPECT_THAT(testing::warnings_of(*scene),
                    Contains(HasSubstr(fmt::format("its direction by {:+.1f} degrees clockwise",
                                                   -bias.turned_rad * 180.0 / pi))));
    }
}

// Strains are nearly normal: the surface folds where choppiness times their rms, by the normal
// distribution, is beyond one.
TEST(Scene, a_sea_that_folds_is_told_by_how_much_of_it_does) {
    const Result<Scene> scene =
        parse_scene("[sea]\nchoppiness = [0.2, 3]\n[[sea.system]]\ntype = \"swell\"\n"
                    "significant_height_m = 10\npeak_period_s = 8\nfrom_deg = "
                    "5\n[[cascade]]\nlength_m = 200\nsize = 256\n"
                    "[[cascade]]\nlength_m = 11\nsize = 128\n",
                    "folds", "");
    ASSERT_TRUE(scene) << scene.error().message;
    const Result<Realization> sea = realize(*scene);
    const SeaSummary summary = summarize(scene->sea, *sea);
    // Of 1 + 0.2 dDx/dx + 3 dDy/dy, mode by mode; deep water moves by as much as it rises.
    double squeeze2 = 0;
    for (const CascadeModes& modes : sea->cascades)
        for (int iy = 0; iy < modes.spec.size; ++iy)
            for (int ix = 0; ix < modes.spec.size; ++ix) {
                const int half = modes.spec.size / 2;
                const double nx = ix < half ? ix : ix - modes.spec.size;
                const double ny = iy < half ? iy : iy - modes.spec.size;
                if (nx == 0 && ny == 0)
                    continue;
                const double k = 2 * pi / modes.spec.length_m * std::hypot(nx, ny);
                const double share = (0.2 * nx * nx + 3 * ny * ny) / (nx * nx + ny * ny);
                const auto i = static_cast<std::size_t>(iy * modes.spec.size + ix);
                squeeze2 += 2 * std::norm(modes.h0[i]) * k * k * share * share;
            }
    const double z = 1 / std::sqrt(squeeze2);
    const double percent = 100 * (0.5 - 0.5 * std::erf(z / std::sqrt(2.0)));
    ASSERT_GT(percent, 0.01);
    EXPECT_THAT(
        testing::warnings_of(*scene),
        ::testing::Contains(::testing::HasSubstr(fmt::format(
            "choppiness [0.2, 3] and an rms strain of {:.2g} fold about {:.2g} % of the surface",
            std::sqrt(summary.realised.mean_square_strain), percent))));
}

} // namespace
} // namespace seaway::sea
