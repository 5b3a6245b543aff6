// SPDX-License-Identifier: Apache-2.0
// Water and sea floor as the device draws them, held against client/view/water_optics.h.
#include "client/view/water_optics.h"
#include "tests/client/view/renderer_fixture.h"

namespace seaway::client {
namespace {

class WaterTest : public RendererTest {
  protected:
    /// Mean radiance of the middle of a picture, straight down on a flat sea at noon.
    glm::dvec3 straight_down(const sea::Water& water, double depth_m) {
        SeaFrame frame = flat_sea();
        frame.water = water;
        frame.depth_m = depth_m;
        frame.significant_height_m = 0.1;
        camera_.z_m = 30;
        camera_.pitch_deg = -89;
        camera_.view_deg = 40;
        const Picture picture = render(frame, sky_, DebugView::final, {.air = false});
        glm::dvec3 sum(0);
        int count = 0;
        for (int y = 20; y < picture.height - 20; ++y)
            for (int x = 20; x < picture.width - 20; ++x, ++count)
                for (int c = 0; c < 3; ++c)
                    sum[c] += static_cast<double>(picture.pixel(x, y)[c]);
        return sum / static_cast<double>(count);
    }
    static const Sky& high_sun() {
        static const Sky sky(glm::normalize(glm::dvec3(0.3, -0.2, 0.9)));
        return sky;
    }
    const Sky& sky_ = high_sun();
};

constexpr double deep_m = sea::deep_water_m;

// What a white floor adds to a black one, twice as deep, is less by the way down and up through that water.
TEST_F(WaterTest, light_from_the_floor_falls_with_depth_as_its_attenuation_says) {
    const sea::WaterType type = sea::WaterType::jerlov_2;
    const auto from_floor = [&](double depth_m) {
        return straight_down({type, {1, 1, 1}}, depth_m) -
               straight_down({type, {0.5, 0.5, 0.5}}, depth_m);
    };
    const glm::dvec3 three = from_floor(3), six = from_floor(6);
    const glm::dvec3 k3 = water_look({type}, 3, 0).floor_attenuation_per_m;
    const glm::dvec3 k6 = water_look({type}, 6, 0).floor_attenuation_per_m;
    // The sun stands at 22 degrees from the zenith, 16 in the water: 1.04, with light of the sky 1.05; up: 1 to 1.03.
    const double path = 2.06;
    for (int c = 1; c < 3; ++c) { // of red nothing is left that single precision could tell
        const double expected = std::exp(-(6 * k6[c] - 3 * k3[c]) * path);
        EXPECT_NEAR(six[c] / three[c] / expected, 1, 0.03) << c;
    }
    EXPECT_LT(six.r, 0.3 * three.r);
}

// An eye under water sees the floor itself: a floor of twice the albedo sends twice the light.
TEST_F(WaterTest, an_eye_under_water_sees_the_albedo_of_the_floor) {
    const auto seen = [&](double albedo) {
        SeaFrame frame = flat_sea();
        frame.water = {sea::WaterType::jerlov_1b, {albedo, albedo, albedo}};
        frame.depth_m = 4;
        frame.significant_height_m = 0.1;
        camera_.z_m = -2;
        camera_.pitch_deg = -89;
        const Picture picture = render(frame, sky_, DebugView::final, {.air = false});
        const float* middle = picture.pixel(picture.width / 2, picture.height / 2);
        return glm::dvec3(middle[0], middle[1], middle[2]);
    };
    const glm::dvec3 black = seen(0), half = seen(0.4) - black, whole = seen(0.8) - black;
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(whole[c] / half[c], 2, 0.01) << c; // single precision
}

// A floor 3 m further down has lost the same daylight to an eye above the surface and to one a metre above the floor. The
// attenuation of coasts is of light that goes 1.18 of the depth.
TEST_F(WaterTest, daylight_on_the_floor_is_the_same_from_above_and_from_below) {
    struct Water {
        sea::WaterType type;
        double slant;
    };
    for (const Water water :
         {Water{sea::WaterType::jerlov_3, 1.0}, {sea::WaterType::coastal_1, 1.18}}) {
        const sea::WaterType type = water.type;
        const auto below = [&](double albedo, double depth_m) {
            SeaFrame frame = flat_sea();
            frame.water = {type, {albedo, albedo, albedo}};
            frame.depth_m = depth_m;
            frame.significant_height_m = 0.1;
            camera_.z_m = 1 - depth_m;
            camera_.pitch_deg = -89;
            const Picture picture = render(frame, sky_, DebugView::final, {.air = false});
            return static_cast<double>(picture.pixel(picture.width / 2, picture.height / 2)[1]);
        };
        const double way = way_of_daylight(sky_) / water.slant;
        const double three = below(0.8, 3) - below(0, 3), six = below(0.8, 6) - below(0, 6);
        const WaterLook near = water_look({type}, 3, 0);
        EXPECT_NEAR(six / three / std::exp(-3 * way * near.attenuation_per_m.g), 1, 0.01);
        const auto above = [&](double depth_m) {
            return straight_down({type, {1, 1, 1}}, depth_m).g -
                   straight_down({type, {0.5, 0.5, 0.5}}, depth_m).g;
        };
        const double k3 = near.floor_attenuation_per_m.g;
        const double k6 = water_look({type}, 6, 0).floor_attenuation_per_m.g;
        constexpr double up = 1.015; // of rays within 20 degrees of the vertical in air, in water
        EXPECT_NEAR(above(6) / above(3) / std::exp(-(6 * k6 - 3 * k3) * (way + up)), 1, 0.01);
    }
}

TEST_F(WaterTest, a_lagoon_over_sand_is_turquoise_and_brighter_than_the_deep) {
    for (const sea::WaterType type : {sea::WaterType::jerlov_1b, sea::WaterType::jerlov_2}) {
        const glm::dvec3 lagoon = straight_down({type}, 2), deep = straight_down({type}, deep_m);
        EXPECT_GT(lagoon.g, 2 * deep.g);
        EXPECT_GT(lagoon.g, 1.8 * lagoon.r);
        EXPECT_GT(lagoon.b, 1.5 * lagoon.r);
        EXPECT_GT(deep.b, 1.5 * deep.g) << "where there is no floor it is blue";
    }
}

TEST_F(WaterTest, a_floor_that_no_light_reaches_changes_no_bit) {
    SyntheticSea waves = gale();
    SeaFrame frame = waves.at(1'300'000);
    const Picture without = render(frame, sky_);
    frame.depth_m = 120;
    EXPECT_EQ(render(frame, sky_).rgba, without.rgba);
    frame.water.bottom_albedo = {1, 0, 0};
    EXPECT_EQ(render(frame, sky_).rgba, without.rgba);
    frame.depth_m = 3;
    EXPECT_NE(render(frame, sky_).rgba, without.rgba);
}

TEST_F(WaterTest, the_type_of_the_water_colours_the_deep_and_the_crests) {
    SyntheticSea waves = gale();
    SeaFrame frame = waves.at(1'300'000);
    camera_.pitch_deg = -30;
    const auto mean = [&](sea::WaterType type) {
        frame.water.type = type;
        const Picture picture = render(frame, sky_);
        glm::dvec3 sum(0);
        for (int y = picture.height / 2; y < picture.height; ++y)
            for (int x = 0; x < picture.width; ++x)
                for (int c = 0; c < 3; ++c)
                    sum[c] += static_cast<double>(picture.pixel(x, y)[c]);
        return sum / sum.g;
    };
    const glm::dvec3 clear = mean(sea::WaterType::jerlov_1),
                     coast = mean(sea::WaterType::coastal_3);
    EXPECT_GT(clear.b, 1.3 * coast.b);
    EXPECT_LT(clear.r, coast.r);
}

} // namespace
} // namespace seaway::client
