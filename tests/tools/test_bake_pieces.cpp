// SPDX-License-Identifier: Apache-2.0
// seaway-bake: frames that are baked alone or in pieces, and foam, which has a past.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "tests/support/read_file.h"
#include "tests/tools/bake_fixture.h"

namespace seaway {
namespace {

using namespace tests_of_bake;
using testing::ExrFile;
using ::testing::HasSubstr;
using tests::Output;

// Naive: each piece counts from 0, and begins at a time that has been rounded already.
TEST(Bake, pieces_of_a_film_are_its_files) {
    const std::string whole = tests::folder().file("whole"),
                      pieces = tests::folder().file("pieces");
    const std::string same =
        " --fps 24000/1001 --start 4.1 --size 64 --summed --fields height,slope_x --mesh ply";
    ASSERT_EQ(run_bake("--out " + whole + " --frames 5" + same).status, 0);
    for (const char* piece :
         {" --first 3 --frames 2", " --first 0 --frames 1", " --first 1 --frames 2"}) {
        const Output ran = run_bake("--out " + pieces + piece + same);
        ASSERT_EQ(ran.status, 0) << ran.err;
    }
    int files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(whole)) {
        const std::string name = entry.path().filename().string();
        EXPECT_EQ(tests::read_file(pieces + "/" + name) == tests::read_file(entry.path()), true)
            << name;
        ++files;
    }
    EXPECT_EQ(files, 5 * 2);
    ExrFile file(pieces + "/sea.00004.exr");
    EXPECT_EQ(file.number("seaway.frame"), 4.0);
    EXPECT_EQ(file.text("seaway.time_us"), "4266833"); // 4.1 s + 4 * 1001 / 24000 s
    EXPECT_EQ(file.number("seaway.tick_s"), 1001.0 / 24000);
}

// Naive: a ratio to an average that there is not is 1, and all of the tile is white.
TEST(Bake, a_sea_without_foam_has_none_in_its_map) {
    std::string text = scene_text; // a Jacobian below -0.9 comes about nowhere in this sea
    text.replace(text.find("threshold = 0.7"), 15, "threshold = -0.9");
    const std::string out = tests::folder().file("calm");
    const Output ran =
        tests::run_program("seaway-bake", tests::folder().write("calm.toml", text) + " --out " +
                                              out + " --frames 1 --fps 8 --size 64 --fields foam");
    ASSERT_EQ(ran.status, 0) << ran.err;
    ExrFile file(out + "/cascade0.00000.exr");
    EXPECT_EQ(file.number("seaway.foam_mean"), 0.0);
    for (const float ratio : file.values("foam"))
        ASSERT_EQ(ratio, 0.0f);
}

TEST(Bake, foam_that_the_scene_does_not_allow_is_refused_by_name) {
    for (const auto& [effects, why] : {std::pair{"foam = false", "no foam"},
                                       {"displacement = \"height\"", "displacement height"}}) {
        const std::string scene =
            tests::folder().write("plain.toml", scene_text + "[effects]\n" + effects + "\n");
        const std::string same =
            scene + " --frames 1 --fps 8 --size 64 --out " + tests::folder().file("plain");
        const Output refused = tests::run_program("seaway-bake", same + " --fields height,foam");
        EXPECT_EQ(refused.status, 2) << refused.err;
        EXPECT_THAT(refused.err,
                    HasSubstr(std::string("--fields: foam, but [effects] has ") + why));
        EXPECT_EQ(refused.error_lines(), 1) << refused.err;
        const Output all = tests::run_program("seaway-bake", same + " --fields all");
        ASSERT_EQ(all.status, 0) << all.err;
        ExrFile file(tests::folder().file("plain") + "/cascade0.00000.exr");
        EXPECT_TRUE(file.has("jacobian"));
        EXPECT_FALSE(file.has("foam")) << "all that there is";
    }
}

// As seaway-inspect has it (docs/scenes.md).
TEST(Bake, a_flat_sea_comes_from_nowhere) {
    const std::string scene = tests::folder().write("flat.toml", "[sea]\n[[cascade]]\n"
                                                                 "length_m = 401\nsize = 64\n");
    const std::string out = tests::folder().file("flat");
    const Output ran = tests::run_program("seaway-bake", scene + " --out " + out +
                                                             " --frames 1 --fps 8 --fields height");
    ASSERT_EQ(ran.status, 0) << ran.err;
    ExrFile file(out + "/cascade0.00000.exr");
    EXPECT_EQ(file.number("seaway.hs_m"), 0.0);
    EXPECT_EQ(file.number("seaway.mean_from_deg"), 0.0);
}

// A history that was walked from the first frame on and one that begins at the piece differ by what is left of their starts.
TEST(Bake, foam_of_a_piece_is_that_of_the_whole) {
    const std::string whole = tests::folder().file("whole_foam"),
                      piece = tests::folder().file("piece_foam");
    const std::string same = " --fps 4 --size 64 --fields foam --out ";
    ASSERT_EQ(run_bake("--frames 9" + same + whole).status, 0);
    ASSERT_EQ(run_bake("--first 8 --frames 1" + same + piece).status, 0);
    const std::vector<float> all = ExrFile(whole + "/cascade0.00008.exr").values("foam");
    const std::vector<float> alone = ExrFile(piece + "/cascade0.00008.exr").values("foam");
    // exp(-10) of what a crest had ten decay times before: up to some tens.
    for (std::size_t i = 0; i < all.size(); ++i)
        ASSERT_NEAR(alone[i], all[i], 2e-3f);
    EXPECT_GT(*std::max_element(all.begin(), all.end()), 2.0f) << "there is some";
}

TEST(Bake, foam_of_a_frame_baked_alone_is_that_of_the_sequence_and_a_loop_meets_itself) {
    // 5 s of loop at 8 frames a second: frame 40 is frame 0. A history is periodic to rounding; alone
    // it starts elsewhere in the loop.
    const std::string text =
        "[sea]\nloop_period_s = 5" + scene_text.substr(std::string("\n[sea]").size());
    const std::string scene = tests::folder().write("loop.toml", text);
    const auto bake = [&](const std::string& name, const std::string& frames) {
        const std::string out = tests::folder().file(name);
        const Output ran = tests::run_program(
            "seaway-bake", scene + " --out " + out + " --fps 8 --size 64 --fields foam " + frames);
        EXPECT_EQ(ran.status, 0) << ran.err;
        return out;
    };
    const std::string film = bake("film", "--frames 41"),
                      alone = bake("alone", "--frames 1 --start 2.375");
    for (const char* cascade : {"/cascade0.", "/cascade1."}) {
        const std::vector<float> first = ExrFile(film + cascade + "00000.exr").values("foam");
        const std::vector<float> last = ExrFile(film + cascade + "00040.exr").values("foam");
        const std::vector<float> within = ExrFile(film + cascade + "00019.exr").values("foam");
        const std::vector<float> single = ExrFile(alone + cascade + "00000.exr").values("foam");
        float largest = 0;
        for (std::size_t i = 0; i < first.size(); ++i) {
            ASSERT_NEAR(last[i], first[i], 2e-4f * (1 + first[i]));
            ASSERT_NEAR(single[i], within[i], 2e-4f * (1 + within[i]));
            largest = std::max(largest, std::abs(within[i] - first[i]));
        }
        EXPECT_GT(largest, 1.0f) << "it moves in between";
    }
}

} // namespace
} // namespace seaway
