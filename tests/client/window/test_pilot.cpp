// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "client/window/pilot.h"
#include "sea/basics/constants.h"

namespace seaway::client {
namespace {

const Camera start{.x_m = 100, .y_m = -50, .z_m = 20, .yaw_deg = 30, .pitch_deg = -10};

double distance_m(const Camera& a, const Camera& b) {
    return glm::distance(glm::dvec3(a.x_m, a.y_m, a.z_m), glm::dvec3(b.x_m, b.y_m, b.z_m));
}

TEST(Pilot, flies_where_it_looks_at_its_speed_and_ten_times_as_fast) {
    Pilot pilot(start);
    pilot.set_speed(12);
    pilot.steer({.ahead = 1}, 0.5);
    const glm::dvec3 moved(pilot.camera().x_m - start.x_m, pilot.camera().y_m - start.y_m,
                           pilot.camera().z_m - start.z_m);
    EXPECT_NEAR(glm::distance(moved, 6.0 * start.forward()), 0, 1e-9);
    pilot = Pilot(start);
    pilot.set_speed(12);
    pilot.steer({.right = 1, .fast = true}, 0.5);
    // Bearing 30: right is bearing 120, south-east.
    EXPECT_NEAR(pilot.camera().x_m - start.x_m, 60 * std::sin(120 * sea::pi / 180), 1e-9);
    EXPECT_NEAR(pilot.camera().y_m - start.y_m, 60 * std::cos(120 * sea::pi / 180), 1e-9);
    EXPECT_EQ(pilot.camera().z_m, start.z_m);
}

TEST(Pilot, what_is_dragged_stays_below_the_mouse) {
    Pilot pilot(start);
    pilot.steer({.turn_x = -0.5, .turn_y = 0.25}, 1); // half a picture to the left
    EXPECT_NEAR(pilot.camera().yaw_deg, start.yaw_deg + start.view_deg / 2, 1e-9);
    EXPECT_NEAR(pilot.camera().pitch_deg, start.pitch_deg + start.view_deg / 4, 1e-9);
    pilot.steer({.turn_x = 3, .turn_y = 100}, 1);
    EXPECT_EQ(pilot.camera().pitch_deg, Pilot::pitch_max_deg);
    EXPECT_GE(pilot.camera().yaw_deg, 0);
    EXPECT_LT(pilot.camera().yaw_deg, 360);
}

TEST(Pilot, flies_between_fifty_metres_under_water_and_twenty_kilometres) {
    Pilot pilot(start);
    pilot.set_speed(5000);
    for (int i = 0; i < 100; ++i)
        pilot.steer({.up = 1}, 0.25);
    EXPECT_EQ(pilot.camera().z_m, Pilot::height_max_m);
    for (int i = 0; i < 100; ++i)
        pilot.steer({.up = -1, .fast = true}, 0.25);
    EXPECT_EQ(pilot.camera().z_m, -50);
    pilot.stay_above(4.0);
    EXPECT_EQ(pilot.camera().z_m, -50) << "who flies may dive";
}

TEST(Pilot, goes_round_above_the_surface) {
    Pilot pilot(start);
    pilot.choose(CameraMode::orbit);
    pilot.stay_above(44.0);
    EXPECT_DOUBLE_EQ(pilot.camera().z_m, 44.3);
    pilot.stay_above(-4.0);
    EXPECT_DOUBLE_EQ(pilot.camera().z_m, 44.3);
}

TEST(Pilot, the_wheel_changes_the_speed_within_its_range) {
    Pilot pilot(start);
    pilot.steer({.wheel = 1}, 0);
    EXPECT_NEAR(pilot.speed_mps(), 12.5, 1e-9);
    pilot.steer({.wheel = 1000}, 0);
    EXPECT_EQ(pilot.speed_mps(), Pilot::speed_max_mps);
    pilot.steer({.wheel = -1000}, 0);
    EXPECT_EQ(pilot.speed_mps(), Pilot::speed_min_mps);
}

TEST(Pilot, orbits_round_what_the_middle_of_the_picture_shows) {
    Pilot pilot(start);
    pilot.choose(CameraMode::orbit);
    EXPECT_NEAR(distance_m(pilot.camera(), start), 0, 1e-9) << "nothing jumps";
    const double away_m = start.z_m / std::sin(10 * sea::pi / 180);
    EXPECT_NEAR(pilot.distance_m(), away_m, 1e-9);
    const auto centre = [&] {
        const glm::dvec3 ahead = pilot.distance_m() * pilot.camera().forward();
        return glm::dvec3(pilot.camera().x_m, pilot.camera().y_m, pilot.camera().z_m) + ahead;
    };
    const glm::dvec3 before = centre();
    pilot.steer({.turn_x = 1.5, .turn_y = -0.3, .wheel = 2}, 1);
    EXPECT_NEAR(glm::distance(centre(), before), 0, 1e-6);
    EXPECT_NEAR(pilot.distance_m(), away_m / 1.25 / 1.25, 1e-6);
    pilot.steer({.turn_y = 10}, 1);
    EXPECT_GT(pilot.camera().z_m, 0) << "not below the sea";
}

TEST(Pilot, rides_on_a_float_that_goes_with_the_water) {
    Pilot pilot(start);
    pilot.choose(CameraMode::follow);
    const Float before = pilot.floating();
    EXPECT_LE(std::hypot(before.x_m - start.x_m, before.y_m - start.y_m), 50 + 1e-9);
    pilot.ride(-2.5, {1, -3}, 0.5);
    EXPECT_NEAR(pilot.camera().z_m, -2.5 + Pilot::eye_m, 1e-9) << "down into a trough, too";
    EXPECT_NEAR(pilot.camera().x_m, before.x_m + 0.5, 1e-9);
    EXPECT_NEAR(pilot.camera().y_m, before.y_m - 1.5, 1e-9);
    pilot.steer({.ahead = 1, .turn_x = -0.5}, 1);
    EXPECT_NEAR(pilot.camera().x_m, before.x_m + 0.5, 1e-9) << "it turns, and stays on the float";
    EXPECT_NEAR(pilot.camera().yaw_deg, start.yaw_deg + start.view_deg / 2, 1e-9);
    pilot.choose(CameraMode::fly);
    pilot.ride(5, {1, 1}, 1);
    EXPECT_LT(pilot.camera().z_m, 5) << "a float that is left carries nothing";
}

} // namespace
} // namespace seaway::client
