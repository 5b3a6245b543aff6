// SPDX-License-Identifier: Apache-2.0
// What one scene says other than another, by paths.
#include "server/scene_difference.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "server/following.h"

namespace seaway::server {
namespace {

constexpr const char* before = "[sea]\nseed = 1\ndepth_m = 50.0\n"
                               "\n[[sea.system]]\ntype = \"wind\"\nfrom_deg = 315.0\n"
                               "\n[[sea.system]]\ntype = \"swell\"\nfrom_deg = 0.0\n"
                               "\n[water]\ntype = \"II\"\n\n[accuracy]\nheight_error_m = 0.01\n";

std::string with(std::string text, const std::string& old, const std::string& now) {
    return text.replace(text.find(old), old.size(), now);
}

/// Of the change from `before`, as a history tells it.
std::vector<std::string> told(const std::string& after) {
    const std::vector<SeaChange> changes{{.epoch = 1, .scene = before},
                                         {.epoch = 2, .scene = after}};
    return nlohmann::json::parse(history_json(changes, 2))["changes"][0]["differs"];
}

using Lines = std::vector<std::string>;

TEST(SceneDifference, of_none_there_is_none) {
    EXPECT_TRUE(scene_differences(before, before).empty());
}

// Naive: a line that stands anywhere in the scene before is no news.
TEST(SceneDifference, a_value_that_another_table_had_is_told_of_by_its_path) {
    EXPECT_EQ(told(with(before, "315.0", "0.0")), Lines{"sea.system.0.from_deg = 0.0"});
    EXPECT_EQ(told(with(before, "from_deg = 0.0", "from_deg = 315.0")),
              Lines{"sea.system.1.from_deg = 315.0"});
}

TEST(SceneDifference, what_is_there_no_more_is_told_of) {
    EXPECT_EQ(told(with(before, "\n[water]\ntype = \"II\"\n", "")), Lines{"no water.type"});
}

// Naive: the first four lines, and whoever reads them takes them for all.
TEST(SceneDifference, more_than_four_are_counted) {
    std::string after = with(with(before, "seed = 1", "seed = 2"), "50.0", "20.0");
    after = with(with(after, "315.0", "300.0"), "from_deg = 0.0", "from_deg = 10.0");
    EXPECT_EQ(told(after),
              (Lines{"sea.seed = 2", "sea.depth_m = 20.0", "sea.system.0.from_deg = 300.0",
                     "sea.system.1.from_deg = 10.0"}));
    after += "\n[[weather]]\nat_s = 5.0\nset.sea.seed = 4\n\n[[weather]]\nat_s = 9.0\n";
    EXPECT_EQ(told(after).back(), "and 3 more");
    const std::vector<SceneDifference> all = scene_differences(before, after);
    ASSERT_EQ(all.size(), 7u);
    EXPECT_EQ(all[5].path, "weather.0.set.sea.seed");
    EXPECT_EQ(all[6].path, "weather.1.at_s");
    EXPECT_EQ(all[6].after, "9.0");
    EXPECT_FALSE(all[6].before);
    EXPECT_EQ(all[1].before, "50.0");
}

// Naive: what stands twice is held once, and the second is news.
TEST(SceneDifference, rows_of_a_table_are_values_of_its_key_however_often_they_stand) {
    const std::string table =
        "[[sea.system]]\ndata = \"\"\"\n64,0.2,270,0\n64,0.2,270,0\n5,1,0,0\n\"\"\"\n";
    EXPECT_TRUE(scene_differences(table, table).empty());
    const auto fewer = scene_differences(table, with(table, "64,0.2,270,0\n", ""));
    ASSERT_EQ(fewer.size(), 1u);
    EXPECT_EQ(fewer[0].path, "sea.system.0.data");
    EXPECT_EQ(fewer[0].before, "64,0.2,270,0");
    EXPECT_FALSE(fewer[0].after);
    const auto other = scene_differences(table, with(table, "5,1,0,0", "6,1,0,0"));
    ASSERT_EQ(other.size(), 1u);
    EXPECT_EQ(other[0].before, "5,1,0,0");
    EXPECT_EQ(other[0].after, "6,1,0,0");
    // Naive: as they sort, where 10 comes before 5.
    const std::string two = "[[sea.system]]\ndata = \"\"\"\n5,1,0,0\n10,1,0,0\n\"\"\"\n";
    const auto both = scene_differences(two, with(with(two, "5,1", "5,2"), "10,1", "10,2"));
    ASSERT_EQ(both.size(), 2u);
    EXPECT_EQ(both[0].before, "5,1,0,0");
    EXPECT_EQ(both[0].after, "5,2,0,0");
    EXPECT_EQ(both[1].before, "10,1,0,0");
    EXPECT_EQ(both[1].after, "10,2,0,0");
}

} // namespace
} // namespace seaway::server
