// SPDX-License-Identifier: Apache-2.0
// Pictures of an eye under water, held against optics that are known: Snell's window, exponentials, the surface itself.
#include <algorithm>
#include <cmath>

#include "client/view/sea/eye_side.h"
#include "client/view/water_optics.h"
#include "tests/client/view/renderer_fixture.h"

namespace seaway::client {
namespace {

class UnderWaterTest : public RendererTest {
  protected:
    UnderWaterTest() { camera_ = {.z_m = -5, .pitch_deg = 89, .width = 96, .height = 96}; }
    glm::dvec3 radiance(const Picture& picture, int x, int y) const {
        const float* p = picture.pixel(x, y);
        return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
    }
    glm::dvec3 middle(const SeaFrame& frame, const Sky& sky) {
        return radiance(render(frame, sky), camera_.width / 2, camera_.height / 2);
    }
    static glm::dvec3 attenuation_per_m(const SeaFrame& frame) {
        return water_look(frame.water, frame.depth_m, 1).attenuation_per_m;
    }
    const Sky& noon_ = sky_at_hour(12);
};

// From below a level sea the whole sky lies within asin(1 / 1.34) = 48.3 degrees of the zenith (48.6 with an index of 4/3).
TEST_F(UnderWaterTest, the_sky_is_seen_within_snells_window_and_dark_water_around_it) {
    camera_.view_deg = 120;
    camera_.width = camera_.height = 240;
    const Picture picture = render(flat_sea(), noon_);
    // Means over rings of half a degree, away from the sun in the south.
    std::vector<glm::dvec3> ring(140, glm::dvec3(0));
    std::vector<double> count(140, 0);
    for (int y = 0; y < 240; ++y)
        for (int x = 0; x < 240; ++x) {
            const glm::dvec3 d = ray(x, y);
            const auto at = static_cast<std::size_t>(std::acos(d.z) * 180 / pi * 2);
            if (d.y < 0 || at >= ring.size())
                continue;
            ring[at] += radiance(picture, x, y);
            ++count[at];
        }
    for (std::size_t i = 0; i < ring.size(); ++i)
        ring[i] /= std::max(count[i], 1.0);
    const auto at = [&](double deg) { return ring[static_cast<std::size_t>(2 * deg)]; };
    // The horizon's light is Fresnel's: at the edge all of it is mirrored up. The steepest fall is the edge.
    double steepest = 0, edge_deg = 0;
    for (std::size_t i = 80; i < 110; ++i)
        if (const double fall = luminance_of(ring[i - 1] - ring[i + 1]); fall > steepest) {
            steepest = fall;
            edge_deg = (static_cast<double>(i) + 0.5) / 2;
        }
    EXPECT_NEAR(edge_deg, 48.6, 1);
    for (const double outside : {50.5, 54.0, 60.0}) {
        // Five metres of the North Sea lie before both.
        EXPECT_LT(luminance_of(at(outside)), 0.6 * luminance_of(at(44))) << outside;
        EXPECT_GT(at(outside).g, 1.5 * at(outside).r) << "the colour of water";
    }
}

// Looking down, all light has come down to the eye and a way back: what falls on the level at the eye, times R / pi.
TEST_F(UnderWaterTest, deep_water_darkens_with_depth_as_its_attenuation_says) {
    const SeaFrame frame = flat_sea();
    const glm::dvec3 k = attenuation_per_m(frame);
    const double way = way_of_daylight(noon_);
    for (const double pitch_deg : {-89.0, -30.0, 0.0}) {
        camera_.pitch_deg = pitch_deg;
        camera_.z_m = -4;
        const glm::dvec3 shallow = middle(frame, noon_);
        camera_.z_m = -12;
        const glm::dvec3 deep = middle(frame, noon_);
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(deep[c] / shallow[c] / std::exp(-8 * way * k[c]), 1, 0.01)
                << pitch_deg << " channel " << c;
    }
}

// All that comes up at a depth, from the half of directions below, is R of what goes down there: R is that, and nothing
// else. By Gauss-Legendre over the cosine m, 4 nodes, of a light that goes as 1 / (1 + p m), p the way of daylight over depth.
TEST_F(UnderWaterTest, deep_water_sends_up_its_reflectance_of_what_goes_down) {
    const SeaFrame frame = flat_sea();
    const glm::dvec3 k = attenuation_per_m(frame);
    const glm::dvec3 above = water_look(frame.water, frame.depth_m, 1).reflectance;
    const glm::dvec3 down =
        noon_.sky_irradiance() + noon_.sun_irradiance() * noon_.sun_direction().z;
    constexpr std::pair<double, double> nodes[] = {{0.0694318442, 0.1739274226},
                                                   {0.3300094782, 0.3260725774},
                                                   {0.6699905218, 0.3260725774},
                                                   {0.9305681558, 0.1739274226}};
    camera_.z_m = -2;
    camera_.view_deg = 2;
    glm::dvec3 up(0.0);
    for (const auto& [cosine, weight] : nodes) {
        camera_.pitch_deg = -std::asin(cosine) * 180 / pi;
        up += 2 * pi * weight * cosine * middle(frame, noon_);
    }
    for (int c = 0; c < 3; ++c) {
        const double below = above[c] / (0.41 + 0.48 * above[c]);
        EXPECT_NEAR(up[c] / (below * 0.94 * down[c] * std::exp(-2 * way_of_daylight(noon_) * k[c])),
                    1, 0.01)
            << c;
    }
}

// Straight up at a level surface 2 and 6 m away: what it lets through loses by the exponential, and water scatters before it.
TEST_F(UnderWaterTest, the_sky_overhead_is_brighter_by_the_index_squared_and_fades_with_depth) {
    camera_.view_deg = 4;
    const Sky& evening = sky_at_hour(17); // low: no disc overhead
    const SeaFrame frame = flat_sea();
    const glm::dvec3 k = attenuation_per_m(frame);
    const glm::dvec3 zenith = evening.radiance({0, 0, 1});
    for (const double depth_m : {1.0, 6.0}) {
        camera_.z_m = -depth_m;
        const glm::dvec3 seen = middle(frame, evening);
        for (int c = 0; c < 3; ++c) {
            const double through = (1 - std::pow(0.34 / 2.34, 2)) * 1.34 * 1.34 * zenith[c];
            const double least = through * std::exp(-k[c] * depth_m);
            EXPECT_GT(seen[c], 0.97 * least) << depth_m << " channel " << c;
            // The veil before it: a way of that length through water of this reflectance.
            const double r = 0.14,
                         light = luminance_of(evening.sky_irradiance() + evening.sun_irradiance());
            EXPECT_LT(seen[c], 1.03 * least + 2 * r / pi * light * k[c] * depth_m) << depth_m;
        }
    }
}

TEST_F(UnderWaterTest, points_of_the_surface_are_where_a_query_finds_them_from_below_too) {
    SyntheticSea sea(one_wave(1.0, 100, 3, 2));
    const SeaFrame frame = sea.at(700'000);
    const sea::Surface surface = sea.surface(frame);
    for (const double pitch_deg : {89.0, 40.0}) {
        camera_ = {.x_m = 12,
                   .y_m = -31,
                   .z_m = -6,
                   .yaw_deg = 70,
                   .pitch_deg = pitch_deg,
                   .width = 96,
                   .height = 64};
        const Picture place = render(frame, noon_, DebugView::place);
        int seen = 0;
        for (int y = 2; y < 64; y += 5)
            for (int x = 2; x < 96; x += 5) {
                const float* at = place.pixel(x, y);
                if (at[0] == 0 && at[1] == 0)
                    continue;
                ++seen;
                const sea::LagrangianPoint p =
                    surface.at(camera_.x_m + static_cast<double>(at[0]),
                               camera_.y_m + static_cast<double>(at[1]), frame.time_us);
                // Cells of half a metre and more: flat triangles miss up to a (k s)^2 / 8.
                EXPECT_NEAR(static_cast<double>(at[2]), p.height, 0.03) << x << ", " << y;
            }
        EXPECT_GT(seen, 200) << "of 247, looking up at " << pitch_deg;
    }
}

// In a trough an eye below the mean sea is in the air, in a crest one above it is under water.
TEST_F(UnderWaterTest, the_side_is_that_of_the_water_at_the_eye) {
    sea::Realization waves = one_wave(2.0, 100, 2);
    waves.choppiness = {0, 0};
    SyntheticSea sea(waves);
    const SeaFrame frame = sea.at(0);
    const auto side = [&](double x_m, double z_m) {
        return eye_side(frame, {.x_m = x_m, .z_m = z_m});
    };
    EXPECT_TRUE(side(0, 1).under) << "a crest of 2 m";
    EXPECT_NEAR(side(0, 1).depth_m, 1, 0.01);
    EXPECT_FALSE(side(25, -1).under) << "a trough";
    EXPECT_EQ(side(25, -1).depth_m, 0);
    EXPECT_EQ(side(25, -1).z_m, -1);
    EXPECT_TRUE(side(25, -3).under);
    EXPECT_NEAR(side(25, -3).depth_m, 1, 0.01);
    EXPECT_FALSE(side(0, 30).under);
    // Not nearer than triangles are cut off.
    EXPECT_NEAR(side(0, 2.01).z_m, 2 + eye_clearance_m, 0.01);
    EXPECT_NEAR(side(0, 1.99).z_m, 2 - eye_clearance_m, 0.01);
}

TEST_F(UnderWaterTest, sand_is_seen_through_shallow_water_and_not_through_deep) {
    SeaFrame lagoon = flat_sea(), deep = flat_sea();
    camera_.pitch_deg = -89;
    camera_.z_m = -1;
    lagoon.depth_m = 3;
    const glm::dvec3 sand = middle(lagoon, noon_), water = middle(deep, noon_);
    EXPECT_GT(luminance_of(sand), 3 * luminance_of(water));
    EXPECT_GT(sand.r / water.r, 3);
    lagoon.depth_m = 80;
    EXPECT_NEAR(luminance_of(middle(lagoon, noon_)) / luminance_of(water), 1, 0.01);
    camera_.z_m = -50; // in the sand
    lagoon.depth_m = 3;
    EXPECT_TRUE(std::isfinite(luminance_of(middle(lagoon, noon_))));
}

TEST_F(UnderWaterTest, from_any_height_and_at_any_pitch_every_pixel_is_a_number) {
    SyntheticSea sea = gale();
    const SeaFrame frame = sea.at(100'000'000);
    camera_.width = 48;
    camera_.height = 27;
    std::map<double, Sky> skies; // by the eye's height: one takes longer than ten pictures
    for (const double z_m : {-50.0, -8.0, -1.0, -0.05, 0.0, 0.05, 1.0, 8.0, 1e3, 20e3}) {
        const double eye_m = std::max(z_m, 0.0);
        const Sky& sky = skies.try_emplace(eye_m, sun_direction(15), eye_m).first->second;
        for (const std::size_t quality : {quality_default, quality_high})
            for (const double pitch_deg : {-89.0, -20.0, 0.0, 35.0, 89.0}) {
                camera_.z_m = z_m;
                camera_.pitch_deg = pitch_deg;
                const Picture picture =
                    render(frame, sky, DebugView::final, {.quality = quality_table[quality]});
                for (const float value : picture.rgba) {
                    ASSERT_TRUE(std::isfinite(value)) << z_m << " m, " << pitch_deg << " degrees";
                    ASSERT_GE(value, 0.0f) << z_m << " m, " << pitch_deg << " degrees";
                }
            }
    }
}

// A pixel of a few degrees sees waves that lie elsewhere than along its middle. Naive: a way up ends far above the water, where
// daylight grows without end.
TEST_F(UnderWaterTest, coarse_pixels_of_murky_water_are_no_brighter_than_the_sky) {
    SyntheticSea sea = gale();
    SeaFrame frame = sea.at(100'000'000);
    frame.water.type = sea::WaterType::coastal_9;
    frame.depth_m = 50;
    camera_.width = 32;
    camera_.height = 18;
    camera_.z_m = -5;
    camera_.view_deg = 150;
    for (const std::size_t quality : {quality_default, quality_high})
        for (const double pitch_deg : {-10.0, 20.0, 60.0}) {
            camera_.pitch_deg = pitch_deg;
            const Picture picture = render(frame, sky_at_hour(15), DebugView::final,
                                           {.quality = quality_table[quality]});
            for (std::size_t i = 0; i < picture.rgba.size(); ++i)
                ASSERT_LT(picture.rgba[i], 1000.0f) << i; // klx/sr; the zenith has some 5
        }
}

} // namespace
} // namespace seaway::client
