// SPDX-License-Identifier: Apache-2.0
// What an administrator reads of a journal, and the way back to what stands there.
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "sea/scene/weather.h"
#include "server/host/refusal.h"
#include "server/world.h"
#include "tests/server/forgetful_journal.h"
#include "tests/server/simulation/simulation_bench.h"

namespace seaway::server {
namespace {

/// What administrators read of a journal that nobody plays.
class ReadJournal : public testing::Test {
  protected:
    ReadJournal() {
        world.read_by([this](std::uint32_t epoch, std::size_t most) {
            Result<std::vector<SeaChange>> those = some(changes, epoch, most);
            read += those->size();
            ++asked;
            return those;
        });
    }
    void add(const std::string& toml, bool lapsed = false) {
        changes.push_back({.epoch = static_cast<std::uint32_t>(changes.size()) + 1,
                           .start_us = static_cast<sea::TimeUs>(changes.size()),
                           .scene = toml,
                           .lapsed = lapsed});
    }
    void add_pace() {
        changes.push_back({.epoch = static_cast<std::uint32_t>(changes.size()) + 1,
                           .scene = {},
                           .pace = sea::Pace{1, 1, 500}});
    }
    static std::string with(const std::string& path, const std::string& value) {
        const TomlAssignment one{path, value};
        return sea::to_toml(sea::changed(small_scene(), {&one, 1}).value());
    }

