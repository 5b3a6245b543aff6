// SPDX-License-Identifier: Apache-2.0
// What whoever runs a scene is told of it beforehand.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/sea/warnings_of.h"

namespace seaway::sea {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

const std::string swell = "[[sea.system]]\ntype=\"swell\"\nsignificant_height_m=5\n"
                          "peak_period_s=12\nfrom_deg=0\n";

std::string warnings(const std::string& text) {
    std::string all;
    for (const std::string& w : testing::warnings_of(*parse_scene(text, "s", "")))
        all += w + "\n";
    return all;
}

TEST(Scene, warnings_say_what_the_picture_will_not_show) {
    EXPECT_THAT(warnings("[sea]\n" + swell), HasSubstr("peak wavelengths"));
    EXPECT_THAT(warnings("[sea]\ndepth_m = 5\n" + swell), HasSubstr("such waves break"));
    EXPECT_THAT(warnings("[sea]\n" + swell + "[[cascade]]\nlength_m=3000\nsize=64\n"),
                HasSubstr("shorter than the finest"));
    EXPECT_THAT(warnings("[sea]\n[[sea.system]]\ntype = \"wind\"\nwind_speed_10m_mps = 10\n"
                         "from_deg = 225\nfetch_m = 100e6\n"),
                HasSubstr("growth is clamped"));
    const std::string steep_waves =
        "[[sea.system]]\ntype=\"swell\"\nsignificant_height_m=10\npeak_period_s=8\n"
        "from_deg=0\n[[cascade]]\nlength_m=1200\nsize=64\n"
        "[[cascade]]\nlength_m=90\nsize=128\n";
    // s = 2000 is 1.8 degrees wide; 1250 m hold waves of 10 s every 7 degrees or so at their peak.
    const std::string beam =
        "[sea]\n[[sea.system]]\ntype=\"swell\"\nsignificant_height_m=1\n"
        "peak_period_s=10\nfrom_deg=0\nspreading=\"cos2s\"\nspreading_exponent=";
    const std::string tile = "\n[[cascade]]\nlength_m=1250\nsize=128\n";
    EXPECT_THAT(warnings(beam + "2000" + tile), HasSubstr("its waves are few on these tiles"));
    EXPECT_THAT(warnings("[sea]\nchoppiness = 3\n" + steep_waves), HasSubstr("fold about"));
    // They run south: it is choppiness.y that moves their water.
    EXPECT_THAT(warnings("[sea]\nchoppiness = [0.1, 3]\n" + steep_waves),
                HasSubstr("choppiness [0.1, 3] and"));
    EXPECT_THAT(warnings("[sea]\nchoppiness = [3, 0.1]\n" + steep_waves),
                Not(HasSubstr("fold about")));
    EXPECT_THAT(warnings("[sea]\n" + steep_waves), Not(HasSubstr("fold about")));
    EXPECT_THAT(warnings(beam + "10" + tile), Not(HasSubstr("few on these tiles")));
    EXPECT_EQ(warnings("[sea]\n"), "");
}

TEST(Scene, a_narrow_swell_on_a_long_tile_is_warned_of_by_how_much_its_height_depends_on_the_seed) {
    // Its waves are 218 m long: eight on the tile. Twelve seeds had 1.49 to 2.42 m.
    const std::string narrow = "[sea]\ndepth_m = 20\n[[sea.system]]\ntype=\"swell\"\n"
                               "significant_height_m=2\npeak_period_s=16\nfrom_deg=10\ngamma=7\n"
                               "spreading=\"cos2s\"\nspreading_exponent=800\n";
    EXPECT_THAT(warnings(narrow + "[[cascade]]\nlength_m=1750\nsize=512\n"),
                HasSubstr("Hs of one seed scatters by 17 %"));
    const std::string wide = "[sea]\n[[sea.system]]\ntype=\"wind\"\nwind_speed_10m_mps=12\n"
                             "from_deg=225\nfetch_m=300e3\n[[cascade]]\nlength_m=1200\nsize=256\n"
                             "[[cascade]]\nlength_m=53\nsize=256\n";
    EXPECT_THAT(warnings(wide), Not(HasSubstr("scatters by")));
    // Waves of 7.5 m, all of which are on the second tile.
    const std::string ripples = "[sea]\n[[sea.system]]\ntype=\"swell\"\nsignificant_height_m=0.3\n"
                                "peak_period_s=2.2\nfrom_deg=270\nspreading=\"cos2s\"\n"
                                "spreading_exponent=75\n[[cascade]]\nlength_m=2111\nsize=256\n"
                                "[[cascade]]\nlength_m=53\nsize=256\n";
    EXPECT_THAT(warnings(ripples), HasSubstr("few waves on the cascade of 53 m"));
}

// Naive: a ramp is a look, whatever becomes of it.
TEST(Scene, stylised_waves_that_are_longer_than_what_they_repeat_on_are_warned_of) {
    for (const char* shape : {"sine", "gerstner", "exponential", "noise"}) {
        const auto of_length = [&](double wavelength_m) {
            return warnings(fmt::format("[sea]\n[[sea.system]]\ntype=\"sines\"\nshape=\"{}\"\n"
                                        "from_deg=0\nlength_m=256\nwavelength_m={}\n",
                                        shape, wavelength_m));
        };
        EXPECT_THAT(of_length(600), HasSubstr("waves of 600 m do not fit on 256 m")) << shape;
        EXPECT_THAT(of_length(256), Not(HasSubstr("do not fit"))) << shape;
    }
}

TEST(Scene, loops_and_depths_that_change_how_water_moves_are_warned_of) {
    EXPECT_THAT(warnings("[sea]\nloop_period_s = 1\n" + swell), HasSubstr("faster or slower than"));
    EXPECT_THAT(warnings("[sea]\nloop_period_s = 600\n" + swell),
                Not(HasSubstr("faster or slower")));
    const std::string tide = "[[sea.system]]\ntype=\"swell\"\nsignificant_height_m=0.02\n"
                             "peak_period_s=100\nfrom_deg=0\n";
    EXPECT_THAT(warnings("[sea]\ndepth_m = 1\n" + tide), HasSubstr("of what it should be"));
    EXPECT_THAT(warnings("[sea]\ndepth_m = 70\n" + tide), Not(HasSubstr("sideways motion")));
}

} // namespace
} // namespace seaway::sea
