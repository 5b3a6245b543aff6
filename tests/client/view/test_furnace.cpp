// SPDX-License-Identifier: Apache-2.0
// The sea in a furnace: a sky of one radiance in all directions and no sun. Whatever the waves do, a surface that neither
// makes nor loses light shows what it mirrors and what its water sends back, and never more than comes in.
#include <algorithm>
#include <cmath>

#include "client/view/sky/sky_feed.h"
#include "tests/client/view/renderer_fixture.h"
#include "tests/client/view/sky/sky_files.h"

namespace seaway::client {
namespace {

class FurnaceTest : public RendererTest {
  protected:
    static const Sky& white() {
        static const Sky made = [] {
            Look look;
            look.environment = sky_file(
                "white.exr", sky_picture(64, 32, [](const glm::dvec3&) { return glm::dvec3(1); }));
            SkyMaker maker;
            Result<Sky> sky = maker.make(look, heavens_at_hour(12), {.height_m = 12});
            EXPECT_TRUE(sky) << sky.error().message;
            return *sky;
        }();
        return made;
    }
    Picture render_white(const SeaFrame& frame) {
        return render(frame, white(), DebugView::final, {.air = false, .detail = false});
    }
    glm::dvec3 deep_water_reflectance() const {
        const shaders::vec3& of =
            view_values(flat_sea(), camera_, white(), {}, {}, {}, {}).water_reflectance;
        return {of.x, of.y, of.z};
    }
};

// Fresnel's share is mirrored, the rest goes in, and of that comes back what the water reflects: no more, no less. The
// fit of the mean reflectance has the blur of a sun's disk in it: half a percent.
TEST_F(FurnaceTest, a_flat_sea_sends_back_what_it_mirrors_and_what_its_water_scatters) {
    const glm::dvec3 water = deep_water_reflectance();
    int compared = 0;
    for (const double pitch_deg : {-12.0, -30.0, -60.0, -85.0}) {
        camera_.pitch_deg = pitch_deg;
        const Picture picture = render_white(flat_sea());
        for (int y = 2; y < picture.height; y += 9)
            for (int x = 2; x < picture.width; x += 17) {
                const double cosine = -ray(x, y).z;
                if (cosine < 0.03)
                    continue;
                const double mirrored = 0.02 + 0.98 * std::pow(1 - cosine, 5);
                for (int c = 0; c < 3; ++c) {
                    const double expected = mirrored + (1 - mirrored) * water[c];
                    EXPECT_NEAR(static_cast<double>(picture.pixel(x, y)[c]), expected,
                                0.005 * expected + 2e-3)
                        << pitch_deg << " at " << x << ", " << y;
                }
                ++compared;
            }
    }
    EXPECT_GT(compared, 200);
}

// A sum over facets whose weights do not add up to what is seen of them shows here as a sea brighter than its sky.
TEST_F(FurnaceTest, no_sea_is_brighter_than_the_sky_around_it) {
    SyntheticSea sea = gale();
    const SeaFrame frame = sea.at(100'000'000);
    for (const double z_m : {14.0, 3000.0})
        for (const double pitch_deg : {-2.0, -20.0, -88.0}) {
            camera_.z_m = z_m;
            camera_.pitch_deg = pitch_deg;
            const Picture picture = render_white(frame);
            float brightest = 0, darkest = 1;
            for (std::size_t i = 0; i < picture.rgba.size(); ++i)
                if (i % 4 < 3) {
                    brightest = std::max(brightest, picture.rgba[i]);
                    darkest = std::min(darkest, picture.rgba[i]);
                }
            EXPECT_LE(brightest, 1.001f) << z_m << " m, " << pitch_deg; // the sky itself is 1
            EXPECT_GE(darkest, 0.02f) << "no facet mirrors less";
        }
}

} // namespace
} // namespace seaway::client
