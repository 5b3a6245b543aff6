// SPDX-License-Identifier: Apache-2.0
// Scenes that follow from scenes: what a change may say, and what of the rest stays.
#include <string>

#include <gmock/gmock.h>

#include "sea/scene/weather.h"
#include "tests/sea/scene_of.h"

namespace seaway::sea {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
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

} // namespace
} // namespace seaway::sea
