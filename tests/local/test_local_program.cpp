// SPDX-License-Identifier: Apache-2.0
// seaway-view --scene as its users run it, beside the same picture of a server of that scene.
#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/text_file.h"
#include "tests/client/view/golden/picture_difference.h"
#include "tests/client/view/golden/picture_of_file.h"
#include "tests/local/local_scenes.h"
#include "tests/support/folder.h"
#include "tests/support/server_process.h"

namespace seaway::tests {
namespace {

using testing::HasSubstr;

struct Outcome {
    int code = -1;
    std::string text; ///< stdout and stderr
};

Outcome view(const std::string& arguments) {
    Outcome outcome;
    FILE* pipe = popen((SEAWAY_BIN_DIR "/seaway-view " + arguments + " 2>&1").c_str(), "r");
    std::array<char, 256> line{};
    while (fgets(line.data(), line.size(), pipe) != nullptr)
        outcome.text += line.data();
    outcome.code = WEXITSTATUS(pclose(pipe));
    return outcome;
}

// What differs is what tiles may differ by: 1 cm and less of heights of metres. An eye sees nothing of it, but for single
// pixels of glitter.
TEST(LocalProgram, draws_what_a_server_of_the_scene_would_have_it_draw) {
    ServerProcess server(
        {"scenes/north_sea_gale.toml", "--listen", "127.0.0.1:0", "--device", "native"});
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty());
    for (const std::string debug : {"final", "height", "foam", "slope"}) {
        const std::string how =
            " --offscreen 256x144 --time 100 --quality default --debug " + debug;
        const std::string streamed = folder().file("streamed_" + debug + ".png");
        const std::string local = folder().file("local_" + debug + ".png");
        const Outcome from_server = view(url + how + " --timeout 120 --out " + streamed);
        ASSERT_EQ(from_server.code, 0) << from_server.text;
        const Outcome made_here = view("--scene " SEAWAY_SOURCE_DIR "/scenes/north_sea_gale.toml" +
                                       how + " --out " + local);
        ASSERT_EQ(made_here.code, 0) << made_here.text;
        EXPECT_THAT(made_here.text, HasSubstr("t=100.000"));
        const PictureDifference apart = difference(read_picture(local), read_picture(streamed));
        // A third of what is just noticeable, and not one block in five hundred that is seen.
        EXPECT_LT(apart.mean, 0.7) << debug;
        EXPECT_LT(apart.seen_share, 0.002) << debug;
    }
}

TEST(LocalProgram, draws_films_from_time_0_on_and_the_same_bytes_each_time) {
    const std::string scene = small_gale();
    std::string first;
    for (const char* run : {"a", "b"}) {
        const Outcome drawn = view("--scene " + scene + " --offscreen 64x48 --frames 3 --out " +
                                   folder().file(run) + "##.png");
        ASSERT_EQ(drawn.code, 0) << drawn.text;
        EXPECT_THAT(drawn.text, HasSubstr("00.png t=0.000"));
        EXPECT_THAT(drawn.text, HasSubstr("02.png t=0.067"));
    }
    EXPECT_EQ(read_picture(folder().file("a02.png")).rgba,
              read_picture(folder().file("b02.png")).rgba);
    EXPECT_NE(read_picture(folder().file("a00.png")).rgba,
              read_picture(folder().file("a02.png")).rgba);
}

std::string bytes_of(const std::string& path) {
    const Result<std::string> bytes = read_text_file(path, 1 << 22);
    EXPECT_TRUE(bytes) << path;
    return bytes ? *bytes : "";
}

// Naive: each piece meters its own first frame, counts from 0, and begins at the start of the path.
TEST(LocalProgram, pieces_of_a_film_are_its_frames) {
    const std::string path = folder().write("way.csv", "t_s,x_m,y_m,z_m,yaw_deg,pitch_deg\n"
                                                       "0,0,0,12,215,-6\n0.3,9,0,30,200,-20\n");
    const std::string film = "--scene " + small_gale() + " --offscreen 64x48 --time 7.3 --fps " +
                             "24000/1001 --path " + path + " --out " + folder().file("");
    const Outcome whole = view(film + "whole##.png --frames 5");
    ASSERT_EQ(whole.code, 0) << whole.text;
    const std::string metered = " --exposure ";
    const std::size_t at = whole.text.find(metered);
    ASSERT_NE(at, std::string::npos) << whole.text;
    const std::string exposure = whole.text.substr(at, whole.text.find('\n', at) - at);
    for (const char* piece : {"0 --frames 2", "2 --frames 1", "3 --frames 2"}) {
        const Outcome drawn = view(film + "piece##.png --first " + piece + exposure);
        ASSERT_EQ(drawn.code, 0) << drawn.text;
        EXPECT_EQ(drawn.text.find(metered), std::string::npos) << "it was given";
    }
    for (const char* frame : {"00", "01", "02", "03", "04"})
        EXPECT_EQ(bytes_of(folder().file(std::string("piece") + frame + ".png")) ==
                      bytes_of(folder().file(std::string("whole") + frame + ".png")),
                  true)
            << frame;
    EXPECT_NE(bytes_of(folder().file("whole02.png")), bytes_of(folder().file("whole03.png")));
    const Outcome numbered = view(film + "single.png --first 3 --frames 1" + exposure);
    EXPECT_EQ(numbered.code, 0) << numbered.text;
    EXPECT_THAT(numbered.text, HasSubstr("single-0003.png t=7.425")); // 3 * 1001 / 24000 later
}

// A stand-in for ffmpeg puts what it is given where it is told to; the film would take an hour.
TEST(LocalProgram, a_film_that_is_ended_by_a_signal_leaves_the_one_that_was_there) {
    const std::string coder = folder().write("ffmpeg", "#!/bin/sh\nfor to; do :; done\n"
                                                       "exec cat > \"${to#file:}\"\n");
    std::filesystem::permissions(coder, std::filesystem::perms::owner_all);
    const std::string film = folder().write("storm.mp4", "old");
    const std::string command = "--scene " + small_gale() +
                                " --offscreen 64x48 --frames 100000 --out " + film +
                                " >/dev/null & pid=$!; while kill -0 $pid && [ ! -s " + film +
                                ".part ]; do sleep 0.02; done; kill -TERM $pid; wait $pid";
    const char* old_path = std::getenv("PATH");
    const std::string path = old_path == nullptr ? "" : old_path;
    ::setenv("PATH", (std::filesystem::path(coder).parent_path().string() + ":" + path).c_str(), 1);
    const Outcome ended = view(command);
    ::setenv("PATH", path.c_str(), 1);
    EXPECT_EQ(ended.code, 128 + SIGTERM) << ended.text;
    EXPECT_EQ(bytes_of(film), "old");
    EXPECT_FALSE(std::filesystem::exists(film + ".part"));
}

TEST(LocalProgram, measures_passes_and_shows_every_view) {
    const std::string scene = small_gale();
    const Outcome bench = view("--scene " + scene + " --offscreen 64x48 --bench 3");
    EXPECT_EQ(bench.code, 0) << bench.text;
    EXPECT_THAT(bench.text, HasSubstr("frames/s"));
    const Outcome sheet = view("--scene " + scene + " --offscreen 640x420 --debug all --out " +
                               folder().file("all.png"));
    EXPECT_EQ(sheet.code, 0) << sheet.text;
}

TEST(LocalProgram, says_in_one_line_what_is_wrong) {
    const std::string scene = small_gale();
    const std::string files = " --offscreen 64x48 --out " + folder().file("x.png");
    const std::string bench = " --offscreen 64x48 --bench 3";
    const std::pair<std::string, const char*> rows[] = {
        {files, "URL is required, or --scene FILE"},
        {"ws://127.0.0.1:1 --scene " + scene + files, "URL and --scene: one of them"},
        {"--scene " + scene + files + " --rate-max 2", "--rate-max is of a server"},
        {"--scene " + scene + files + " --size-max 128", "--size-max is of a server"},
        {"--scene " + scene + files + " --timeout 3", "--timeout is of a server"},
        {"--scene " + scene + files + " --time now", "--time now is of a server"},
        {"--scene " + scene + files + " --token-file " + scene, "--token-file is of a server"},
        {"--scene " + scene + files + " --ca-file " + scene, "--ca-file is of a server"},
        {"--scene " + scene + bench + " --debug h0:cascade=0", "--debug h0:cascade=0 and --bench"},
        {"--scene " + scene + bench + " --debug sky_sea", "--debug sky_sea and --bench"},
        {"--scene " + scene + bench + " --debug map_slope:cascade=7", "cascade 7: this sea has"},
        {"--scene " + scene + bench + " --debug map_slope:mip=10", "mip 10: this map"},
        {"--scene ''" + files, "--scene"},
        {"--scene /nonexistent.toml" + files, "/nonexistent.toml"},
        {"--scene " + folder().write("bad.toml", "[sea]\nsea = 1\n") + files, "bad.toml"},
        {"--scene " SEAWAY_SOURCE_DIR "/scenes/gerstner_toy.toml" + files, "stylised sines"}};
    for (const auto& [arguments, what] : rows) {
        const Outcome outcome = view(arguments);
        EXPECT_EQ(outcome.code, 2) << arguments;
        EXPECT_EQ(std::count(outcome.text.begin(), outcome.text.end(), '\n'), 1) << outcome.text;
        EXPECT_THAT(outcome.text, HasSubstr(what));
    }
    const Outcome nowhere = view("--scene " + scene + files + " --device nothing");
    EXPECT_EQ(nowhere.code, 3) << nowhere.text;
}

} // namespace
} // namespace seaway::tests
