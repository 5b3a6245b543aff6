// SPDX-License-Identifier: Apache-2.0
// Scenes that follow from scenes: what a change may say, and what of the rest stays.
#include <string>
#include <variant>

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

} // namespace
} // namespace seaway::sea
