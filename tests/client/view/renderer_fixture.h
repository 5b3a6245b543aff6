// SPDX-License-Identifier: Apache-2.0
// A small picture of a sea without a server. Validation layers are on; one message of theirs fails
// the test.
#pragma once

#include <cmath>

#include <gtest/gtest.h>

#include "client/view/renderer.h"
#include "sea/basics/constants.h"
#include "sea/scene/scene.h"
#include "tests/client/view/small_seas.h"
#include "tests/client/view/synthetic_sea.h"
#include "tests/gpu/device_for_tests.h"

namespace seaway::client {

using sea::pi;

class RendererTest : public gpu::DeviceTest {
  protected:
    Camera camera_{.z_m = 14, .yaw_deg = 40, .pitch_deg = -6, .width = 240, .height = 136};

    Picture render(const SeaFrame& frame, const Sky& sky, DebugView view = DebugView::final,
                   const RenderOptions& options = {}) {
        Result<Renderer> renderer =
            Renderer::create(*device_, camera_.width, camera_.height, options);
        EXPECT_TRUE(renderer) << renderer.error().message;
        Result<Picture> picture = renderer->render(frame, camera_, sky, {view});
        EXPECT_TRUE(picture) << picture.error().message;
        return std::move(*picture);
    }
    glm::dvec3 ray(int x, int y) const {
        return glm::normalize(
            camera_.ray((x + 0.5) / camera_.width * 2 - 1, (y + 0.5) / camera_.height * 2 - 1));
    }
    SyntheticSea gale() {
        const Result<sea::Scene> scene =
            sea::read_scene(SEAWAY_SOURCE_DIR "/scenes/north_sea_gale.toml");
        EXPECT_TRUE(scene) << scene.error().message;
        return SyntheticSea(*sea::realize(*scene));
    }
};

inline double luminance(const float* pixel) {
    return 0.2126 * static_cast<double>(pixel[0]) + 0.7152 * static_cast<double>(pixel[1]) +
           0.0722 * static_cast<double>(pixel[2]);
}

} // namespace seaway::client
