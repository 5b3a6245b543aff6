// SPDX-License-Identifier: Apache-2.0
// Light that lens and eye scatter, by the numbers of the finest level and by the bytes that are shown.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "client/view/bloom.h"
#include "gpu/keep.h"
#include "tests/client/view/renderer_fixture.h"

namespace seaway::client {
namespace {

/// The finest level of bloom: [y][x][rgba].
struct SpreadLight {
    int columns = 0, lines = 0;
    std::vector<float> rgba;
    double at(int x, int y, std::size_t channel = 1) const {
        return static_cast<double>(rgba[static_cast<std::size_t>(4 * (y * columns + x)) + channel]);
    }
};

class BloomTest : public RendererTest {
  protected:
    SpreadLight spread_of(const Picture& picture, int pixels) {
        using gpu::keep;
        gpu::OwnedSampler sampler;
        gpu::Image image;
        gpu::Buffer staging;
        const std::size_t bytes = picture.rgba.size() * sizeof(float);
        EXPECT_TRUE(keep(sampler, gpu::create_sampler(*device_, {})));
        EXPECT_TRUE(keep(
            image, gpu::Image::create(*device_, "picture",
                                      {.width = static_cast<std::uint32_t>(picture.width),
                                       .height = static_cast<std::uint32_t>(picture.height)})));
        EXPECT_TRUE(keep(staging,
                         gpu::Buffer::create(*device_, "picture", bytes, gpu::BufferKind::upload)));
        std::copy(picture.rgba.begin(), picture.rgba.end(), staging.mapped_as<float>().begin());
        Result<Bloom> bloom = Bloom::create(*device_, image, pixels, sampler.get());
        EXPECT_TRUE(bloom) << bloom.error().message;
        EXPECT_TRUE(gpu::run_once(*device_, [&](gpu::Commands& commands) {
            gpu::record_upload(commands, staging, image, 4 * sizeof(float));
            bloom->record(commands);
        }));
        SpreadLight spread{bloom->columns(), bloom->lines(), {}};
        spread.rgba.resize(static_cast<std::size_t>(4 * spread.columns * spread.lines));
        EXPECT_TRUE(gpu::download(*device_, bloom->buffer(),
                                  std::as_writable_bytes(std::span(spread.rgba))));
        return spread;
    }
    static Picture grey(int width, int height, float value) {
        Picture picture{width, height, {}};
        for (int i = 0; i < width * height; ++i)
            picture.rgba.insert(picture.rgba.end(), {value, 2 * value, 3 * value, 1.0f});
        return picture;
    }
    /// 1 a channel, twice and three times that, at one pixel of black.
    static Picture one_bright_pixel(int width, int height, int x, int y, float value) {
        Picture picture = grey(width, height, 0);
        const std::size_t at = static_cast<std::size_t>(4 * (y * width + x));
        for (std::size_t c = 0; c < 3; ++c)
            picture.rgba[at + c] = value * static_cast<float>(c + 1);
        return picture;
    }
    ShownPicture developed(const Picture& picture, const Display& display,
                           const Quality& quality = quality_table[quality_high]) {
        Result<ShownPicture> shown =
            renderer_of(picture.width, picture.height, {.quality = quality})
                .develop(picture, display);
        EXPECT_TRUE(shown) << shown.error().message;
        return std::move(*shown);
    }
};

TEST_F(BloomTest, what_is_even_stays_so_and_black_stays_black) {
    for (const int pixels : {2, 4})
        for (const float value : {0.0f, 0.25f, 3e5f}) {
            const SpreadLight spread = spread_of(grey(90, 61, value), pixels);
            EXPECT_EQ(spread.columns, (90 + pixels - 1) / pixels);
            EXPECT_EQ(spread.lines, (61 + pixels - 1) / pixels);
            for (int y = 0; y < spread.lines; ++y)
                for (int x = 0; x < spread.columns; ++x)
                    for (std::size_t c = 0; c < 3; ++c) // sums of weights in single precision
                        ASSERT_NEAR(spread.at(x, y, c), value * static_cast<float>(c + 1),
                                    3e-6 * value)
                            << x << ", " << y;
        }
}

// Each pixel's light is found again in the spot that it becomes, wherever it lies in the texels of any level.
TEST_F(BloomTest, no_light_is_lost_or_made_away_from_borders) {
    for (const int pixels : {2, 4})
        for (const auto& [x, y] : {std::pair(256, 256), {255, 257}, {243, 250}, {270, 301}}) {
            const SpreadLight spread = spread_of(one_bright_pixel(512, 512, x, y, 1000), pixels);
            for (std::size_t c = 0; c < 3; ++c) {
                double sum = 0;
                for (int j = 0; j < spread.lines; ++j)
                    for (int i = 0; i < spread.columns; ++i)
                        sum += spread.at(i, j, c);
                // What the coarsest levels, 2 % of the light, would carry beyond the picture stays at its border.
                EXPECT_NEAR(sum * pixels * pixels / (1000.0 * static_cast<double>(c + 1)), 1, 0.01)
                    << x << ", " << y << " by " << pixels;
            }
        }
}

TEST_F(BloomTest, a_bright_pixel_becomes_a_round_spot_that_falls_with_distance) {
    // Four pixels around the corner of four texels of every level: the spot's middle.
    Picture picture = grey(512, 512, 0);
    for (const auto& [x, y] : {std::pair(255, 255), {256, 255}, {255, 256}, {256, 256}})
        for (std::size_t c = 0; c < 3; ++c)
            picture.rgba[static_cast<std::size_t>(4 * (y * 512 + x)) + c] = 1e4f;
    const SpreadLight spread = spread_of(picture, 2);
    const auto around = [&](double radius, double turn) { // linear between texels
        const double x = 127.5 + radius * std::cos(turn), y = 127.5 + radius * std::sin(turn);
        const int i = static_cast<int>(x), j = static_cast<int>(y);
        const double s = x - i, t = y - j;
        return (1 - t) * ((1 - s) * spread.at(i, j) + s * spread.at(i + 1, j)) +
               t * ((1 - s) * spread.at(i, j + 1) + s * spread.at(i + 1, j + 1));
    };
    double before = 1e9;
    for (double radius = 2.5; radius < 80; radius *= 1.25) {
        double sum = 0, most = 0, least = 1e9;
        for (int k = 0; k < 32; ++k) {
            const double value = around(radius, k * pi / 16);
            sum += value / 32;
            most = std::max(most, value);
            least = std::min(least, value);
        }
        EXPECT_LT(sum, 0.9 * before) << radius;
        // Splines along two axes are no circles; an eye tells a square from a circle where they differ by more.
        EXPECT_LT(most - least, 0.25 * sum) << radius;
        before = sum;
    }
    // From 4 texels to 32: a factor of 8, of about the third power.
    EXPECT_NEAR(std::log(around(4, 0.4) / around(32, 0.4)) / std::log(8), 3, 0.4);
}

TEST_F(BloomTest, what_is_shown_is_the_picture_and_a_share_of_the_light_around) {
    Picture picture = one_bright_pixel(160, 90, 70, 40, 300);
    for (std::size_t i = 0; i < picture.rgba.size(); ++i)
        picture.rgba[i] += i % 4 == 3 ? 0.0f : 0.02f * static_cast<float>(i % 7);
    const SpreadLight spread = spread_of(picture, 2);
    constexpr double share = 0.2;
    Picture mixed = picture;
    for (int y = 0; y < 90; ++y)
        for (int x = 0; x < 160; ++x)
            for (std::size_t c = 0; c < 3; ++c) {
                const auto from = [&](double at, int sides) {
                    const double low = std::clamp((at + 0.5) / 2 - 0.5, 0.0, sides - 1.0);
                    return std::pair(std::min(static_cast<int>(low), sides - 2),
                                     low - std::min(static_cast<int>(low), sides - 2));
                };
                const auto [i, s] = from(x, spread.columns);
                const auto [j, t] = from(y, spread.lines);
                const double light =
                    (1 - t) * ((1 - s) * spread.at(i, j, c) + s * spread.at(i + 1, j, c)) +
                    t * ((1 - s) * spread.at(i, j + 1, c) + s * spread.at(i + 1, j + 1, c));
                float& value = mixed.rgba[static_cast<std::size_t>(4 * (y * 160 + x)) + c];
                value =
                    static_cast<float>((1 - share) * static_cast<double>(value) + share * light);
            }
    const ShownPicture found = developed(picture, {.bloom = share});
    const ShownPicture expected = developed(mixed, {.bloom = 0});
    for (std::size_t i = 0; i < found.rgba.size(); ++i)
        ASSERT_NEAR(found.rgba[i], expected.rgba[i], 1) << i; // a number between two bytes
}

// Without it the picture is what it would be if there were none, to the bit; numbers of debug views are never spread.
TEST_F(BloomTest, off_it_changes_no_byte) {
    const Picture picture = one_bright_pixel(64, 36, 30, 20, 50);
    Quality without = quality_table[quality_high];
    without.bloom_pixels = 0;
    const std::vector<std::uint8_t> plain = developed(picture, {}, without).rgba;
    EXPECT_EQ(developed(picture, {.bloom = 0}).rgba, plain);
    EXPECT_NE(developed(picture, {}).rgba, plain) << "else this test sees nothing";
    EXPECT_EQ(quality_table[quality_low].bloom_pixels, 0);
    const Display slopes{.view = DebugView::slope};
    EXPECT_EQ(developed(picture, slopes).rgba, developed(picture, slopes, without).rgba);
}

} // namespace
} // namespace seaway::client
