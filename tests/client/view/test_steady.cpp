// SPDX-License-Identifier: Apache-2.0
// What stands still on the sea stands still in the picture, and keyframes come and go unseen.
#include <algorithm>
#include <cmath>

#include "tests/client/view/renderer_fixture.h"

namespace seaway::client {
namespace {

class SteadyTest : public RendererTest {
  protected:
    SteadyTest() {
        camera_ = {.z_m = 12, .yaw_deg = 215, .pitch_deg = -6, .width = 320, .height = 180};
    }
    ShownPicture shown(const SeaFrame& frame) {
        Result<ShownPicture> picture =
            renderer_for({.quality = quality_table[quality_default]})
                .show(frame, camera_, sky_at_hour(15.5), {}, {DebugView::final, 0.1, 1});
        EXPECT_TRUE(picture) << picture.error().message;
        return std::move(*picture);
    }
    /// Mean difference of two pictures in these rows, of 255.
    static double difference(const ShownPicture& a, const ShownPicture& b, int first, int last) {
        double sum = 0;
        int count = 0;
        for (int y = first; y < last; ++y)
            for (int x = 0; x < a.width; ++x)
                for (int c = 0; c < 3; ++c) {
                    const auto at =
                        4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(a.width) +
                             static_cast<std::size_t>(x)) +
                        static_cast<std::size_t>(c);
                    sum += std::abs(int{a.rgba[at]} - int{b.rgba[at]});
                    ++count;
                }
        return sum / count;
    }
    /// The row of the picture that the horizon runs through.
    int horizon_row() const {
        for (int y = 0; y < camera_.height; ++y)
            if (std::asin(ray(camera_.width / 2, y).z) < -horizon_dip_rad(camera_.z_m))
                return y;
        return camera_.height;
    }
};

// Thirty frames a second from a camera that stands still. Waves near the horizon move by a hundredth of a pixel from frame to
// frame; a mesh that followed each frame's largest wave moved all of them, by 1.4 of 255.
TEST_F(SteadyTest, the_far_sea_does_not_swim_below_a_camera_that_stands_still) {
    SyntheticSea sea = gale();
    const int horizon = horizon_row();
    ShownPicture before = shown(sea.at(100'000'000));
    for (int i = 1; i <= 4; ++i) {
        const ShownPicture after = shown(sea.at(100'000'000 + i * 33'333));
        EXPECT_LT(difference(before, after, horizon - 1, horizon + 4), 0.5) << i;
        EXPECT_GT(difference(before, after, horizon + 40, camera_.height), 1)
            << "near it the sea moves";
        before = after;
    }
}

// Two milliseconds across the moment at which a keyframe of every cascade makes room for the next one, and two that lie
// between the same ones: no larger step.
TEST_F(SteadyTest, keyframes_change_without_a_pop) {
    SyntheticSea sea = gale();
    const SeaFrame start = sea.at(0);
    for (const CascadeFrame& cascade : start.cascades) {
        const sea::TimeUs interval_us = cascade.keyframes.after->time_us();
        const sea::TimeUs border_us = 40 * interval_us;
        const auto step = [&](sea::TimeUs middle_us) {
            return difference(shown(sea.at(middle_us - 1000)), shown(sea.at(middle_us + 1000)), 0,
                              camera_.height);
        };
        const double within = step(border_us + interval_us / 3);
        EXPECT_LT(step(border_us), 1.5 * within + 0.05) << interval_us;
        EXPECT_GT(within, 0) << "else this test sees nothing";
    }
}

} // namespace
} // namespace seaway::client
