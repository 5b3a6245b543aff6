// SPDX-License-Identifier: Apache-2.0
// The sun's path on the water, in numbers: how bright, how much light, how steady.
#include <algorithm>
#include <cmath>

#include "tests/client/view/renderer_fixture.h"

namespace seaway::client {
namespace {

class GlintTest : public RendererTest {
  protected:
    static double reflected(double cosine) { return 0.02 + 0.98 * std::pow(1 - cosine, 5); }
    /// Mean luminance of the disc, kcd/m2.
    static double disc(const Sky& sky) {
        return luminance_of(sky.sun_irradiance()) / (2 * pi * (1 - std::cos(Sky::sun_radius_rad)));
    }
    void look_at_the_mirrored_sun(const Sky& sky) {
        const glm::dvec3 to_sun = sky.sun_direction();
        camera_.yaw_deg = 90 - std::atan2(to_sun.y, to_sun.x) * 180 / pi;
        camera_.pitch_deg = -std::asin(to_sun.z) * 180 / pi;
    }
    Picture lit(const SeaFrame& frame, const Sky& sky, bool detail = false) {
        return render(frame, sky, DebugView::final, {.air = false, .detail = detail});
    }
};

// Level water is a mirror: it shows the disc with its own radiance times what water reflects, and all of its light. A
// lobe of normal facets with the disc's variance was twice as bright in its middle.
TEST_F(GlintTest, level_water_mirrors_the_disc_no_brighter_than_it_is_and_all_of_its_light) {
    camera_.view_deg = 6;                          // a pixel is a twentieth of the disc
    for (const double hour : {12.0, 15.0, 16.8}) { // 45, 30 and 13 degrees high
        const Sky& sky = sky_at_hour(hour);
        look_at_the_mirrored_sun(sky);
        const Picture picture = lit(flat_sea(), sky);
        const double rest = luminance(picture.pixel(2, 2)), sine = sky.sun_direction().z;
        double most = 0, light = 0;
        for (int y = 0; y < picture.height; ++y)
            for (int x = 0; x < picture.width; ++x) {
                const double glint = luminance(picture.pixel(x, y)) - rest;
                const glm::dvec3 along = camera_.ray((x + 0.5) / camera_.width * 2 - 1,
                                                     (y + 0.5) / camera_.height * 2 - 1);
                most = std::max(most, glint);
                light += glint * std::pow(camera_.pixel_rad(), 2) / std::pow(glm::length(along), 3);
            }
        const double mirrored = reflected(sine) * disc(sky);
        EXPECT_LT(most, 1.01 * mirrored) << hour << ": the sky around differs by little";
        EXPECT_GT(most, 0.9 * mirrored) << hour;
        // Around the mirror's angle what water reflects varies over the lobe.
        EXPECT_NEAR(light / (reflected(sine) * luminance_of(sky.sun_irradiance())), 1, 0.06)
            << hour;
    }
}

TEST_F(GlintTest, no_pixel_is_brighter_than_the_disc_mirrored) {
    SyntheticSea swell(one_wave(0.4, 100, 3)), rough = gale();
    camera_.view_deg = 40;
    for (const double hour : {12.0, 17.3, 17.8})
        for (SyntheticSea* sea : {&swell, &rough}) {
            const Sky& sky = sky_at_hour(hour);
            look_at_the_mirrored_sun(sky);
            const Picture picture = lit(sea->at(100'000'000), sky);
            const double to_white = 8 * sky.white_radiance(); // sky and body of the water
            for (int y = 0; y < picture.height; ++y)
                for (int x = 0; x < picture.width; ++x) {
                    const double cosine =
                        glm::dot(-ray(x, y), glm::normalize(sky.sun_direction() - ray(x, y)));
                    if (ray(x, y).z < 0) {
                        ASSERT_LT(luminance(picture.pixel(x, y)),
                                  1.01 * reflected(std::max(cosine, 0.05)) * disc(sky) + to_white)
                            << hour << ": " << x << ", " << y;
                    }
                }
        }
}

// A pixel is worth what the sixteen pixels of a finer picture are worth in its place: glitter does not depend on how
// nodes of the maps and pixels lie to each other, else it flickers as waves go by.
TEST_F(GlintTest, a_pixel_glitters_as_the_mean_of_the_finer_pixels_in_it) {
    SyntheticSea sea = gale();
    const SeaFrame frame = sea.at(100'000'000);
    const Sky& sky = sky_at_hour(15.5);
    look_at_the_mirrored_sun(sky);
    camera_.view_deg = 30;
    camera_.z_m = 8;
    camera_.width = 160;
    camera_.height = 90;
    const Picture coarse = lit(frame, sky, true);
    camera_.width *= 4;
    camera_.height *= 4;
    const Picture fine = lit(frame, sky, true);
    double sum = 0, sum_fine = 0, squares = 0, squares_fine = 0;
    for (int y = 0; y < coarse.height; ++y)
        for (int x = 0; x < coarse.width; ++x) {
            double mean = 0;
            for (int j = 0; j < 4; ++j)
                for (int i = 0; i < 4; ++i)
                    mean += luminance(fine.pixel(4 * x + i, 4 * y + j)) / 16;
            const double here = luminance(coarse.pixel(x, y));
            sum += here;
            sum_fine += mean;
            squares += (here - mean) * (here - mean);
            squares_fine += mean * mean;
        }
    EXPECT_NEAR(sum / sum_fine, 1, 0.05)
        << "facets that hide each other are a formula in one, seen in the other";
    EXPECT_LT(std::sqrt(squares / squares_fine), 0.262);
}

} // namespace
} // namespace seaway::client
