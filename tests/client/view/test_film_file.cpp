// SPDX-License-Identifier: Apache-2.0
// Films, with a program of the test's own in ffmpeg's place, which keeps what it was told.
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/text_file.h"
#include "client/view/film_file.h"
#include "tests/support/folder.h"

namespace seaway::client {
namespace {

using testing::HasSubstr;

/// Puts a script of this name first where programs are looked for, alone or before the others.
class FilmFileTest : public testing::Test {
  protected:
    void SetUp() override {
        old_path_ = std::getenv("PATH");
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { ::setenv("PATH", old_path_.c_str(), 1); }
    void stand_in(const std::string& script) {
        const std::filesystem::path file = folder_ / "ffmpeg";
        std::ofstream(file) << "#!/bin/sh\n" << script << "\n";
        std::filesystem::permissions(file, std::filesystem::perms::owner_all);
        ::setenv("PATH", (folder_.string() + ":" + old_path_).c_str(), 1);
    }
    std::string kept(const char* name) const {
        const Result<std::string> text = read_text_file((folder_ / name).string(), 1 << 20);
        return text ? *text : "";
    }
    std::string path(const std::string& name) const { return (folder_ / name).string(); }
    /// What it is given, where it is told to put it: the last word, as file:PATH.
    static constexpr const char* into_the_part = "for to; do :; done; cat > \"${to#file:}\"";
    static ShownPicture picture(std::uint8_t first) {
        ShownPicture made{3, 2, {}};
        for (int i = 0; i < 3 * 2 * 4; ++i)
            made.rgba.push_back(static_cast<std::uint8_t>(first + i));
        return made;
    }
    std::filesystem::path folder_ = tests::folder().file("stand_in");
    std::string old_path_;
};

TEST_F(FilmFileTest, hands_every_frame_over_in_order_and_says_what_they_are) {
    stand_in("echo \"$@\" > " + folder_.string() + "/words; " + into_the_part);
    Result<FilmFile> film = FilmFile::open(path("-sea.mp4"), 3, 2, {24000, 1001});
    ASSERT_TRUE(film) << film.error().message;
    std::string expected;
    for (const std::uint8_t first : {0, 100, 200}) {
        ASSERT_TRUE(film->add(picture(first)));
        for (const std::uint8_t byte : picture(first).rgba)
            expected += static_cast<char>(byte);
    }
    ASSERT_TRUE(film->close());
    EXPECT_EQ(kept("-sea.mp4"), expected);
    const std::string words = kept("words");
    // Else ffmpeg takes BT.601, and players BT.709: films greener than pictures of the same frames.
    EXPECT_THAT(words, HasSubstr("scale=out_color_matrix=bt709:out_range=tv,pad="));
    EXPECT_THAT(words, HasSubstr("-colorspace bt709 -color_primaries bt709"));
    EXPECT_THAT(
        words,
        HasSubstr(
            "-f rawvideo -pixel_format rgba -video_size 3x2 -framerate 24000/1001 -i pipe:0"));
    EXPECT_THAT(words, HasSubstr("libx264"));
    EXPECT_THAT(words, HasSubstr(" -f mp4 file:" + path("-sea.mp4.part"))) << "a path is no option";
    EXPECT_THAT(words, HasSubstr("ceil(iw/2)*2")) << "odd sides";
}

TEST_F(FilmFileTest, a_webm_is_vp9) {
    stand_in("echo \"$@\" > " + folder_.string() + "/words; " + into_the_part);
    Result<FilmFile> film = FilmFile::open(path("sea.webm"), 3, 2, {});
    ASSERT_TRUE(film);
    ASSERT_TRUE(film->close());
    EXPECT_THAT(kept("words"), HasSubstr(" -f webm file:"));
    EXPECT_THAT(kept("words"), HasSubstr(" -framerate 30 "));
    EXPECT_THAT(kept("words"), HasSubstr("libvpx-vp9"));
}

TEST_F(FilmFileTest, says_that_the_coder_is_missing_and_what_has_it) {
    ::setenv("PATH", folder_.c_str(), 1);
    std::filesystem::remove(folder_ / "ffmpeg");
    const Result<FilmFile> film = FilmFile::open(path("sea.mp4"), 3, 2, {});
    ASSERT_FALSE(film);
    EXPECT_THAT(film.error().message, HasSubstr("sea.mp4"));
    EXPECT_THAT(film.error().message, HasSubstr("apt install ffmpeg"));
}

// It ends while frames are still coming, as on a full disk: an error of that film, not the end of this program.
TEST_F(FilmFileTest, a_coder_that_ends_early_is_an_error) {
    stand_in("exit 7");
    Result<FilmFile> film = FilmFile::open(path("sea.mp4"), 3, 2, {});
    ASSERT_TRUE(film);
    Result<void> taken;
    for (int i = 0; i < 1'000'000 && taken; ++i) // until what lies between the two is full
        taken = film->add(picture(0));
    ASSERT_FALSE(taken);
    EXPECT_THAT(taken.error().message, HasSubstr("sea.mp4"));
    const Result<void> closed = film->close();
    ASSERT_FALSE(closed);
    EXPECT_THAT(closed.error().message, HasSubstr("status 7"));
}

// Whatever ends a film, the one of yesterday is there, and no piece beside it.
TEST_F(FilmFileTest, a_film_that_fails_leaves_the_one_that_was_there) {
    const auto expect_old_film_alone = [&](const char* when) {
        EXPECT_EQ(kept("sea.mp4"), "old") << when;
        EXPECT_FALSE(std::filesystem::exists(path("sea.mp4.part"))) << when;
    };
    std::ofstream(path("sea.mp4")) << "old";
    stand_in(std::string(into_the_part) + "; exit 3");
    {
        Result<FilmFile> film = FilmFile::open(path("sea.mp4"), 3, 2, {});
        ASSERT_TRUE(film) << film.error().message;
        ASSERT_TRUE(film->add(picture(0)));
        const Result<void> closed = film->close();
        ASSERT_FALSE(closed);
        EXPECT_THAT(closed.error().message, HasSubstr("status 3"));
    }
    expect_old_film_alone("the coder says that it failed");
    stand_in(into_the_part);
    {
        Result<FilmFile> film = FilmFile::open(path("sea.mp4"), 3, 2, {});
        ASSERT_TRUE(film && film->add(picture(0)));
    }
    expect_old_film_alone("given up");
    std::filesystem::create_directory(path("sea.mp4.part"));
    EXPECT_FALSE(FilmFile::open(path("sea.mp4"), 3, 2, {})) << "a folder lies there";
    std::filesystem::remove(path("sea.mp4.part"));
    {
        Result<FilmFile> film = FilmFile::open(path("sea.mp4"), 3, 2, {});
        ASSERT_TRUE(film && film->add(picture(0)) && film->close());
    }
    EXPECT_EQ(kept("sea.mp4").size(), 3u * 2 * 4) << "in its place";
}

} // namespace
} // namespace seaway::client
