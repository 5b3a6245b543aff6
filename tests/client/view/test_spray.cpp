// SPDX-License-Identifier: Apache-2.0
// Spray: when there is any, that it is a function of time, and where it lies.
#include <algorithm>
#include <cmath>

#include "client/view/sea/spray.h"
#include "tests/client/view/renderer_fixture.h"

namespace seaway::client {
namespace {

class SprayTest : public RendererTest {
  protected:
    SprayTest() {
        camera_ = {
            .z_m = 9, .yaw_deg = 0, .pitch_deg = -6, .view_deg = 70, .width = 160, .height = 90};
    }
    /// Crests of 2 m whose Jacobian is 0.5, in so much foam; waves run east.
    static SeaFrame storm(sea::TimeUs time_us, double cover) {
        SyntheticSea sea(one_wave(2.0, 100, 4));
        SeaFrame frame = sea.at(time_us);
        frame.foam_mean = cover;
        frame.foam_threshold = 0.7;
        frame.mean_from_deg = 270;
        return frame;
    }
    struct Drawn {
        Picture picture;
        std::uint64_t passes = 0;
    };
    Drawn drawn(const SeaFrame& frame, int slots) {
        RenderOptions options{.quality = quality_table[quality_default]};
        options.quality.spray_slots = slots;
        options.quality.scale = 1;
        Renderer& renderer = renderer_for(options);
        const std::uint64_t passes_before = renderer.spray_passes();
        Result<Picture> picture = renderer.render(frame, camera_, sky_at_hour(12));
        EXPECT_TRUE(picture) << picture.error().message;
        return {std::move(*picture), renderer.spray_passes() - passes_before};
    }
};

// 3.4 % of the sea are white at 17.2 m/s, where Beaufort 8 begins.
TEST_F(SprayTest, there_is_none_and_no_pass_for_it_below_beaufort_8_nor_at_quality_low) {
    EXPECT_EQ(drawn(storm(0, 0.033), 6).passes, 0u);
    EXPECT_EQ(drawn(storm(0, 0.076), 0).passes, 0u);
    EXPECT_EQ(drawn(storm(0, 0.045), 6).passes, 1u);
    EXPECT_EQ(quality_table[quality_low].spray_slots, 0);
    camera_.z_m = -5;
    EXPECT_EQ(drawn(storm(0, 0.076), 6).passes, 0u) << "under water";
    camera_.z_m = 500;
    camera_.pitch_deg = 60;
    EXPECT_EQ(drawn(storm(0, 0.076), 6).passes, 0u) << "of sky alone";
}

TEST_F(SprayTest, the_same_time_has_the_same_spray_and_another_has_another) {
    SeaFrame frame = storm(1'300'000, 0.07);
    frame.cascades[0].keyframes.after = frame.cascades[0].keyframes.before; // the sea stands still
    const std::vector<float> once = drawn(frame, 6).picture.rgba;
    EXPECT_EQ(drawn(frame, 6).picture.rgba, once);
    SeaFrame later = frame;
    later.time_us += 2 * 1'600'000; // whole periods
    const auto spray_of = [&](const SeaFrame& of) {
        std::vector<float> more = drawn(of, 6).picture.rgba;
        const std::vector<float> bare = drawn(of, 0).picture.rgba;
        for (std::size_t i = 0; i < more.size(); ++i)
            more[i] -= bare[i];
        return more;
    };
    const std::vector<float> now = spray_of(frame), then = spray_of(later);
    double all = 0, other = 0;
    for (std::size_t i = 0; i < now.size(); ++i) {
        all += static_cast<double>(std::abs(now[i]) + std::abs(then[i]));
        other += static_cast<double>(std::abs(now[i] - then[i]));
    }
    // Plumes rise from the same crest in both, so some of one period lie where others of another do: 0.42 are not. The same
    // spray would be 0.
    EXPECT_GT(other, 0.3 * all);
}

// Of the picture without it some of the sea gets lighter; what is far above the crests is sky as it was.
TEST_F(SprayTest, crests_that_break_are_veiled_and_the_sky_high_above_is_not) {
    const SeaFrame frame = storm(700'000, 0.076);
    const Picture bare = drawn(frame, 0).picture, sprayed = drawn(frame, 6).picture;
    int veiled = 0, high = 0;
    double lighter = 0;
    for (int y = 0; y < bare.height; ++y)
        for (int x = 0; x < bare.width; ++x) {
            const double more = luminance(sprayed.pixel(x, y)) - luminance(bare.pixel(x, y));
            ASSERT_TRUE(std::isfinite(more));
            veiled += std::abs(more) > 0.01 * luminance(bare.pixel(x, y));
            high += std::abs(more) > 0 && ray(x, y).z > 0.15; // 9 m over the eye at 60 m
            lighter += more;
        }
    EXPECT_GT(veiled, 40);
    EXPECT_LT(veiled, bare.width * bare.height / 3);
    EXPECT_EQ(high, 0);
    EXPECT_GT(lighter, 0);
    // A sea of the same foam that nowhere comes near to breaking has none.
    SeaFrame round = frame;
    round.foam_threshold = 0.2;
    EXPECT_EQ(drawn(round, 6).picture.rgba, drawn(round, 0).picture.rgba);
}

// The law of whitecaps turned round: 4.45 % at the gale's 19 m/s (docs/foam.md).
TEST_F(SprayTest, the_wind_is_that_of_the_whitecaps) {
    SeaFrame frame = storm(-1'000'000, 0.0445);
    frame.significant_height_m = 1;
    const SprayValues values = spray_values(frame, {.x_m = -1000.5, .y_m = 12}, 6);
    EXPECT_NEAR(values.wind_mps, 19, 0.05);
    EXPECT_NEAR(values.strength, (0.0445 - 0.034) / (0.0759 - 0.034), 1e-6);
    // Cells stay where they are in the world; times before 0 have numbers, too.
    EXPECT_EQ(values.base[0], 65536 - 167 - 24);
    EXPECT_NEAR(values.origin_m[0], -6 * (167 + 24) + 1000.5, 1e-3);
    EXPECT_EQ(values.base[1], 65536 + 2 - 24);
    EXPECT_EQ(values.period, 65535);
    EXPECT_NEAR(values.moment, 1 - 1.0 / 1.6, 1e-6);
    EXPECT_EQ(spray_values(storm(0, 0.03), {}, 6).slots, 0);
}

// Pierson and Moskowitz 1964: Hs = 0.21 U^2 / g of the wind at 19.5 m, which is 1.06 of that at 10 m.
TEST_F(SprayTest, the_wind_of_a_high_sea_is_that_at_ten_metres) {
    SeaFrame frame = storm(0, 0.0445);
    frame.significant_height_m = 12;
    EXPECT_NEAR(spray_values(frame, {}, 6).wind_mps, std::sqrt(9.81 * 12 / 0.21) / 1.06, 0.05);
}

} // namespace
} // namespace seaway::client
