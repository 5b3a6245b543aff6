// SPDX-License-Identifier: Apache-2.0
#include <random>

#include <gtest/gtest.h>

#include "client/window/probe.h"
#include "sea/basics/constants.h"
#include "sea/scene/scene.h"
#include "tests/client/view/small_seas.h"
#include "tests/client/view/synthetic_sea.h"

namespace seaway::client {
namespace {

HeldPoints flat() {
    return HeldPoints({{{flat_sea().cascades[0].keyframes}, {1, 1}, {}, {}}, true});
}

TEST(Probe, a_ray_meets_a_flat_sea_where_geometry_says) {
    const HeldPoints surface = flat();
    for (const double pitch_deg : {-80.0, -30.0, -3.0}) {
        const Camera camera{
            .x_m = 500, .y_m = 20, .z_m = 12, .yaw_deg = 90, .pitch_deg = pitch_deg};
        const auto place = where_ray_meets(surface, camera, 0, 0, 0, 1);
        ASSERT_TRUE(place);
        const double level_m = 12 / std::tan(-pitch_deg * sea::pi / 180);
        // The sea falls away by d^2 / 2R, which a ray so flat meets so much later.
        const double later_m =
            level_m * level_m / (2 * earth_radius_m) / std::tan(-pitch_deg * sea::pi / 180);
        EXPECT_NEAR(place->x, 500 + level_m + later_m, 0.01 * later_m + 1e-6) << pitch_deg;
        EXPECT_NEAR(place->y, 20, 1e-6);
    }
}

TEST(Probe, sky_is_no_sea_and_the_horizon_divides_them) {
    const HeldPoints surface = flat();
    const double z_m = 2;
    const double dip_deg = horizon_dip_rad(z_m) * 180 / sea::pi;
    Camera camera{.z_m = z_m, .pitch_deg = -1.05 * dip_deg};
    EXPECT_TRUE(where_ray_meets(surface, camera, 0, 0, 0, 0.5));
    camera.pitch_deg = -0.95 * dip_deg;
    EXPECT_FALSE(where_ray_meets(surface, camera, 0, 0, 0, 0.5));
    camera.pitch_deg = 30;
    EXPECT_FALSE(where_ray_meets(surface, camera, 0, 0, 0, 0.5));
}

// Up to Snell's window and beyond it: the ray is the straight one that the mouse means. Down there is no surface.
TEST(Probe, from_below_a_ray_meets_the_surface_where_it_comes_out) {
    const HeldPoints surface = flat();
    for (const double depth_m : {0.5, 5.0, 40.0})
        for (const double pitch_deg : {80.0, 30.0, 3.0}) {
            const Camera camera{
                .x_m = 500, .y_m = 20, .z_m = -depth_m, .yaw_deg = 90, .pitch_deg = pitch_deg};
            const auto place = where_ray_meets(surface, camera, 0, 0, 0, 1);
            ASSERT_TRUE(place) << depth_m << " m, " << pitch_deg;
            const double slope = std::tan(pitch_deg * sea::pi / 180);
            const double level_m = depth_m / slope;
            // The sea falls away by d^2 / 2R, so that a ray meets it so much earlier.
            const double earlier_m = level_m * level_m / (2 * earth_radius_m) / slope;
            EXPECT_NEAR(place->x, 500 + level_m - earlier_m, 0.01 * earlier_m + 1e-6) << depth_m;
            EXPECT_NEAR(place->y, 20, 1e-6);
        }
    const Camera down{.z_m = -5, .pitch_deg = -40};
    EXPECT_FALSE(where_ray_meets(surface, down, 0, 0, 0, 1));
    EXPECT_FALSE(where_ray_meets(surface, down, 0.3, -0.2, 0, 1));
}

// On the sea itself is neither side: downwards it is met at once, upwards never.
TEST(Probe, an_eye_on_the_surface_sees_sky_above_and_the_sea_below) {
    const HeldPoints surface = flat();
    Camera camera{.x_m = 3, .y_m = 4, .z_m = 0, .pitch_deg = -30};
    const auto place = where_ray_meets(surface, camera, 0, 0, 0, 1);
    ASSERT_TRUE(place);
    EXPECT_LT(glm::distance(*place, glm::dvec2(3, 4)), 0.05);
    camera.pitch_deg = 30;
    EXPECT_FALSE(where_ray_meets(surface, camera, 0, 0, 0, 1));
}

// In a gale, from low, high and below: the place is on the ray, and the ray stays on the eye's side of the surface on
// its whole way there.
TEST(Probe, a_ray_stops_at_the_first_wave_that_it_meets) {
    const Result<sea::Scene> scene =
        sea::read_scene(SEAWAY_SOURCE_DIR "/scenes/north_sea_gale.toml");
    ASSERT_TRUE(scene) << scene.error().message;
    SyntheticSea gale(*sea::realize(*scene));
    const SeaFrame frame = gale.at(100'000'000);
    const HeldPoints surface({gale.surface(frame), true});
    const double crest_m = 2 * frame.significant_height_m;
    std::mt19937 random(4);
    std::uniform_real_distribution<double> side(-1, 1);
    int met_from_above = 0, met_from_below = 0;
    for (int i = 0; i < 120; ++i) {
        const bool dives = i % 3 == 2;
        Camera camera{.x_m = 40.0 * i, .z_m = i % 4 ? 7.0 : 60.0, .yaw_deg = 37.0 * i};
        camera.pitch_deg = i % 4 ? -3 : -20; // most of them graze crest after crest
        if (dives) {
            camera.z_m = i % 4 ? -9 : -45;
            camera.pitch_deg = -camera.pitch_deg;
        }
        const double px = side(random), py = side(random);
        const double above_m =
            camera.z_m - surface.answer({camera.x_m, camera.y_m, frame.time_us}).height_m;
        const double sign = above_m > 0 ? 1 : -1; // some that fly are below a crest
        const auto place = where_ray_meets(surface, camera, px, py, frame.time_us, crest_m);
        if (!place)
            continue;
        ++(sign > 0 ? met_from_above : met_from_below);
        const double height_m = surface.answer({place->x, place->y, frame.time_us}).height_m;
        const auto seen = on_picture(camera, place->x, place->y, height_m);
        ASSERT_TRUE(seen);
        EXPECT_NEAR(seen->x, px, 1e-6);
        EXPECT_NEAR(seen->y, py, 1e-6);
        const glm::dvec3 ray = glm::normalize(camera.ray(px, py));
        const double across = std::hypot(ray.x, ray.y);
        const double way_m = glm::distance(*place, glm::dvec2(camera.x_m, camera.y_m)) / across;
        for (double s = 0.05; s < way_m - 0.1; s += 0.05) {
            const double gap_m =
                camera.z_m + s * ray.z + std::pow(s * across, 2) / (2 * earth_radius_m) -
                surface.answer({camera.x_m + s * ray.x, camera.y_m + s * ray.y, frame.time_us})
                    .height_m;
            ASSERT_GT(sign * gap_m, -0.02) << "ray " << i << ", " << s << " of " << way_m;
        }
    }
    EXPECT_GT(met_from_above, 30);
    EXPECT_GT(met_from_below, 20);
}

// However seldom frames are: two keyframes a cascade hold what lies between them.
TEST(Probe, keeps_a_minute_of_heights_in_even_steps_and_begins_anew_where_time_runs_back) {
    SyntheticSea sea(one_wave(1.0, 100, 2));
    Probe probe({12, 34});
    const auto read = [&](sea::TimeUs time_us) {
        const SeaFrame frame = sea.at(time_us);
        probe.read(HeldPoints({sea.surface(frame), true}), time_us);
        return sea.surface(frame).answer({12, 34, time_us}).height_m;
    };
    double last_m = 0;
    for (sea::TimeUs t = 1'000'000; t <= 91'000'000; t += 250'000)
        last_m = read(t);
    ASSERT_TRUE(probe.answer());
    EXPECT_EQ(probe.time_us(), 91'000'000);
    EXPECT_EQ(probe.answer()->height_m, last_m);
    EXPECT_EQ(probe.trace().front().time_us, 31'000'000);
    EXPECT_EQ(probe.trace().back().time_us, 91'000'000);
    EXPECT_GT(probe.trace().size(), 500u)
        << "of 601, but for those before the keyframes of a frame";
    for (const Probe::Sample& sample : probe.trace()) {
        EXPECT_EQ(sample.time_us % Probe::step_us, 0);
        const SeaFrame frame = sea.at(sample.time_us);
        const sea::Surface truth = sea.surface(frame);
        EXPECT_NEAR(static_cast<double>(sample.height_m),
                    truth.answer({12, 34, sample.time_us}).height_m, 1e-6);
    }
    const SeaFrame late = sea.at(95'000'000);
    probe.read(HeldPoints({sea.surface(late), false}), 95'000'000);
    EXPECT_EQ(probe.time_us(), 91'000'000) << "what is not covered has no bound, and is not shown";
    read(5'060'000); // another server
    EXPECT_EQ(probe.time_us(), 5'060'000);
    ASSERT_LE(probe.trace().size(), 1u);
}

} // namespace
} // namespace seaway::client
