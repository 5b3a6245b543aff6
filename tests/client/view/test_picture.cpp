// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfInputFile.h>
#include <gtest/gtest.h>
#include <png.h>

#include "client/view/picture.h"
#include "client/view/view_options.h"
#include "tests/support/folder.h"

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
    const Picture picture = ramp();
    const Display display{DebugView::final, 2.0, 1.0};
    const std::string path = tests::folder().file("view_ramp.png");
    ASSERT_TRUE(write_png(picture, display, path));
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    ASSERT_NE(png_image_begin_read_from_file(&image, path.c_str()), 0);
    image.format = PNG_FORMAT_RGB;
    std::vector<std::uint8_t> bytes(PNG_IMAGE_SIZE(image));
    ASSERT_NE(png_image_finish_read(&image, nullptr, bytes.data(), 0, nullptr), 0);
    EXPECT_EQ(image.width, 16u);
    EXPECT_EQ(bytes, to_srgb(picture, display));
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

TEST(Picture, a_path_that_cannot_be_written_is_named) {
    for (const char* path : {"/nonexistent/a.png", "/nonexistent/a.exr"}) {
        const Result<void> written = std::string(path).ends_with("png")
                                         ? write_png(ramp(), {}, path)
                                         : write_exr(ramp(), path);
        ASSERT_FALSE(written);
        EXPECT_NE(written.error().message.find(path), std::string::npos);
    }
}

/// The ACES fit by Stephen Hill for equal channels: its matrices keep grey, within their rounding.
double hills_fit(double grey) {
    return (grey * (grey + 0.0245786) - 0.000090537) /
           (grey * (0.983729 * grey + 0.4329510) + 0.238081);
}

TEST(Picture, the_film_curve_of_greys_is_hills_fit_of_aces_in_srgb) {
    for (const double grey : {0.01, 0.05, 0.18, 0.5, 1.0, 2.0, 8.0}) {
        const auto value = static_cast<float>(grey);
        const std::vector<std::uint8_t> bytes = to_srgb({1, 1, {value, value, value, 1.0f}}, {});
        const double linear = hills_fit(grey);
        const double shown =
            linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
        for (const std::uint8_t byte : bytes)
            EXPECT_NEAR(byte, 255 * std::min(shown, 1.0), 1.0) << grey;
    }
}

// Naive: the strength multiplies what is shown, so that whites turn grey and colours shift.
TEST(Picture, strength_multiplies_linear_light_before_the_film_curve) {
    const Picture once = ramp();
    Picture brighter = once;
    for (float& value : brighter.rgba)
        value *= 3.0f;
    Display display;
    EXPECT_NE(to_srgb(brighter, display), to_srgb(once, display));
    const std::vector<std::uint8_t> bytes = to_srgb(brighter, display);
    display.exposure = 3.0;
    EXPECT_EQ(bytes, to_srgb(once, display));
}

TEST(Picture, the_film_curve_keeps_black_and_order) {
    Picture picture{64, 1, {}};
    for (int i = 0; i < 64; ++i)
        picture.rgba.insert(picture.rgba.end(), 4, 0.05f * static_cast<float>(i));
    const std::vector<std::uint8_t> bytes = to_srgb(picture, {});
    EXPECT_LE(bytes[0], 1);
    for (std::size_t i = 3; i < bytes.size(); ++i)
        EXPECT_GE(bytes[i], bytes[i - 3]);
    EXPECT_GT(bytes.back(), 240);
}

// Numbers become colours as the table of views says, three channels that differ.
TEST(Picture, every_view_shows_its_numbers_on_its_own_scale) {
    const auto shown = [](DebugView view, double red, double green, double blue, double hs_m = 4) {
        const Picture picture{
            1,
            1,
            {static_cast<float>(red), static_cast<float>(green), static_cast<float>(blue), 1.0f}};
        return to_srgb(picture, {view, 7.0, hs_m}); // an exposure that belongs to none of them
    };
    using Bytes = std::vector<std::uint8_t>;
    for (const DebugView view :
         {DebugView::jacobian, DebugView::roughness, DebugView::foam, DebugView::grid})
        EXPECT_EQ(shown(view, 0.2, 0.6, 1.3), (Bytes{51, 153, 255})) << "0 .. 1 as it is";
    for (const DebugView view : {DebugView::normal, DebugView::slope, DebugView::cascade})
        EXPECT_EQ(shown(view, -0.6, 0.2, 1.0), (Bytes{51, 153, 255})) << "-1 .. 1";
    EXPECT_EQ(shown(DebugView::place, 12.0, -4.0, 0.0), (Bytes{51, 153, 0})) << "tenths of 10 m";
    // White is the mean sea; half of the significant height is red, as much below it is blue.
    const auto expect_height = [&](double height_m, double hs_m, const Bytes& colour) {
        const Bytes found = shown(DebugView::height, height_m, 0, 0, hs_m);
        for (std::size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(found[c], colour[c], 1) << height_m << " of " << hs_m; // rounding of floats
    };
    expect_height(0, 4, {255, 255, 255});
    expect_height(2, 4, {204, 26, 13});
    expect_height(-2, 4, {13, 51, 179});
    expect_height(2, 8, {230, 140, 134});
    expect_height(9, 4, {204, 26, 13});
}

TEST(Picture, exposure_meets_middle_grey_but_stays_near_the_light) {
    Picture grey{8, 8, std::vector<float>(8 * 8 * 4, 2.0f)};
    EXPECT_NEAR(metered_exposure(grey, 10.0) * 2.0, 0.18, 1e-6);
    EXPECT_NEAR(metered_exposure(grey, 0.1), 3.0, 1e-6) << "0.9 / 0.1 over the range of 3";
}

// Rec. 709: the eye sees green best and blue least.
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

TEST(DebugViews, are_found_by_name_and_cascades_by_number) {
    for (const DebugViewInfo& row : debug_view_table) {
        EXPECT_EQ(&row, &info(row.view)) << "the table is in the order of the views";
        const Result<DebugChoice> choice = parse_debug_view(row.name);
        ASSERT_TRUE(choice);
        EXPECT_EQ(choice->view, row.view);
    }
    EXPECT_EQ(parse_debug_view("cascade:2")->cascade, 2);
    EXPECT_EQ(parse_debug_view("cascade:7")->cascade, 7) << "the last of eight";
    for (const char* wrong :
         {"", "cascade:", "cascade:8", "cascade:9", "cascade:-1", "normal:1", "sea"})
        EXPECT_FALSE(parse_debug_view(wrong)) << wrong;
}

TEST(FramePath, puts_the_number_where_the_pattern_says) {
    EXPECT_EQ(frame_path("a/##.png", 7, 20), "a/07.png");
    EXPECT_EQ(frame_path("a/%04d.exr", 7, 20), "a/0007.exr");
    EXPECT_EQ(frame_path("a/b.png", 0, 1), "a/b.png");
    EXPECT_EQ(frame_path("a/b.png", 3, 4), "a/b-0003.png");
    EXPECT_EQ(frame_path("a/%d_x.png", 123, 200), "a/123_x.png");
    EXPECT_EQ(frame_path("50%.png", 0, 1), "50%.png") << "no pattern";
    EXPECT_EQ(frame_path("50%.png", 2, 3), "50%-0002.png");
    EXPECT_EQ(frame_path("#/b.png", 5, 9), "5/b.png");
}

} // namespace
} // namespace seaway::client
