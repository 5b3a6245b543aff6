// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <utility>

#include <sys/stat.h>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include "client/view/picture.h"
#include "client/view/view_options.h"
#include "tests/support/folder.h"
#include "tests/support/full_disk.h"
#include "tests/support/read_file.h"

namespace seaway::client {
namespace {

Picture ramp() {
    Picture picture{16, 4, {}};
    for (int i = 0; i < 16 * 4; ++i)
        for (int c = 0; c < 4; ++c)
            picture.rgba.push_back(0.03f * static_cast<float>(i + c) - 0.2f);
    return picture;
}

TEST(Picture, png_reads_back_as_the_bytes_shown) {
    ShownPicture picture{16, 4, {}};
    std::vector<std::uint8_t> expected;
    for (int i = 0; i < 16 * 4; ++i)
        for (int c = 0; c < 4; ++c) {
            picture.rgba.push_back(static_cast<std::uint8_t>(4 * i + 60 * c));
            if (c < 3)
                expected.push_back(picture.rgba.back());
        }
    const std::string path = tests::folder().file("view_ramp.png");
    ASSERT_TRUE(write_png(picture, path));
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    ASSERT_NE(png_image_begin_read_from_file(&image, path.c_str()), 0);
    image.format = PNG_FORMAT_RGB;
    std::vector<std::uint8_t> bytes(PNG_IMAGE_SIZE(image));
    ASSERT_NE(png_image_finish_read(&image, nullptr, bytes.data(), 0, nullptr), 0);
    EXPECT_EQ(image.width, 16u);
    EXPECT_EQ(bytes, expected);
}

TEST(Picture, exr_keeps_every_number) {
    const Picture picture = ramp();
    const std::string path = tests::folder().file("view_ramp.exr");
    ASSERT_TRUE(write_exr(picture, path));
    std::array<std::vector<float>, 3> channels;
    Imf::InputFile file(path.c_str());
    Imf::FrameBuffer frame;
    for (std::size_t c = 0; c < 3; ++c) {
        channels[c].resize(16 * 4);
        frame.insert(std::array{"R", "G", "B"}[c],
                     Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(channels[c].data()),
                                sizeof(float), 16 * sizeof(float)));
    }
    file.setFrameBuffer(frame);
    file.readPixels(0, 3);
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t i = 0; i < channels[c].size(); ++i)
            EXPECT_EQ(channels[c][i], picture.rgba[4 * i + c]);
    EXPECT_GT(*std::max_element(picture.rgba.begin(), picture.rgba.end()), 1.0f)
        << "beyond the white of a display";
}

// Naive: a height of 0 and no height are the same number.
TEST(Picture, an_exr_of_a_view_of_numbers_says_where_there_is_one_and_of_what) {
    Picture picture{16, 1, std::vector<float>(16 * 4, 0.0f)};
    for (std::size_t x = 0; x < 16; ++x)
        picture.rgba[4 * x + 3] = static_cast<float>(x % 3);
    const std::string path = tests::folder().file("numbers.exr");
    ASSERT_TRUE(write_exr(picture, path, {.debug = "height", .time_us = 1'500'000}));
    Imf::InputFile file(path.c_str());
    std::vector<float> alpha(16);
    Imf::FrameBuffer frame;
    frame.insert("A", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(alpha.data()), sizeof(float),
                                 16 * sizeof(float)));
    file.setFrameBuffer(frame);
    file.readPixels(0, 0);
    for (std::size_t x = 0; x < 16; ++x)
        EXPECT_EQ(alpha[x], static_cast<float>(x % 3)) << x;
    const auto text = [](const Imf::InputFile& of, const char* name) {
        const auto* found = of.header().findTypedAttribute<Imf::StringAttribute>(name);
        return found != nullptr ? found->value() : "none";
    };
    EXPECT_EQ(text(file, "seaway.debug"), "height");
    EXPECT_EQ(text(file, "seaway.time_us"), "1500000");
    const std::string lit = tests::folder().file("lit.exr");
    ASSERT_TRUE(write_exr(picture, lit, {.time_us = 2}));
    const Imf::InputFile radiance(lit.c_str());
    EXPECT_EQ(radiance.header().channels().findChannel("A"), nullptr)
        << "of radiance it says nothing";
    EXPECT_EQ(text(radiance, "seaway.debug"), "none");
    EXPECT_EQ(text(radiance, "seaway.time_us"), "2");
}

TEST(Picture, an_exr_that_does_not_fit_is_an_error_to_the_last_byte_and_the_one_before_stays) {
    const std::string path = tests::folder().file("full.exr");
    ASSERT_TRUE(write_exr(ramp(), path));
    const std::string before = tests::read_file(path);
    const std::size_t whole = std::filesystem::file_size(path);
    for (const std::size_t missing : {std::size_t{1}, std::size_t{64}, whole}) {
        const Result<void> written =
            tests::on_full_disk(whole - missing, [&] { return write_exr(ramp(), path); });
        ASSERT_FALSE(written) << missing;
        EXPECT_THAT(written.error().message, testing::HasSubstr(path));
        EXPECT_EQ(tests::read_file(path), before) << missing;
        EXPECT_FALSE(std::filesystem::exists(path + ".part")) << missing;
    }
}

TEST(Picture, a_png_that_does_not_fit_leaves_the_one_before) {
    const std::string path = tests::folder().file("full.png");
    ASSERT_TRUE(write_png({1, 1, {1, 2, 3, 255}}, path));
    const std::string before = tests::read_file(path);
    const auto white = [&] { return write_png({1, 1, {255, 255, 255, 255}}, path); };
    EXPECT_FALSE(tests::on_full_disk(before.size() - 1, white));
    EXPECT_EQ(tests::read_file(path), before);
    EXPECT_FALSE(std::filesystem::exists(path + ".part"));
    EXPECT_TRUE(white());
    EXPECT_NE(tests::read_file(path), before);
}

