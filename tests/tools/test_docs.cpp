// SPDX-License-Identifier: Apache-2.0
// What docs/ says of the code is still so: tests that it names exist, files that it names exist, no
// scene key, feature or trap is missing from its table.
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "sea/scene/scene.h"
#include "sea/waves/realize.h"
#include "tests/support/folder.h"
#include "tests/support/read_file.h"

namespace seaway {
namespace {

const std::filesystem::path root = SEAWAY_SOURCE_DIR;

std::string text_of(const std::filesystem::path& path) {
    EXPECT_TRUE(std::filesystem::exists(path)) << path;
    return tests::read_file(path);
}

std::vector<std::string> all_of(const std::string& text, const std::string& pattern,
                                std::size_t group = 1) {
    std::vector<std::string> found;
    const std::regex expression(pattern);
    for (std::sregex_iterator at(text.begin(), text.end(), expression), end; at != end; ++at)
        found.push_back((*at)[group]);
    return found;
}

/// "Suite.name" of every test in tests/.
std::set<std::string> tests_that_exist() {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root / "tests")) {
        if (entry.path().extension() != ".cpp")
            continue;
        const std::string text = text_of(entry.path());
        const std::regex test(R"(\bTEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\s*\))");
        for (std::sregex_iterator at(text.begin(), text.end(), test), end; at != end; ++at)
            names.insert((*at)[1].str() + "." + (*at)[2].str());
    }
    return names;
}

// Of any instantiation, as `All/Suite.name`.
TEST(Docs, tests_that_are_named_exist) {
    const std::set<std::string> existing = tests_that_exist();
    std::size_t names = 0;
    for (const char* page :
         {"physics.md", "features.md", "hard-cases.md", "effects.md", "security.md"})
        for (const std::string& name :
             all_of(text_of(root / "docs" / page), R"(`(?:\w+/)?([A-Z]\w+\.[A-Za-z0-9_]{6,})`)")) {
            EXPECT_TRUE(existing.contains(name)) << page << " names " << name;
            ++names;
        }
    EXPECT_GT(names, 500u); // or the pattern no longer fits the pages
}

// `Suite.*` and `Suite.begins_so_*`, of any instantiation.
TEST(Docs, tests_that_are_named_by_how_they_begin_exist) {
    const std::set<std::string> existing = tests_that_exist();
    std::size_t patterns = 0;
    for (const char* page : {"security.md", "features.md"})
        for (const std::string& begin :
             all_of(text_of(root / "docs" / page), R"(`(?:\w+/)?([A-Z]\w+\.[A-Za-z0-9_]*)\*`)")) {
            const auto found = existing.lower_bound(begin);
            EXPECT_TRUE(found != existing.end() && found->starts_with(begin))
                << page << " names " << begin << "*";
            ++patterns;
        }
    EXPECT_GT(patterns, 50u); // or the pattern no longer fits the pages
}

/// The pages that speak of the code as it is. Decisions and the changelog speak of what it was.
std::vector<std::filesystem::path> pages() {
    std::vector<std::filesystem::path> found{root / "README.md", root / "CONTRIBUTING.md"};
    for (const auto& entry : std::filesystem::directory_iterator(root / "docs"))
        if (entry.path().extension() == ".md")
            found.push_back(entry.path());
    return found;
}

TEST(Docs, files_that_are_named_exist) {
    const std::string path =
        R"(`((?:base|sea|server|client|shaders|protocol|gpu|tools|docs|tests|scenes|cmake)/[\w/.-]+)`)";
    std::size_t names = 0;
    for (const std::filesystem::path& page : pages())
        for (const std::string& name : all_of(text_of(page), path)) {
            EXPECT_TRUE(std::filesystem::exists(root / name)) << page << " names " << name;
            ++names;
        }
    EXPECT_GT(names, 100u); // or the pattern no longer fits the pages
}

TEST(Docs, links_lead_somewhere) {
    std::size_t links = 0;
    for (const std::filesystem::path& page : pages())
        for (const std::string& target : all_of(text_of(page), R"(\]\(([^)#\s]+))")) {
            if (target.find("://") != std::string::npos)
                continue;
            EXPECT_TRUE(std::filesystem::exists(page.parent_path() / target))
                << page << " links " << target;
            ++links;
        }
    EXPECT_GT(links, 10u);
}

