// SPDX-License-Identifier: Apache-2.0
// Scenes that follow from scenes: what a change may say, and what of the rest stays.
#include <algorithm>
#include <string>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "sea/scene/weather.h"
#include "sea/waves/realize.h"
#include "sea/waves/statistics/moments.h"
#include "tests/sea/scene_of.h"

namespace seaway::sea {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::scene_of;
using ::testing::StartsWith;

std::string system_of(const std::string& spectrum, const std::string& more) {
    return "[sea]\n[[sea.system]]\ntype = \"wind\"\nfrom_deg = 270\nspectrum = \"" + spectrum +
           "\"\n" + more;
}

std::string row(const std::string& set) {
    return "[[weather]]\nat_s = 100\nset = { " + set + " }\n";
}

Result<Scene> with(const Scene& scene, const std::string& path, const std::string& value) {
    const TomlAssignment one{path, value};
    return changed(scene, {&one, 1});
}

double height_of(const Scene& scene) {
    return summarize(scene.sea, *realize(scene)).requested.significant_height_m;
}

// Naive: rows that are read and never run.
TEST(Weather, a_change_sets_no_timetable) {
    const std::string calm = system_of("jonswap", "wind_speed_10m_mps = 5\n");
    EXPECT_THAT(error_of(calm + row("weather = [ { at_s = 1, set = { sea.depth_m = 9 } } ]")),
                AllOf(HasSubstr("weather[1]"), HasSubstr("not of its timetable")));
    for (const auto& [path, value] :
         {std::pair("weather", "[ { at_s = 1, set = { sea.depth_m = 9 } } ]"),
          std::pair("weather.0.at_s", "7"), std::pair("weather.at_s", "7")}) {
        const Result<Scene> next = with(scene_of(calm), path, value);
        ASSERT_FALSE(next) << path;
        EXPECT_THAT(next.error().message, HasSubstr("not of its timetable"));
    }
}

// Naive: 2.3 + 11.3 is more than 13.6 in doubles, and a row that begins where the one before ends is refused, now and then.
TEST(Weather, a_row_may_begin_where_the_one_before_ends) {
    const std::string calm = system_of("jonswap", "wind_speed_10m_mps = 5\n");
    const auto rows = [](double at_s, double over_s, double next_s) {
        return fmt::format("[[weather]]\nat_s = {}\nover_s = {}\nset.sea.seed = 2\n"
                           "[[weather]]\nat_s = {}\nset.sea.seed = 3\n",
                           at_s, over_s, next_s);
    };
    EXPECT_EQ(error_of(calm + rows(2.3, 11.3, 13.6)), "no error");
    EXPECT_EQ(error_of(calm + rows(-14.499996, 10, -4.499996)), "no error");
    for (int i = 0; i < 300; ++i) {
        const int at_ms = 7919 * i, over_ms = 10'000 + 104'729 * i;
        EXPECT_EQ(error_of(calm + rows(1e-3 * at_ms, 1e-3 * over_ms, 1e-3 * (at_ms + over_ms))),
                  "no error")
            << i;
    }
    EXPECT_THAT(error_of(calm + rows(2.3, 11.3, 13.599)), HasSubstr("weather[2].at_s: 13.599"));
}

// Naive: the whole scene names the one that was given, and a change may not name the other.
TEST(Weather, of_two_keys_that_exclude_each_other_the_one_that_is_set_stands) {
    const std::string phillips = system_of("phillips", "wind_speed_10m_mps = 15\n");
    const Scene by_height = scene_of(phillips + "significant_height_m = 3\n");
    const Result<Scene> higher = with(scene_of(phillips), "systems.0.significant_height_m", "3.0");
    ASSERT_TRUE(higher) << higher.error().message;
    EXPECT_EQ(to_toml(*higher), to_toml(by_height));
    const Result<Scene> by_constant = with(by_height, "sea.system.0.phillips_constant", "0.001");
    ASSERT_TRUE(by_constant) << by_constant.error().message;
    EXPECT_EQ(std::get<WindSea>(by_constant->sea.systems[0]).phillips_constant, 0.001);
    EXPECT_EQ(error_of(phillips + row("sea.system.0.significant_height_m = 2.0")), "no error");
    const Scene measured = scene_of(system_of("pierson_moskowitz", "wind_speed_19m5_mps = 11\n"));
    const Result<Scene> at_10_m = with(measured, "systems.0.wind_speed_10m_mps", "9.0");
    ASSERT_TRUE(at_10_m) << at_10_m.error().message;
    EXPECT_FALSE(std::get<WindSea>(at_10_m->sea.systems[0]).wind_speed_19m5_mps);
    EXPECT_TRUE(with(*at_10_m, "systems.0.wind_speed_19m5_mps", "11.0"));
    EXPECT_THAT(error_of(phillips + row("sea.system.0.significant_height_m = 2.0, "
                                        "sea.system.0.phillips_constant = 0.001")),
                HasSubstr("excludes significant_height_m: give one of the two"));
}

// Naive: a preset became a swell when the scene was read, and another one stands beside it: 7 m and 9 make 11, from two sides.
TEST(Weather, a_preset_of_the_sea_stands_in_place_of_the_one_before) {
    const std::string seven = "[sea]\npreset = \"beaufort:7\"\nfrom_deg = 225\n";
    const std::string nine = "[sea]\npreset = \"beaufort:9\"\nfrom_deg = 225\n";
    for (const char* path : {"sea.preset", "systems.0.preset", "sea.system.0.preset"}) {
        const Result<Scene> stormier = with(scene_of(seven), path, "\"beaufort:9\"");
        ASSERT_TRUE(stormier) << stormier.error().message;
        EXPECT_EQ(to_toml(*stormier), to_toml(scene_of(nine))) << path;
    }
    const Result<Scene> turned = with(scene_of(seven), "sea.from_deg", "10");
    ASSERT_TRUE(turned) << turned.error().message;
    EXPECT_EQ(turned->sea.systems.size(), 1u);
    EXPECT_EQ(error_of(seven + row("sea.preset = \"beaufort:9\", sea.from_deg = 180") +
                       "[[weather]]\nat_s = 1000\nset.sea.preset = \"beaufort:3\"\n"),
              "no error");
    // In place of a system of whatever type; the direction stays, where it has one.
    const Result<Scene> swell = with(scene_of(system_of("jonswap", "wind_speed_10m_mps = 5\n")),
                                     "systems.0.preset", "\"wmo:5\"");
    ASSERT_TRUE(swell) << swell.error().message;
    EXPECT_EQ(to_toml(*swell), to_toml(scene_of("[sea]\npreset = \"wmo:5\"\nfrom_deg = 270\n")));
    // Of two which is meant must be said, and on a flat sea there is none yet.
    const Scene two = scene_of(seven + "[[sea.system]]\npreset = \"wmo:2\"\nfrom_deg = 0\n");
    const Result<Scene> either = with(two, "sea.preset", "\"beaufort:9\"");
    ASSERT_FALSE(either);
    EXPECT_THAT(either.error().message,
                AllOf(StartsWith("sea.preset: "), HasSubstr("sea.system.0.preset")));
    EXPECT_TRUE(with(two, "systems.1.preset", "\"beaufort:9\""));
    const std::vector<TomlAssignment> begins{{"sea.preset", "\"beaufort:7\""},
                                             {"sea.from_deg", "225"}};
    const Result<Scene> no_longer_flat = changed(scene_of("[sea]\n"), begins);
    ASSERT_TRUE(no_longer_flat) << no_longer_flat.error().message;
    EXPECT_EQ(to_toml(*no_longer_flat), to_toml(scene_of(seven)));
}

// Naive: the effective text holds the table itself, and ramps, beside which no file may be named.
TEST(Weather, another_list_of_waves_stands_in_place_of_the_one_before_and_of_ramps) {
    const std::string list = "\"wavelength_m,amplitude_m,from_deg,phase_rad\\n20,0.5,90,0\\n\"";
    const std::string other = "\"wavelength_m,amplitude_m,from_deg,phase_rad\\n25,0.5,90,0\\n\"";
    const std::string sines = "[sea]\n[[sea.system]]\ntype = \"sines\"\nlength_m = 197\n";
    const Scene ramps = scene_of(sines + "wavelength_m = 30\nfrom_deg = 10\n");
    for (const Scene& scene : {ramps, scene_of(sines + "data = " + other + "\n")}) {
        const Result<Scene> listed = with(scene, "systems.0.data", list);
        ASSERT_TRUE(listed) << listed.error().message;
        EXPECT_EQ(to_toml(*listed), to_toml(scene_of(sines + "data = " + list + "\n")));
        const Result<Scene> missing = with(scene, "systems.0.file", "\"no_such.csv\"");
        ASSERT_FALSE(missing);
        EXPECT_THAT(missing.error().message, HasSubstr("no_such.csv")) << "it alone is looked for";
    }
}

// Naive: both stand, and the threshold wins for ever.
TEST(Weather, observed_coverage_takes_the_place_of_a_threshold) {
    const Scene scene = scene_of(system_of("jonswap", "wind_speed_10m_mps = 12\n"));
    const Result<Scene> by_hand = with(scene, "foam.threshold", "0.9");
    ASSERT_TRUE(by_hand);
    EXPECT_EQ(by_hand->foam.threshold, 0.9);
    const Result<Scene> observed = with(*by_hand, "foam.coverage", "\"observed\"");
    ASSERT_TRUE(observed) << observed.error().message;
    EXPECT_EQ(to_toml(*observed), to_toml(scene));
}

// Naive: a row may begin where the last second is, however many of them, each within the ones before.
TEST(Weather, no_row_begins_after_the_last_second_that_one_may_begin_at) {
    const std::string calm = system_of("jonswap", "wind_speed_10m_mps = 5\n");
    const auto row_at = [](const char* at_s) {
        return fmt::format("[[weather]]\nat_s = {}\nover_s = 10\nset.sea.seed = 2\n", at_s);
    };
    EXPECT_EQ(error_of(calm + row_at("9999999990.0") + row_at("1e10")), "no error");
    EXPECT_THAT(error_of(calm + row_at("1e10") + row_at("1e10")),
                AllOf(HasSubstr("weather[2].at_s"), HasSubstr("the row before ends")));
}

// Naive: the constant stays, which at 20 m/s is a sea of 5.3 m.
TEST(Weather, a_sea_that_is_given_by_its_height_keeps_it_in_another_wind) {
    const Scene scene =
        scene_of(system_of("phillips", "wind_speed_10m_mps = 15\nsignificant_height_m = 3\n"));
    const Result<Scene> windier = with(scene, "systems.0.wind_speed_10m_mps", "20.0");
    ASSERT_TRUE(windier) << windier.error().message;
    EXPECT_NEAR(height_of(*windier), height_of(scene), 1e-4); // what a quadrature leaves of a tail
    EXPECT_THAT(to_toml(scene),
                AllOf(HasSubstr("significant_height_m = 3"), Not(HasSubstr("phillips_constant"))));
    // A light wind raises no such sea.
    const Result<Scene> calmer = with(scene, "systems.0.wind_speed_10m_mps", "2.0");
    ASSERT_FALSE(calmer);
    EXPECT_THAT(calmer.error().message, HasSubstr("significant_height_m: 3 is not allowed"));
}

// Naive: a table that says nothing is not written, and what stands in no text cannot be set.
TEST(Weather, water_that_a_scene_says_nothing_of_can_be_changed) {
    const std::string text = system_of("jonswap", "wind_speed_10m_mps = 5\n");
    const Scene plain = scene_of(text);
    ASSERT_EQ(plain.water, Water{});
    const Result<Scene> second = with(plain, "water.type", "\"II\"");
    ASSERT_TRUE(second) << second.error().message;
    EXPECT_EQ(name_of(second->water.type), std::string("II"));
    EXPECT_EQ(second->water.bottom_albedo, plain.water.bottom_albedo);
    const Result<Scene> albedo = with(plain, "water.bottom_albedo", "[0.1, 0.2, 0.3]");
    ASSERT_TRUE(albedo) << albedo.error().message;
    EXPECT_EQ(albedo->water.type, plain.water.type);
    const Result<Scene> back =
        with(*second, "water.type", fmt::format("\"{}\"", name_of(plain.water.type)));
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(back->water, plain.water);
    EXPECT_EQ(scene_of(text + row("water.type = \"II\"")).weather.size(), 1u);
}

// Naive: by the lines of a text that was never anybody's, and systems by numbers one higher than in what was asked for.
TEST(Weather, what_is_wrong_is_named_by_the_path_that_was_set) {
    const std::string text = system_of("jonswap", "wind_speed_10m_mps = 5\n");
    const auto why = [&](const char* path, const char* value) {
        const Result<Scene> next = with(scene_of(text), path, value);
        return next ? "nothing" : next.error().message;
    };
    EXPECT_THAT(why("systems.0.from_deg", "1e308"), StartsWith("sea.system.0.from_deg: 1e+308"));
    EXPECT_THAT(why("sea.choppiness", "4"), StartsWith("sea.choppiness: 4 is not allowed"));
    EXPECT_THAT(why("water.type", "\"mud\""), StartsWith("water.type: "));
    EXPECT_THAT(why("cascade.0.size", "7"), StartsWith("cascade.0.size: 7 is not allowed"));
    const std::string whole = text + row("sea.choppiness = 4");
    const auto line =
        1 + std::count(whole.begin(),
                       whole.begin() + static_cast<std::ptrdiff_t>(whole.find("choppiness")), '\n');
    EXPECT_THAT(
        error_of(whole),
        StartsWith(fmt::format("s.toml:{}: weather[1]: sea.choppiness: 4 is not allowed", line)));
}

// Naive: the last one counts.
TEST(Weather, one_value_is_not_set_twice_by_whatever_names) {
    const std::vector<TomlAssignment> both{{"systems.0.from_deg", "1"},
                                           {"sea.system.0.from_deg", "2"}};
    const Result<Scene> next =
        changed(scene_of(system_of("jonswap", "wind_speed_10m_mps = 5\n")), both);
    ASSERT_FALSE(next);
    EXPECT_EQ(next.error().message, "sea.system.0.from_deg: is set twice");
}

} // namespace
} // namespace seaway::sea