// Naive: it is opened for writing, and waits for somebody who reads.
TEST(Picture, a_pipe_is_no_file_for_an_exr) {
    const std::string path = tests::folder().file("pipe.exr");
    ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
    const Result<void> written = write_exr(ramp(), path);
    ASSERT_FALSE(written);
    EXPECT_THAT(written.error().message, testing::HasSubstr("is a pipe"));
    EXPECT_TRUE(std::filesystem::exists(path));
}

TEST(Picture, a_path_that_cannot_be_written_is_named) {
    for (const char* path : {"/nonexistent/a.png", "/nonexistent/a.exr"}) {
        const Result<void> written = std::string(path).ends_with("png")
                                         ? write_png({1, 1, {1, 2, 3, 255}}, path)
                                         : write_exr(ramp(), path);
        ASSERT_FALSE(written);
        EXPECT_NE(written.error().message.find(path), std::string::npos);
    }
}

TEST(Picture, exposure_meets_middle_grey_but_stays_near_the_light) {
    Picture grey{8, 8, std::vector<float>(8 * 8 * 4, 2.0f)};
    EXPECT_NEAR(metered_exposure(grey, 10.0) * 2.0, 0.18, 1e-6);
    EXPECT_NEAR(metered_exposure(grey, 0.1), 3.0, 1e-6) << "0.9 / 0.1 over the range of 3";
}

// Rec. 709: the eye sees green best and blue least.
// A white sheet by day, in twilight, under the full moon (0.2 lx) and under stars (half a millilux).
TEST(Picture, night_is_shown_darker_than_day_and_never_black) {
    const auto shown = [](double white) { return white * exposure_by_light(white); };
    EXPECT_NEAR(shown(25), 0.9, 1e-12);
    EXPECT_NEAR(shown(1e-3), 0.9, 1e-12);
    EXPECT_NEAR(shown(6e-5), 0.3, 0.03);
    EXPECT_NEAR(shown(1.6e-7), 0.03, 0.005);
    const Picture moonlit{1, 1, {2e-5f, 2e-5f, 2e-5f, 1}};
    EXPECT_LT(metered_exposure(moonlit, 6e-5) * 2e-5, 0.1);
}

TEST(Picture, exposure_weighs_colours_as_the_eye_does) {
    const std::pair<std::array<float, 3>, double> rows[] = {
        {{5, 0, 0}, 0.2126 * 5}, {{0, 2, 0}, 0.7152 * 2}, {{0, 0, 12}, 0.0722 * 12}};
    for (const auto& [colour, luminance] : rows) {
        Picture picture{4, 4, {}};
        for (int i = 0; i < 16; ++i)
            picture.rgba.insert(picture.rgba.end(), {colour[0], colour[1], colour[2], 1.0f});
        EXPECT_NEAR(metered_exposure(picture, 10.0) * luminance, 0.18, 1e-6);
    }
}

// A path of glitter in the picture must not darken the rest: brighter than white is white.
TEST(Picture, the_suns_glitter_weighs_no_more_than_a_white_sheet) {
    constexpr double white = 10.0;
    Picture sea{8, 8, std::vector<float>(8 * 8 * 4, 2.0f)};
    const auto with_glint_of = [&](float radiance) {
        Picture glitter = sea;
        std::fill_n(glitter.rgba.begin(), 4, radiance);
        return metered_exposure(glitter, white);
    };
    EXPECT_EQ(with_glint_of(1e6f), with_glint_of(10.0f));
    EXPECT_LT(with_glint_of(10.0f), with_glint_of(5.0f)) << "up to white it counts";
}

TEST(FramePath, puts_the_number_where_the_pattern_says) {
    EXPECT_EQ(frame_path("a/##.png", 7, true), "a/07.png");
    EXPECT_EQ(frame_path("a/%04d.exr", 7, false), "a/0007.exr");
    EXPECT_EQ(frame_path("a/b.png", 0, false), "a/b.png");
    EXPECT_EQ(frame_path("a/b.png", 3, true), "a/b-0003.png");
    EXPECT_EQ(frame_path("a/%d_x.png", 123, true), "a/123_x.png");
    EXPECT_EQ(frame_path("50%.png", 0, false), "50%.png") << "no pattern";
    EXPECT_EQ(frame_path("50%.png", 2, true), "50%-0002.png");
    // Naive: the first sign decides, which may be of a folder, or of a share.
    EXPECT_EQ(frame_path("C#/##.png", 5, true), "C#/05.png");
    EXPECT_EQ(frame_path("C#/%02d.png", 5, true), "C#/05.png");
    EXPECT_EQ(frame_path("%d/%02d.png", 5, true), "%d/05.png");
    EXPECT_EQ(frame_path("50%_%04d.png", 2, true), "50%_0002.png");
}

// Naive: a sign in a folder's name, which is there already, is taken for the frame's number.
TEST(FramePath, looks_in_the_name_of_the_file_alone) {
    EXPECT_EQ(frame_path("take#2/b.png", 0, false), "take#2/b.png");
    EXPECT_EQ(frame_path("/x/a%d/b.png", 0, false), "/x/a%d/b.png");
    EXPECT_EQ(frame_path("take#2/b.png", 5, true), "take#2/b-0005.png");
}

} // namespace
} // namespace seaway::client
