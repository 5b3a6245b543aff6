// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/view/camera_path.h"
#include "sea/basics/constants.h"

namespace seaway::client {
namespace {

using sea::pi;
using testing::HasSubstr;

CameraPath path_of(const std::string& text) {
    const Result<CameraPath> path = CameraPath::parse(text, "path.csv", {.view_deg = 70});
    EXPECT_TRUE(path) << path.error().message;
    return path ? *path : CameraPath(Camera{});
}

std::string error_of(const std::string& text) {
    const Result<CameraPath> path = CameraPath::parse(text, "path.csv", {});
    return path ? "none" : path.error().message;
}

TEST(CameraPath, goes_through_every_moment_and_stands_still_before_and_after) {
    const CameraPath path = path_of("t_s,x_m,y_m,z_m,yaw_deg,pitch_deg\n"
                                    "1,0,-5,10,30,-3\n2,100,-7,12,50,-4\n4,120,2,300,40,-80\n");
    for (const auto& [t, x, y, z, yaw, pitch] : {std::tuple(0.0, 0.0, -5.0, 10.0, 30.0, -3.0),
                                                 {1.0, 0.0, -5.0, 10.0, 30.0, -3.0},
                                                 {2.0, 100.0, -7.0, 12.0, 50.0, -4.0},
                                                 {4.0, 120.0, 2.0, 300.0, 40.0, -80.0},
                                                 {9.0, 120.0, 2.0, 300.0, 40.0, -80.0}}) {
        const Camera camera = path.at(t);
        EXPECT_NEAR(camera.x_m, x, 1e-9) << t;
        EXPECT_NEAR(camera.y_m, y, 1e-9) << t;
        EXPECT_NEAR(camera.z_m, z, 1e-9) << t;
        EXPECT_NEAR(camera.yaw_deg, yaw, 1e-9) << t;
        EXPECT_NEAR(camera.pitch_deg, pitch, 1e-9) << t;
        EXPECT_EQ(camera.view_deg, 70) << "what no column says is the camera's";
    }
}

// A straight run at one speed stays one: cubics with the slopes of their neighbours are exact for lines. And no jump of speed
// at a moment.
TEST(CameraPath, is_even_on_a_line_and_smooth_at_its_moments) {
    const std::string head = "t_s,x_m,y_m,z_m,yaw_deg,pitch_deg\n";
    const CameraPath line = path_of(head + "0,0,0,10,0,0\n1,10,5,10,0,0\n3,30,15,10,0,0\n");
    for (const double t : {0.25, 0.9, 1.5, 2.2})
        EXPECT_NEAR(line.at(t).x_m, 10 * t, 1e-9);
    const CameraPath bent =
        path_of(head + "0,0,0,10,0,0\n1,10,0,10,0,0\n2,5,0,20,0,0\n3,0,0,10,0,0\n");
    for (const double t : {1.0, 2.0}) {
        const double step = 1e-4;
        const double before = (bent.at(t).x_m - bent.at(t - step).x_m) / step;
        const double after = (bent.at(t + step).x_m - bent.at(t).x_m) / step;
        EXPECT_NEAR(before, after, 0.02) << "curvature of some 50 m/s2 over a step";
    }
    const double slope = (bent.at(1.0001).x_m - bent.at(0.9999).x_m) / 0.0002;
    EXPECT_NEAR(slope, (5.0 - 0.0) / 2, 0.01) << "as from its neighbour before to the one after";
}

TEST(CameraPath, turns_the_shorter_way_and_never_dips_below_its_moments) {
    const std::string head = "t_s,x_m,y_m,z_m,yaw_deg,pitch_deg\n";
    const CameraPath path =
        path_of(head + "0,0,0,100,350,0\n1,0,0,2,10,0\n2,0,0,2,20,0\n3,0,0,90,20,0\n");
    EXPECT_NEAR(std::remainder(path.at(0.5).yaw_deg, 360.0), 0, 3)
        << "through north, not through south";
    for (double t = 0; t < 3; t += 0.01)
        EXPECT_GE(path.at(t).z_m, 2 - 1e-9) << t;
}

TEST(CameraPath, turns_on_after_a_hundred_turns) {
    std::string text = "t_s,x_m,y_m,z_m,yaw_deg,pitch_deg\n";
    for (int row = 0; row < 500; ++row)
        text += std::to_string(row) + ",0,0,10," + std::to_string(row * 90 % 360) + ",0\n";
    const CameraPath path = path_of(text);
    EXPECT_NEAR(std::remainder(path.at(50.5).yaw_deg - 45, 360.0), 180, 1e-6);
    EXPECT_NEAR(std::remainder(path.at(450.5).yaw_deg - path.at(50.5).yaw_deg, 360.0), 0, 1e-6);
}

TEST(CameraPath, a_turntable_looks_at_one_point_from_all_sides) {
    const Camera base{.x_m = 40, .y_m = -10, .z_m = 30, .yaw_deg = 25, .pitch_deg = -45};
    const CameraPath path = CameraPath::turntable(base, 10);
    const double azimuth = base.azimuth_rad();
    const double east = 40 + 30 * std::cos(azimuth), north = -10 + 30 * std::sin(azimuth);
    for (const double t : {0.0, 1.3, 5.0, 7.77, 10.0}) {
        const Camera camera = path.at(t);
        EXPECT_NEAR(std::hypot(camera.x_m - east, camera.y_m - north), 30, 0.01) << t;
        EXPECT_NEAR(camera.pitch_deg, -45, 1e-9);
        const double towards = std::atan2(north - camera.y_m, east - camera.x_m);
        EXPECT_NEAR(std::remainder(towards - camera.azimuth_rad(), 2 * pi), 0, 1e-3) << t;
        EXPECT_NEAR(camera.yaw_deg, 25 + 36 * t, 1e-9) << "evenly";
    }
    const Camera level{.pitch_deg = 3};
    EXPECT_NEAR(CameraPath::turntable(level, 4).at(2).y_m, 200, 0.1)
        << "around a point 100 m ahead, north: after half of it from the other side";
}

// Differences of times are divided by: what overflows or vanishes there is a camera that is nowhere.
TEST(CameraPath, what_is_taken_is_a_camera_in_its_ranges_at_every_time) {
    const std::string head = "t_s,x_m,y_m,z_m,yaw_deg,pitch_deg\n";
    for (const char* rows : {"-1e12,1e7,1e7,20000,36000,89\n1e12,-1e7,-1e7,-50,-36000,-89\n",
                             "-1,0,0,10,0,0\n0,1e7,0,20000,170,89\n1e-6,-1e7,0,-50,0,-89\n",
                             "0,0,0,10,0,0\n0.000001,1,0,10,0,0\n0.000002,2,0,10,0,0\n"}) {
        const CameraPath path = path_of(head + rows);
        for (const double t_s : {-1e300, -1e12, -0.5, 0.0, 5e-7, 1e-6, 1e12, 1e300}) {
            const Camera camera = path.at(t_s);
            EXPECT_TRUE(std::abs(camera.x_m) <= 1e7 && std::abs(camera.y_m) <= 1e7) << t_s;
            EXPECT_TRUE(camera.z_m >= -50 && camera.z_m <= 20000) << t_s;
            EXPECT_TRUE(std::isfinite(camera.yaw_deg) && std::abs(camera.pitch_deg) <= 89) << t_s;
        }
    }
    EXPECT_NE(error_of(head + "-1,0,0,10,0,0\n0,1,0,10,0,0\n3e-308,2,0,10,0,0\n"), "none");
}

TEST(CameraPath, says_which_row_is_wrong_and_why) {
    const std::string head = "t_s,x_m,y_m,z_m,yaw_deg,pitch_deg\n";
    EXPECT_THAT(error_of("t_s,x_m,y_m,yaw_deg,pitch_deg\n0,0,0,0,0\n"),
                HasSubstr("path.csv: no column z_m"));
    EXPECT_THAT(error_of("x_m,y_m,z_m,yaw_deg,pitch_deg\n0,0,5,0,0\n"), HasSubstr("no column t_s"));
    EXPECT_THAT(error_of(head + "0,0,0,10,0,0\n0,1,0,10,0,0\n"),
                HasSubstr("path.csv:3: t_s 0 does not lie after the row before, 0"));
    EXPECT_THAT(
        error_of(head + "0,0,0,10,0,0\n1e-7,1,0,10,0,0\n"),
        HasSubstr("path.csv:3: t_s 1e-07 is 1e-07 s after the row before; at least 1e-06 s"));
    EXPECT_THAT(error_of(head + "-1e308,0,0,10,0,0\n1e308,1,0,10,0,0\n"),
                HasSubstr("path.csv:2: t_s -1e+308: -1e+12 .. 1e+12"));
    EXPECT_THAT(error_of(head + "0,0,0,10,0,0\n1.1e12,1,0,10,0,0\n"),
                HasSubstr("path.csv:3: t_s 1.1e+12: -1e+12 .. 1e+12"));
    EXPECT_THAT(error_of(head + "0,0,0,-51,0,0\n"), HasSubstr("path.csv:2: z_m -51: -50 .. 20000"));
    EXPECT_THAT(error_of(head + "0,0,0,20001,0,0\n"), HasSubstr("z_m 20001"));
    EXPECT_EQ(error_of(head + "0,1e7,-1e7,20000,0,89\n"), "none");
    EXPECT_THAT(error_of(head + "0,0,0,5,0,89.5\n"), HasSubstr("pitch_deg 89.5: -89 .. 89"));
    EXPECT_THAT(error_of("t_s,x_m,y_m,z_m,yaw_deg,pitch_deg,fov_deg\n0,0,0,5,0,0,151\n"),
                HasSubstr("fov_deg 151: 1 .. 150"));
    EXPECT_NE(error_of(""), "none");
}

} // namespace
} // namespace seaway::client
