// SPDX-License-Identifier: Apache-2.0
// Scenes that are refused for how they are written, and by which key.
#include <cmath>
#include <string>
#include <utility>
#include <variant>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "sea/scene/scene.h"
#include "tests/sea/scene_of.h"

namespace seaway::sea {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;

// Strings of three quotes may end with one or two more that belong to them.
TEST(Scene, bytes_beyond_ascii_are_allowed_in_strings_however_these_end) {
    const std::string note = "caf\xC3\xA9";
    for (const std::string quote : {"\"", "'"})
        for (int more = 0; more <= 2; ++more) {
            std::string text = "[sea]\na = " + quote + quote + quote + "x" + quote + quote + quote;
            for (int i = 0; i < more; ++i)
                text += quote;
            // Unknown keys, which is what is wrong with it.
            EXPECT_THAT(error_of(text + "\nb = " + quote + note + quote + "\n"),
                        HasSubstr("unknown key"))
                << text;
            EXPECT_THAT(error_of(text + "\nb = 1 " + note + "\n"),
                        HasSubstr("s.toml:3: byte 0xc3 is not allowed here"))
                << text;
        }
}

// Refused for what several keys say together: of a list, the key that holds it.
TEST(Scene, stylised_waves_that_are_too_short_or_too_fast_are_blamed_on_where_they_stand) {
    const std::string sines = "[sea]\n[[sea.system]]\ntype = \"sines\"\nshape = \"sine\"\n";
    const std::string list = "wavelength_m,amplitude_m,from_deg,phase_rad\n";
    const std::string data = "data = \"\"\"\n";
    EXPECT_THAT(error_of(sines + "length_m = 1e5\n" + data + list + "0.02,0.1,0,0\n\"\"\"\n"),
                HasSubstr("sea.system[1].data: a list is not allowed"));
    EXPECT_THAT(error_of(sines + "length_m = 1e5\nwavelength_m = 0.02\nfrom_deg = 0\n"),
                HasSubstr("sea.system[1].wavenumber_ratio: "));
    // Told in wavelengths a tile; noise, whose cells are finer than its waves, holds a quarter as many.
    const std::string ramps = "[sea]\n[[sea.system]]\ntype = \"sines\"\nlength_m = 3000\n"
                              "from_deg = 0\n"
                              "wavelength_m = 2\ncount = 2\nwavenumber_ratio = 1.5\nshape = ";
    EXPECT_THAT(error_of(ramps + "\"sine\"\n"),
                HasSubstr(fmt::format("fits the tile at most {} times; this one 2.25e+03 times",
                                      sine_steps_max)));
    EXPECT_THAT(
        error_of(ramps + "\"noise\"\n"),
        HasSubstr(fmt::format("fits the tile at most {} times (noise); this one 2.25e+03 times",
                              sine_steps_max / 4)));
}

// Waves of several systems that have one length stand on one tile.
TEST(Scene, tiles_of_systems_of_one_length_are_counted_once) {
    std::string text = "[sea]\n";
    for (int i = 0; i < 12; ++i)
        text += "[[sea.system]]\ntype = \"modes\"\nlength_m = " + std::to_string(100 + i % 5) +
                "\ndata = \"\"\"\nnx,ny,amplitude_m,phase_rad\n1,0,0.1,0\n\"\"\"\n";
    EXPECT_EQ(error_of(text), "no error") << "three default tiles and five";
}

// docs/scenes.md: what is not said.
TEST(Scene, phillips_spreads_as_cos2_and_the_others_as_hasselmann_if_nothing_is_said) {
    for (const auto& [spectrum, kind] : {std::pair("phillips", SpreadingKind::cos2),
                                         {"jonswap", SpreadingKind::hasselmann},
                                         {"pierson_moskowitz", SpreadingKind::hasselmann}}) {
        const auto scene =
            parse_scene("[sea]\n[[sea.system]]\ntype = \"wind\"\nwind_speed_10m_mps = 9\n"
                        "from_deg = 0\nspectrum = \"" +
                            std::string(spectrum) + "\"\n",
                        "s", "");
        ASSERT_TRUE(scene) << scene.error().message;
        EXPECT_EQ(std::get<WindSea>(scene->sea.systems[0]).spreading.kind, kind) << spectrum;
    }
}

TEST(Scene, phillips_takes_a_constant_or_a_height_and_says_so) {
    const std::string phillips = "[sea]\n[[sea.system]]\ntype = \"wind\"\n"
                                 "wind_speed_10m_mps = 9\nfrom_deg = 0\nspectrum = \"phillips\"\n";
    EXPECT_THAT(error_of(phillips + "phillips_constant = 0.008\nsignificant_height_m = 1\n"),
                HasSubstr("s.toml:7: sea.system[1].phillips_constant: excludes "
                          "significant_height_m: give one of the two"));
}

// Naive: lines of the table that is left without its notes.
TEST(Scene, an_error_in_a_measured_table_names_the_line_that_was_written) {
    EXPECT_THAT(error_of("[sea]\n[[sea.system]]\ntype = \"measured\"\nfrom_deg = 0\ndata = "
                         "\"\"\"\n# a note\n# another\nf_hz,df_hz,s_m2_hz\n0.1,0.02,-1\n\"\"\"\n"),
                HasSubstr("data:4: s_m2_hz = -1"));
}

// Naive: one row that a spectrum cannot be divided by.
TEST(Scene, A21_numbers_below_the_smallest_normal_are_zero_in_lists_and_tables_too) {
    const Scene scene = testing::scene_of(
        "[sea]\nchoppiness = [1e-310, -0.0]\n[water]\nbottom_albedo = [1e-310, 0.5, 1]\n"
        "[[sea.system]]\ntype = \"modes\"\nlength_m = 100\ndata = "
        "\"nx,ny,amplitude_m,phase_rad\\n1,0,1e-310,0\\n\"\n");
    EXPECT_EQ(scene.sea.choppiness.x, 0);
    EXPECT_FALSE(std::signbit(scene.sea.choppiness.y));
    EXPECT_EQ(scene.water.bottom_albedo[0], 0);
    EXPECT_EQ(std::get<ExplicitModes>(scene.sea.systems[0]).modes[0].amplitude_m, 0);
}

TEST(Scene, water_has_an_optical_type_and_a_sea_floor) {
    EXPECT_EQ(testing::scene_of("[sea]").water, Water{});
    for (const auto& [name, type] : water_types) {
        const Scene scene = testing::scene_of(
            fmt::format("[sea]\n[water]\ntype = \"{}\"\nbottom_albedo = [0, 0.5, 1]", name));
        EXPECT_EQ(scene.water, (Water{type, {0, 0.5, 1}})) << name;
        EXPECT_EQ(testing::scene_of(to_toml(scene)).water, scene.water) << to_toml(scene);
        EXPECT_EQ(name_of(type), name);
    }
    EXPECT_THAT(to_toml(testing::scene_of("[sea]")), ::testing::Not(HasSubstr("water")))
        << "clients that know no water read the scene of one that names none";
    EXPECT_THAT(error_of("[sea]\n[water]\ntype = \"2C\""),
                AllOf(HasSubstr("s.toml:3"), HasSubstr("water.type"), HasSubstr("\"2C\""),
                      HasSubstr("IB | II | III | 1C")));
    for (const char* bad : {"0.5", "[0.1, 0.2]", "[0.1, 0.2, 1.01]", "[0.1, nan, 0.3]",
                            "[0.1, \"a\", 0.3]", "[0.1, 0.2, 0.3, 0.4]"})
        EXPECT_THAT(error_of(fmt::format("[sea]\n[water]\nbottom_albedo = {}", bad)),
                    AllOf(HasSubstr("water.bottom_albedo"), HasSubstr("three numbers 0 .. 1")));
    EXPECT_THAT(error_of("[sea]\n[water]\ntyp = \"I\""),
                HasSubstr("water.typ: unknown key; the nearest is type"));
}

} // namespace
} // namespace seaway::sea
