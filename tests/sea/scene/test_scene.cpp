// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "sea/scene/scene.h"
#include "sea/waves/moments.h"

namespace seaway::sea {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

const std::string wind_system = R"(
[sea]
[[sea.system]]
type = "wind"
wind_speed_10m_mps = 10
from_deg = 225
fetch_m = 100e3
)";

std::string error_of(const std::string& text) {
    const Result<Scene> scene = parse_scene(text, "s.toml", "");
    return scene ? "no error" : scene.error().message;
}

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
    EXPECT_TRUE(scene_warnings(*scene).empty());
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
                AllOf(HasSubstr("s.toml:2"), HasSubstr("sea.deph_m"), HasSubstr("unknown key")));
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

TEST(Scene, warnings_say_what_the_picture_will_not_show) {
    const auto warnings = [](const std::string& text) {
        std::string all;
        for (const std::string& w : scene_warnings(*parse_scene(text, "s", "")))
            all += w + "\n";
        return all;
    };
    const std::string swell = "[[sea.system]]\ntype=\"swell\"\nsignificant_height_m=5\n"
                              "peak_period_s=12\nfrom_deg=0\n";
    EXPECT_THAT(warnings("[sea]\n" + swell), HasSubstr("peak wavelengths"));
    EXPECT_THAT(warnings("[sea]\ndepth_m = 5\n" + swell), HasSubstr("such waves break"));
    EXPECT_THAT(warnings("[sea]\n" + swell + "[[cascade]]\nlength_m=3000\nsize=64\n"),
                HasSubstr("shorter than the finest"));
    std::string text = wind_system;
    text.replace(text.find("100e3"), 5, "100e6");
    EXPECT_THAT(warnings(text), HasSubstr("growth is clamped"));
    const std::string steep_waves =
        "[[sea.system]]\ntype=\"swell\"\nsignificant_height_m=10\npeak_period_s=8\n"
        "from_deg=0\n[[cascade]]\nlength_m=1200\nsize=64\n"
        "[[cascade]]\nlength_m=90\nsize=128\n";
    // s = 2000 is 1.8 degrees wide; 1000 m hold waves of 10 s every 8.9 degrees or so at their
    // peak.
    const std::string beam =
        "[sea]\n[[sea.system]]\ntype=\"swell\"\nsignificant_height_m=1\n"
        "peak_period_s=10\nfrom_deg=0\nspreading=\"cos2s\"\nspreading_exponent=";
    const std::string tile = "\n[[cascade]]\nlength_m=1250\nsize=128\n";
    EXPECT_THAT(warnings(beam + "2000" + tile), HasSubstr("1.8 degrees falls between"));
    EXPECT_THAT(warnings("[sea]\nchoppiness = 3\n" + steep_waves), HasSubstr("fold about"));
    EXPECT_THAT(warnings("[sea]\n" + steep_waves), ::testing::Not(HasSubstr("fold about")));
    EXPECT_THAT(warnings(beam + "100" + tile), ::testing::Not(HasSubstr("falls between")));
    EXPECT_EQ(warnings("[sea]\n"), "");
}

} // namespace
} // namespace seaway::sea
