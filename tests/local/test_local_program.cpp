// SPDX-License-Identifier: Apache-2.0
// seaway-view --scene as its users run it, beside the same picture of a server of that scene.
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/client/view/golden/picture_difference.h"
#include "tests/client/view/golden/picture_of_file.h"
#include "tests/local/local_scenes.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"
#include "tests/support/read_file.h"
#include "tests/support/server_process.h"

namespace seaway::tests {
namespace {

using testing::HasSubstr;

Output view(const std::string& arguments) {
    return run_program("seaway-view", arguments);
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
        const Output from_server = view(url + how + " --timeout 120 --out " + streamed);
        ASSERT_EQ(from_server.status, 0) << from_server.said();
        const Output made_here = view("--scene " SEAWAY_SOURCE_DIR "/scenes/north_sea_gale.toml" +
                                      how + " --out " + local);
        ASSERT_EQ(made_here.status, 0) << made_here.said();
        EXPECT_THAT(made_here.said(), HasSubstr("t=100.000"));
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
        const Output drawn = view("--scene " + scene + " --offscreen 64x48 --frames 3 --out " +
                                  folder().file(run) + "##.png");
        ASSERT_EQ(drawn.status, 0) << drawn.said();
        EXPECT_THAT(drawn.said(), HasSubstr("00.png t=0.000"));
        EXPECT_THAT(drawn.said(), HasSubstr("02.png t=0.067"));
    }
    EXPECT_EQ(read_picture(folder().file("a02.png")).rgba,
              read_picture(folder().file("b02.png")).rgba);
    EXPECT_NE(read_picture(folder().file("a00.png")).rgba,
              read_picture(folder().file("a02.png")).rgba);
}

const std::string metered = " --exposure ";

/// What a film says that it was metered at, as pieces of it are told.
std::string exposure_of(const std::string& said) {
    const std::size_t at = said.find(metered);
    EXPECT_NE(at, std::string::npos) << said;
    return at == std::string::npos ? "" : said.substr(at, said.find('\n', at) - at);
}

/// Words for a film of a scene; what is to follow is the name of its frames.
std::string film_of(const std::string& scene) {
    const std::string path = folder().write("way.csv", "t_s,x_m,y_m,z_m,yaw_deg,pitch_deg\n"
                                                       "0,0,0,12,215,-6\n0.3,9,0,30,200,-20\n");
    return "--scene " + scene + " --offscreen 64x48 --time 7.3 --fps 24000/1001 --path " + path +
           " --out " + folder().file("");
}

// Naive: each piece meters its own first frame, counts from 0, and begins at the start of the path.
TEST(LocalProgram, pieces_of_a_film_are_its_frames) {
    std::string words = read_file(small_gale());
    const std::string foam = "foam = true";
    words.replace(words.find(foam), foam.size(), "foam = false");
    const std::string film = film_of(folder().write("without_foam.toml", words));
    const Output whole = view(film + "whole##.png --frames 5");
    ASSERT_EQ(whole.status, 0) << whole.said();
    const std::string exposure = exposure_of(whole.said());
    for (const char* piece : {"0 --frames 2", "2 --frames 1", "3 --frames 2"}) {
        const Output drawn = view(film + "piece##.png --first " + piece + exposure);
        ASSERT_EQ(drawn.status, 0) << drawn.said();
        EXPECT_EQ(drawn.said().find(metered), std::string::npos) << "it was given";
    }
    for (const std::string frame : {"00", "01", "02", "03", "04"}) {
        const std::string of_whole = read_file(folder().file("whole" + frame + ".png"));
        EXPECT_FALSE(of_whole.empty()) << frame;
        EXPECT_TRUE(read_file(folder().file("piece" + frame + ".png")) == of_whole) << frame;
    }
    EXPECT_NE(read_file(folder().file("whole02.png")), read_file(folder().file("whole03.png")));
    const Output numbered = view(film + "single.png --first 3 --frames 1" + exposure);
    EXPECT_EQ(numbered.status, 0) << numbered.said();
    EXPECT_THAT(numbered.said(), HasSubstr("single-0003.png t=7.425")); // 3 * 1001 / 24000 later
}

// A history of foam that starts later has forgotten another past: 4.5e-5 of it are left (docs/foam.md), which is a fiftieth of a step
// of 255, so that a byte differs where it lies at an edge of rounding, and by one.
TEST(LocalProgram, a_piece_of_a_film_with_foam_is_off_by_what_is_left_of_the_past_of_its_foam) {
    const std::string film = film_of(small_gale());
    const Output whole = view(film + "foam##.png --frames 3");
    ASSERT_EQ(whole.status, 0) << whole.said();
    const Output piece =
        view(film + "foam_piece##.png --first 2 --frames 1" + exposure_of(whole.said()));
    ASSERT_EQ(piece.status, 0) << piece.said();
    const auto of_whole = read_picture(folder().file("foam02.png")).rgba;
    const auto of_piece = read_picture(folder().file("foam_piece02.png")).rgba;
    ASSERT_EQ(of_piece.size(), of_whole.size());
    std::size_t apart = 0;
    for (std::size_t i = 0; i < of_whole.size(); ++i) {
        EXPECT_LE(std::abs(int{of_piece[i]} - int{of_whole[i]}), 1) << i;
        apart += of_piece[i] != of_whole[i];
    }
    EXPECT_LT(apart, of_whole.size() / 50);
}

/// What a shell says before a program that is to find a stand-in for ffmpeg, which puts what it is given where it is told to.
std::string with_coder() {
    const std::string coder = folder().write("ffmpeg", "#!/bin/sh\nfor to; do :; done\n"
                                                       "exec cat > \"${to#file:}\"\n");
    std::filesystem::permissions(coder, std::filesystem::perms::owner_all);
    return "PATH=" + std::filesystem::path(coder).parent_path().string() + ":$PATH";
}

// The film would take an hour.
TEST(LocalProgram, a_film_that_is_ended_by_a_signal_leaves_the_one_that_was_there) {
    const std::string film = folder().write("storm.mp4", "old");
    const std::string command = "--scene " + small_gale() +
                                " --offscreen 64x48 --frames 100000 --out " + film +
                                " >/dev/null & pid=$!; while kill -0 $pid && [ ! -s " + film +
                                ".part ]; do sleep 0.02; done; kill -TERM $pid; wait $pid";
    const Output ended = run_program("seaway-view", command, "", with_coder());
    EXPECT_EQ(ended.status, 128 + SIGTERM) << ended.said();
    EXPECT_EQ(read_file(film), "old");
    EXPECT_FALSE(std::filesystem::exists(film + ".part"));
}

TEST(LocalProgram, a_film_whose_lines_nobody_reads_on_cannot_be_written_and_leaves_what_was_there) {
    const std::string film = folder().write("unread.mp4", "old");
    const std::string status = folder().file("unread.status");
    const Output ended =
        run_program("seaway-view",
                    "--scene " + small_gale() + " --offscreen 64x48 --frames 100000 --out " + film +
                        "; echo $? >" + status + "; } | head -n 1",
                    "", "{ " + with_coder());
    EXPECT_EQ(read_file(status), "1\n") << ended.said();
    EXPECT_THAT(ended.out, HasSubstr("unread.mp4 t=0.000"));
    EXPECT_THAT(ended.err, HasSubstr("cannot write to standard output"));
    EXPECT_EQ(read_file(film), "old");
    EXPECT_FALSE(std::filesystem::exists(film + ".part"));
}

TEST(LocalProgram, measures_passes_and_shows_every_view) {
    const std::string scene = small_gale();
    const Output bench = view("--scene " + scene + " --offscreen 64x48 --bench 3");
    EXPECT_EQ(bench.status, 0) << bench.said();
    EXPECT_THAT(bench.said(), HasSubstr("frames/s"));
    const Output sheet = view("--scene " + scene + " --offscreen 640x420 --debug all --out " +
                              folder().file("all.png"));
    EXPECT_EQ(sheet.status, 0) << sheet.said();
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
        const Output outcome = view(arguments);
        EXPECT_EQ(outcome.status, 2) << arguments;
        EXPECT_EQ(outcome.out, "");
        EXPECT_EQ(outcome.error_lines(), 1) << outcome.err;
        EXPECT_THAT(outcome.err, HasSubstr(what));
    }
    const Output nowhere = view("--scene " + scene + files + " --device nothing");
    EXPECT_EQ(nowhere.status, 3) << nowhere.said();
}

} // namespace
} // namespace seaway::tests
