// SPDX-License-Identifier: Apache-2.0
// How numbers become the bytes that are shown: the last pass of a frame, by itself.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "tests/client/view/renderer_fixture.h"

namespace seaway::client {
namespace {

class FilmTest : public RendererTest {
  protected:
    /// [y][x][rgb]
    std::vector<std::uint8_t> bytes_of(const Picture& picture, const Display& display) {
        const Result<ShownPicture> shown =
            renderer_of(picture.width, picture.height, {}).develop(picture, display);
        EXPECT_TRUE(shown) << shown.error().message;
        std::vector<std::uint8_t> bytes;
        for (std::size_t i = 0; i < shown->rgba.size(); ++i)
            if (i % 4 < 3)
                bytes.push_back(shown->rgba[i]);
        return bytes;
    }
};

Picture brightening() {
    Picture picture{16, 4, {}};
    for (int i = 0; i < 16 * 4; ++i)
        for (int c = 0; c < 4; ++c)
            picture.rgba.push_back(0.03f * static_cast<float>(i + c) - 0.2f);
    return picture;
}

/// The ACES fit by Stephen Hill for equal channels, whose matrices keep grey within their rounding; above white, 1, of
/// the logarithm.
double hills_fit(double grey) {
    grey = grey > 1 ? 1 + std::log(grey) : grey;
    return (grey * (grey + 0.0245786) - 0.000090537) /
           (grey * (0.983729 * grey + 0.4329510) + 0.238081);
}

TEST_F(FilmTest, the_film_curve_of_greys_is_hills_fit_of_aces_and_of_logarithms_above_white) {
    for (const double grey : {0.01, 0.05, 0.18, 0.5, 0.9, 1.0, 2.0, 8.0, 1e3, 1e5}) {
        const auto value = static_cast<float>(grey);
        const std::vector<std::uint8_t> bytes = bytes_of({1, 1, {value, value, value, 1.0f}}, {});
        const double linear = hills_fit(grey);
        const double shown =
            linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
        for (const std::uint8_t byte : bytes)
            EXPECT_NEAR(byte, 255 * std::min(shown, 1.0), 1.0) << grey;
    }
}

// Naive: the strength multiplies what is shown, so that whites turn grey and colours shift.
TEST_F(FilmTest, strength_multiplies_linear_light_before_the_film_curve) {
    const Picture once = brightening();
    Picture brighter = once;
    for (float& value : brighter.rgba)
        value *= 3.0f;
    Display display;
    EXPECT_NE(bytes_of(brighter, display), bytes_of(once, display));
    const std::vector<std::uint8_t> bytes = bytes_of(brighter, display);
    display.exposure = 3.0;
    EXPECT_EQ(bytes, bytes_of(once, display));
}

// Naive: the picture is brought to the screen's size by a sampler that repeats, and a bright right edge shines on the left.
TEST_F(FilmTest, a_border_shows_nothing_of_the_opposite_one) {
    RenderOptions half;
    half.quality.scale = 0.5;
    Result<Renderer> renderer = Renderer::create(*device_, 32, 16, half);
    ASSERT_TRUE(renderer) << renderer.error().message;
    Picture picture{16, 8, std::vector<float>(4 * 16 * 8, 0.0f)};
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 16; ++x)
            if (x == 15 || y == 7)
                std::fill_n(&picture.rgba[4 * static_cast<std::size_t>(16 * y + x)], 4, 1.0f);
    const Result<ShownPicture> shown = renderer->develop(picture, {.bloom = 0});
    ASSERT_TRUE(shown) << shown.error().message;
    const auto byte = [&](int x, int y) {
        return int{shown->rgba[4 * static_cast<std::size_t>(32 * y + x)]};
    };
    for (int y = 0; y < 12; ++y)
        EXPECT_LE(byte(0, y), 1) << y;
    for (int x = 0; x < 28; ++x)
        EXPECT_LE(byte(x, 0), 1) << x;
    EXPECT_GT(byte(31, 4), 150);
    EXPECT_GT(byte(4, 15), 150);
}

TEST_F(FilmTest, the_film_curve_keeps_black_and_order) {
    Picture picture{64, 1, {}};
    for (int i = 0; i < 64; ++i)
        picture.rgba.insert(picture.rgba.end(), 4, 0.5f * static_cast<float>(i));
    const std::vector<std::uint8_t> bytes = bytes_of(picture, {.bloom = 0});
    EXPECT_LE(bytes[0], 1);
    for (std::size_t i = 3; i < bytes.size(); ++i)
        EXPECT_GE(bytes[i] + 1, bytes[i - 3]) << "but for the dither";
    EXPECT_GT(bytes.back(), 240) << "32 times as bright as white";
}

// The aureole of a low sun is yellow, whatever its radiance. Naive: each channel ends at 255, and it turns to flat white.
TEST_F(FilmTest, highlights_keep_their_colour_and_what_is_in_them) {
    std::vector<std::uint8_t> before;
    for (const float radiance : {1.0f, 3.0f, 10.0f, 30.0f, 100.0f}) {
        const std::vector<std::uint8_t> bytes =
            bytes_of({1, 1, {radiance, 0.8f * radiance, 0.4f * radiance, 1.0f}}, {});
        EXPECT_LT(bytes[0], 255) << radiance;
        EXPECT_GT(bytes[0], bytes[2] + 8) << radiance;
        EXPECT_GT(bytes[1], bytes[2]) << radiance;
        if (!before.empty()) {
            EXPECT_GT(bytes[1], before[1] + 1) << radiance << ": brighter than the last";
        }
        before = bytes;
    }
}

// Numbers become colours as the table of views says, three channels that differ.
TEST_F(FilmTest, every_view_shows_its_numbers_on_its_own_scale) {
    const auto shown = [this](DebugView view, double red, double green, double blue,
                              double hs_m = 4) {
        const Picture picture{
            1,
            1,
            {static_cast<float>(red), static_cast<float>(green), static_cast<float>(blue), 1.0f}};
        return bytes_of(picture, {view, 7.0, hs_m}); // an exposure that belongs to none of them
    };
    using Bytes = std::vector<std::uint8_t>;
    for (const DebugView view : {DebugView::foam, DebugView::grid})
        EXPECT_EQ(shown(view, 0.6, 0.2, 1.3), (Bytes{153, 153, 153})) << "0 .. 1 as it is";
    for (const DebugView view : {DebugView::normal, DebugView::slope, DebugView::cascade})
        EXPECT_EQ(shown(view, -0.6, 0.2, 1.0), (Bytes{51, 153, 255})) << "-1 .. 1";
    EXPECT_EQ(shown(DebugView::place, 12.0, -4.0, 0.0), (Bytes{51, 153, 0})) << "tenths of 10 m";
    // A Jacobian of 1, level water, is middle grey; where the surface folds there is red, however little.
    EXPECT_EQ(shown(DebugView::jacobian, 0.8, 0.8, 0.8), (Bytes{102, 102, 102}));
    EXPECT_EQ(shown(DebugView::jacobian, 2.4, 2.4, 2.4), (Bytes{255, 255, 255}));
    for (const double folded : {-0.01, -3.0}) {
        const Bytes red = shown(DebugView::jacobian, folded, folded, folded);
        const double steps[] = {229.5, 12.75,
                                25.5}; // a device stores one that is less than one away
        for (std::size_t c = 0; c < 3; ++c)
            EXPECT_LT(std::abs(red[c] - steps[c]), 1) << folded;
    }
    // An rms slope of 0.2 is half of the scale, 0.05 is seen.
    EXPECT_EQ(shown(DebugView::roughness, 0.2, 0.2, 0.2), (Bytes{255, 115, 0}));
    EXPECT_EQ(shown(DebugView::roughness, 0.05, 0.05, 0.05), (Bytes{96, 0, 0}));
    EXPECT_EQ(shown(DebugView::roughness, 0.6, 0.6, 0.6), (Bytes{255, 255, 255}));
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

// A slow gradient has no bands: over a patch of one value between two bytes, the mean of the bytes is that value.
TEST_F(FilmTest, dither_keeps_what_lies_between_two_bytes) {
    const auto patch = [&](float value) {
        Picture picture{64, 64, {}};
        for (int i = 0; i < 64 * 64; ++i)
            picture.rgba.insert(picture.rgba.end(), {value, value, value, 1.0f});
        const std::vector<std::uint8_t> bytes = bytes_of(picture, {});
        return std::accumulate(bytes.begin(), bytes.end(), 0.0) / static_cast<double>(bytes.size());
    };
    for (const double grey : {0.18, 0.1815, 0.183, 0.1845}) {
        const double linear = hills_fit(grey);
        const double shown = 255 * (1.055 * std::pow(linear, 1 / 2.4) - 0.055);
        EXPECT_NEAR(patch(static_cast<float>(grey)), shown, 0.1)
            << "the fit's matrices keep grey to 0.05 %";
    }
}

// At low quality a quarter of the pixels are drawn; as many as were asked for are shown.
TEST_F(FilmTest, what_is_shown_has_the_size_that_was_asked_for) {
    for (const Quality& quality : quality_table) {
        Result<Renderer> renderer =
            Renderer::create(*device_, camera_.width, camera_.height, {.quality = quality});
        ASSERT_TRUE(renderer) << renderer.error().message;
        SyntheticSea sea(one_wave(0.5, 60, 2));
        const SeaFrame frame = sea.at(500'000);
        const Sky& sky = sky_at_hour(11);
        const Result<ShownPicture> shown =
            renderer->show(frame, camera_, sky, {}, {DebugView::final, 0.05, 1});
        ASSERT_TRUE(shown) << shown.error().message;
        EXPECT_EQ(shown->width, camera_.width) << quality.name;
        EXPECT_EQ(shown->height, camera_.height) << quality.name;
        ASSERT_EQ(shown->rgba.size(), std::size_t{4} * 240 * 136);
        // Drawn and developed apart it is the same.
        const Result<Picture> numbers = renderer->render(frame, camera_, sky);
        ASSERT_TRUE(numbers);
        const Result<ShownPicture> developed =
            renderer->develop(*numbers, {DebugView::final, 0.05, 1});
        ASSERT_TRUE(developed);
        EXPECT_EQ(developed->rgba, shown->rgba) << quality.name;
    }
}

} // namespace
} // namespace seaway::client