    std::vector<SeaChange> changes{{1, 0, 0, sea::to_toml(small_scene())}};
    std::size_t read = 0; ///< changes that were handed over
    int asked = 0;
    const std::shared_ptr<SeaCourse> course = SeaCourse::begin(small_scene()).value();
    SeaClock clock{0, [] { return std::int64_t{5'000'000'000}; }, [] { return std::int64_t{0}; }};
    World world{course, clock};
};

TEST_F(ReadJournal, each_change_differs_from_the_last_scene_that_ran_wherever_a_list_begins) {
    add(with("systems.0.wind_speed_10m_mps", "14.0"));
    for (int i = 0; i < 5; ++i) {
        add_pace();
        add(with("systems.0.wind_speed_10m_mps", fmt::format("{}.5", 20 + i)), true);
    }
    add(with("systems.0.wind_speed_10m_mps", "15.0")); // 13
    const auto whole = nlohmann::json::parse(world.history(1).value())["changes"];
    ASSERT_EQ(whole.size(), 13u);
    for (std::uint64_t from = 1; from <= 13; ++from) {
        const auto listed = nlohmann::json::parse(world.history(from).value())["changes"];
        ASSERT_EQ(listed.size(), 14 - from);
        for (std::size_t i = 0; i < listed.size(); ++i)
            EXPECT_EQ(listed[i], whole[from - 1 + i]) << from;
    }
    ASSERT_EQ(whole[12]["differs"].size(), 1u) << whole[12].dump();
    EXPECT_NE(whole[12]["differs"].dump().find("15"), std::string::npos);
    EXPECT_TRUE(nlohmann::json::parse(world.history(14).value())["changes"].empty());
}

// Naive: from what the journal holds last, which the timetable has led away from, or which another took over from before it began.
TEST_F(ReadJournal, each_change_differs_from_what_runs_when_it_begins) {
    const auto begins = [this](int start_s) {
        changes.back().start_us = 1'000'000 * sea::TimeUs{start_s};
    };
    changes[0].scene = sea::to_toml(
        small_scene("[[weather]]\nat_s = 10\nover_s = 20\nset.systems.0.from_deg = 99\n"
                    "[[weather]]\nat_s = 500\nover_s = 20\nset.sea.seed = 8\n"));
    const auto turned = [](const std::string& more) {
        const TomlAssignment all[]{{"systems.0.from_deg", "99"}, {"systems.0.fetch_m", more}};
        return sea::to_toml(sea::changed(small_scene(), all).value());
    };
    add(turned("50e3"));
    begins(100);
    add(turned("60e3"));
    begins(300);
    add_pace();
    add(turned("70e3")); // takes over from the one at 300 s
    begins(200);
    const auto whole = nlohmann::json::parse(world.history(1).value())["changes"];
    const auto differs = [](const nlohmann::json& change) {
        return change["differs"].get<std::vector<std::string>>();
    };
    using Lines = std::vector<std::string>;
    EXPECT_EQ(differs(whole[1]), Lines{"sea.system.0.fetch_m = 50000"});
    EXPECT_EQ(differs(whole[4]), Lines{"sea.system.0.fetch_m = 70000"});
    add(turned("50e3")); // in the place of that one
    begins(200);
    EXPECT_EQ(differs(nlohmann::json::parse(world.history(6).value())["changes"][0]), Lines{})
        << "of the one at 100 s, which runs until then";
    changes.pop_back();
    changes[1].scene = with("systems.0.wind_speed_10m_mps", "14.0");
    for (std::uint64_t from = 2; from <= 5; ++from)
        EXPECT_EQ(nlohmann::json::parse(world.history(from).value())["changes"].back(),
                  nlohmann::json::parse(world.history(1).value())["changes"].back())
            << from;
    EXPECT_EQ(differs(nlohmann::json::parse(world.history(5).value())["changes"].back()).size(), 3u)
        << "wind, direction and fetch, of the one at 100 s";
}

// A scene may hold a table of 100 KB, a journal 10 000 of them, and who asks is the network's thread.
TEST_F(ReadJournal, no_more_is_read_than_is_told_however_long_it_is) {
    for (int i = 0; i < 3000; ++i)
        add_pace();
    add(with("systems.0.wind_speed_10m_mps", "14.0"));
    (void)world.history(3002).value();
    EXPECT_LE(read, 1u + 3001u) << "one that runs has to be looked for behind paces, once";
    read = 0;
    for (int i = 0; i < 500; ++i)
        add(with("systems.0.wind_speed_10m_mps", fmt::format("{}.25", 10 + i % 10)));
    EXPECT_EQ(nlohmann::json::parse(world.history(3002).value())["changes"].size(), 200u);
    read = 0;
    EXPECT_EQ(nlohmann::json::parse(world.history(3100).value())["changes"].size(), 200u);
    EXPECT_EQ(read, 201u);
    read = 0;
    (void)world.scene_of_change(3100).value();
    EXPECT_EQ(read, 1u);
}

// Naive: the scene before the first that is told of is looked for, number by number from where nothing has ever been: minutes.
TEST_F(ReadJournal, a_history_of_what_has_no_number_yet_is_empty_at_once) {
    for (const std::uint64_t from : {std::uint64_t{2}, std::uint64_t{4'294'967'295}}) {
        asked = 0;
        EXPECT_TRUE(nlohmann::json::parse(world.history(from).value())["changes"].empty());
        EXPECT_EQ(asked, 1) << from;
    }
}

// Four lines a change, two hundred changes: a table's line would fill the answer alone.
TEST_F(ReadJournal, of_a_long_line_a_history_tells_the_beginning) {
    changes.push_back({.epoch = 2, .scene = "table = \"" + std::string(110'000, '1') + "\"\n"});
    const auto listed = nlohmann::json::parse(world.history(2).value())["changes"];
    ASSERT_EQ(listed[0]["differs"].size(), 5u)
        << "it has nothing else, and not all of that is told";
    const std::string line = listed[0]["differs"][0];
    EXPECT_LT(line.size(), 256u);
    EXPECT_TRUE(line.starts_with("table = \"111")) << line;
    EXPECT_TRUE(line.ends_with("1...")) << line;
}

TEST_F(ReadJournal, there_is_no_way_back_to_what_has_no_sea) {
    add(with("sea.depth_m", "50.0"), true);
    add_pace();
    const auto why = [this](std::uint64_t number) {
        const Result<std::string> scene = world.scene_of_change(number);
        EXPECT_FALSE(scene) << number;
        EXPECT_TRUE(scene || scene.error().is(Refusal::bad_value));
        return scene ? "" : scene.error().message;
    };
    EXPECT_NE(why(2).find("change is 2, which came to the journal too late and has lapsed"),
              std::string::npos)
        << why(2);
    EXPECT_NE(why(3).find("change is 3, which is one of pace"), std::string::npos) << why(3);
    EXPECT_NE(why(4).find("change is 4; there is none"), std::string::npos) << why(4);
    EXPECT_NE(why(1ull << 32).find("numbers are 1 .. 4294967295"), std::string::npos);
    for (int i = 0; i < 10'000; ++i) // one a minute for a week
        add_pace();
    EXPECT_NE(why(10'002).find("which is one of pace"), std::string::npos) << why(10'002);
    EXPECT_NE(why(0).find("there is none"), std::string::npos) << why(0);
    EXPECT_EQ(world.scene_of_change(1).value(), changes[0].scene) << "to the letter";
}

// At 5000 s: what its rows have led to by then, and those to come at their own times.
TEST_F(ReadJournal, the_way_back_to_a_scene_with_a_timetable_is_to_where_that_is_now) {
    add(sea::to_toml(
        small_scene("[[weather]]\nat_s = 1000\nover_s = 20\n"
                    "set.systems.0.wind_speed_10m_mps = 14.0\n"
                    "[[weather]]\nat_s = 9000\nover_s = 20\nset.systems.0.from_deg = 123\n")));
    const std::string now = world.scene_of_change(2).value();
    const Result<sea::Scene> read = sea::parse_scene(now, "now", ".");
    ASSERT_TRUE(read) << read.error().message;
    ASSERT_EQ(read->weather.size(), 1u);
    EXPECT_EQ(read->weather[0].at_s, 9000);
    sea::Scene bare = *read;
    bare.weather.clear();
    EXPECT_EQ(sea::to_toml(bare), with("systems.0.wind_speed_10m_mps", "14.0"));
    const Result<void> added = course->add(*read, 5'010'000'000, 5'030'000'000);
    EXPECT_TRUE(added) << added.error().message << " it can be gone back to";
}

} // namespace
} // namespace seaway::server
