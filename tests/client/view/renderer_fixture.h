// SPDX-License-Identifier: Apache-2.0
// A small picture of a sea without a server. Validation layers are on; one message of theirs fails
// the test.
#pragma once

#include <cmath>
#include <list>
#include <map>
#include <utility>

#include <gtest/gtest.h>

#include "client/view/renderer.h"
#include "sea/basics/constants.h"
#include "sea/scene/scene.h"
#include "tests/client/view/small_seas.h"
#include "tests/client/view/synthetic_sea.h"
#include "tests/gpu/device_for_tests.h"

namespace seaway::client {

using sea::pi;

/// The same one for all tests of a program: its tables take half a second.
inline const Sky& sky_at_hour(double hour) {
    static std::map<double, Sky> made;
    return made.try_emplace(hour, sun_direction(hour)).first->second;
}

class RendererTest : public gpu::DeviceTest {
  protected:
    static void TearDownTestSuite() {
        renderers_.clear();
        gpu::DeviceTest::TearDownTestSuite();
    }

    Camera camera_{.z_m = 14, .yaw_deg = 40, .pitch_deg = -6, .width = 240, .height = 136};

    Picture render(const SeaFrame& frame, const Sky& sky, DebugView view = DebugView::final,
                   const RenderOptions& options = {}) {
        Result<Picture> picture = renderer_for(options).render(frame, camera_, sky, {view});
        EXPECT_TRUE(picture) << picture.error().message;
        return std::move(*picture);
    }
    Renderer& renderer_for(const RenderOptions& options) {
        return renderer_of(camera_.width, camera_.height, options);
    }
    /// One for all pictures of a suite that are as large and made alike: no picture remembers the last (decision 0026), but
    /// the light of a sky is, which takes longer to make than the picture, and so do pipelines.
    static Renderer& renderer_of(int width, int height, const RenderOptions& options) {
        for (Kept& kept : renderers_)
            if (kept.width == width && kept.height == height && kept.options == options)
                return kept.renderer;
        Result<Renderer> made = Renderer::create(*device_, width, height, options);
        EXPECT_TRUE(made) << made.error().message;
        renderers_.push_back({width, height, options, std::move(*made)});
        return renderers_.back().renderer;
    }
    glm::dvec3 ray(int x, int y) const {
        return glm::normalize(
            camera_.ray((x + 0.5) / camera_.width * 2 - 1, (y + 0.5) / camera_.height * 2 - 1));
    }
    /// How far from the ray of a pixel a place lies that is given from the eye.
    double off_ray_m(const glm::dvec3& seen, int x, int y) const {
        const glm::dvec3 through = ray(x, y);
        return glm::length(seen - through * glm::dot(seen, through));
    }
    static SyntheticSea gale() {
        static const sea::RealizationPtr made = [] {
            const Result<sea::Scene> scene =
                sea::read_scene(SEAWAY_SOURCE_DIR "/scenes/north_sea_gale.toml");
            EXPECT_TRUE(scene) << scene.error().message;
            return std::make_shared<const sea::Realization>(*sea::realize(*scene));
        }();
        return SyntheticSea(made);
    }

    struct Kept {
        int width, height;
        RenderOptions options;
        Renderer renderer;
    };
    static inline std::list<Kept> renderers_; ///< gone before the device
};

inline double luminance(const float* pixel) {
    return 0.2126 * static_cast<double>(pixel[0]) + 0.7152 * static_cast<double>(pixel[1]) +
           0.0722 * static_cast<double>(pixel[2]);
}

/// The way of daylight down over the depth: of the beam, bent by the surface, and of light from all over the sky, whose mean
/// cosine under water is 0.86.
inline double way_of_daylight(const Sky& sky) {
    const double up = sky.sun_direction().z;
    const double beam = luminance_of(sky.sun_irradiance()) * up;
    const double share = beam / (beam + luminance_of(sky.sky_irradiance()));
    return share / std::cos(std::asin(std::sqrt(1 - up * up) / 1.34)) + (1 - share) / 0.86;
}

} // namespace seaway::client