std::string scene_reader() {
    std::string text;
    for (const auto& entry : std::filesystem::directory_iterator(root / "sea/scene"))
        if (entry.path().extension() == ".cpp")
            text += text_of(entry.path());
    return text;
}

TEST(Docs, every_key_that_the_scene_reader_asks_for_is_documented) {
    const std::string page = text_of(root / "docs/scenes.md");
    const std::vector<std::string> asked =
        all_of(scene_reader(),
               R"((?:number|integer|flag|text|choice|number_or_pair|require|has)\(\s*"(\w+)\")");
    std::set<std::string> keys(asked.begin(), asked.end());
    EXPECT_GT(keys.size(), 30u); // or the pattern no longer fits the reader
    keys.erase("sea");           // tables
    keys.erase("cascade");
    for (const std::string& key : keys)
        EXPECT_NE(page.find('`' + key + '`'), std::string::npos) << key;
}

TEST(Docs, every_key_that_is_documented_is_asked_for_by_the_scene_reader) {
    const std::string page = text_of(root / "docs/scenes.md");
    const std::string reader = scene_reader();
    // Keys stand in the first cells of the tables, up to the list of scenes.
    const std::string tables = page.substr(0, page.find("## Scenes that come with Seaway"));
    std::size_t keys = 0;
    for (const std::string& cell : all_of(tables, R"(\n\| (`[^|]*) \|)"))
        for (const std::string& key : all_of(cell, R"(`([a-z]\w+)`)")) {
            EXPECT_NE(reader.find('"' + key + '"'), std::string::npos) << key;
            ++keys;
        }
    EXPECT_GT(keys, 50u);
}

/// A block of the page as a whole scene: behind `[sea]` if it has none of its own, a timetable behind a wind too, whose speed it sets.
std::string whole_scene(const std::string& block) {
    if (block.find("[sea]") != std::string::npos)
        return block;
    const bool timetable = block.starts_with("[[weather]]");
    return std::string("[sea]\n") +
           (timetable ? "[[sea.system]]\ntype = \"wind\"\nwind_speed_10m_mps = 12\nfrom_deg = 0\n"
                      : "") +
           block;
}

TEST(Docs, every_scene_of_the_page_of_scenes_is_one) {
    tests::folder().write("buoy.csv", "f_hz,df_hz,s_m2_hz,a1,b1,a2,b2\n0.1,0.02,5,0.5,0.1,0.1,0.1\n"
                                      "0.12,0.02,3,0.5,0.1,0.1,0.1\n");
    const std::vector<std::string> blocks =
        all_of(text_of(root / "docs/scenes.md"), R"(\n```toml\n([^`]*)\n```)");
    EXPECT_EQ(blocks.size(), 3u);
    for (const std::string& block : blocks) {
        const auto scene = sea::parse_scene(whole_scene(block), "page", tests::folder().file(""));
        ASSERT_TRUE(scene) << scene.error().message << "\n" << block;
        const auto sea = sea::realize(*scene);
        EXPECT_TRUE(sea) << sea.error().message << "\n" << block;
    }
}

TEST(Docs, every_feature_of_the_five_systems_has_one_row) {
    const std::string page = text_of(root / "docs/features.md");
    const int counts[] = {28, 13, 8, 31, 25};
    for (int system = 0; system < 5; ++system)
        for (int feature = 1; feature <= counts[system]; ++feature) {
            const std::string id = fmt::format("\n| S{}.{} |", system, feature);
            const auto first = page.find(id);
            ASSERT_NE(first, std::string::npos) << id;
            EXPECT_EQ(page.find(id, first + 1), std::string::npos) << id;
        }
}

TEST(Docs, no_two_features_have_one_number) {
    std::set<std::string> ids;
    for (const std::string& id :
         all_of(text_of(root / "docs/features.md"), R"(\n\| ([A-Z]\d*\.\d+) \|)"))
        EXPECT_TRUE(ids.insert(id).second) << id;
    EXPECT_GT(ids.size(), 105u + 34u) << "those of the five systems and ours";
}

TEST(Docs, every_trap_has_one_row) {
    const std::string page = text_of(root / "docs/physics.md");
    for (int trap = 1; trap <= 64; ++trap) {
        const std::string id = fmt::format("\n| T{} |", trap);
        const auto first = page.find(id);
        ASSERT_NE(first, std::string::npos) << id;
        EXPECT_EQ(page.find(id, first + 1), std::string::npos) << id;
    }
}

} // namespace
} // namespace seaway
