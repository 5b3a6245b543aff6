// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "client/view/sea/mesh.h"
#include "sea/basics/constants.h"

namespace seaway::client {
namespace {

using sea::pi;

/// Picture row of a local point, 0 .. height.
double row_of(const Camera& camera, const glm::dvec3& local) {
    const glm::dvec4 clip = camera.clip_from_local() * glm::dvec4(local, 1);
    return (clip.y / clip.w * 0.5 + 0.5) * camera.height;
}

TEST(Camera, yaw_is_a_bearing_and_pitch_is_upwards) {
    Camera camera;
    camera.pitch_deg = 0;
    camera.yaw_deg = 0;
    EXPECT_NEAR(camera.forward().y, 1, 1e-12) << "north";
    camera.yaw_deg = 90;
    EXPECT_NEAR(camera.forward().x, 1, 1e-12) << "east";
    camera.pitch_deg = 30;
    EXPECT_NEAR(camera.forward().z, 0.5, 1e-12);
}

TEST(Camera, a_ray_through_the_picture_is_where_its_points_are_drawn) {
    Camera camera;
    camera.yaw_deg = 200;
    camera.pitch_deg = -17;
    for (const double x : {-0.9, 0.0, 0.4})
        for (const double y : {-0.8, 0.1, 0.9}) {
            const glm::dvec3 point = glm::dvec3(0, 0, camera.z_m) + 37.0 * camera.ray(x, y);
            const glm::dvec4 clip = camera.clip_from_local() * glm::dvec4(point, 1);
            EXPECT_NEAR(clip.x / clip.w, x, 1e-9);
            EXPECT_NEAR(clip.y / clip.w, y, 1e-9);
            EXPECT_NEAR(clip.z / clip.w, 0.1 / 37.0, 1e-9) << "reversed depth: near / distance";
        }
}

TEST(Camera, the_horizon_lies_its_dip_below_the_level) {
    Camera camera;
    camera.z_m = 100;
    camera.pitch_deg = 0;
    // Tangent point of the sphere; the mesh bends as z = -r^2 / 2R.
    const double r = std::sqrt(2 * earth_radius_m * camera.z_m);
    const double row = row_of(camera, {0, r, -r * r / (2 * earth_radius_m)});
    EXPECT_NEAR((row - camera.height / 2.0) * camera.pixel_rad(), horizon_dip_rad(camera.z_m), 1e-6)
        << "5.6 mrad; the parabola and the circle differ by (r/R)^2 of that";
}

/// Waves of 6 m on a grid of 0.2 m.
SeaFrame high_sea() {
    SeaFrame sea;
    sea.cascades.push_back({{51.2, 256}, {0, 1}, {}});
    sea.significant_height_m = 6;
    sea.reach_m = 6;
    return sea;
}

TEST(Mesh, covers_every_place_that_the_picture_can_show) {
    const SeaFrame sea = high_sea();
    for (const double pitch : {-89.0, -50.0, -20.0, -5.0, 10.0})
        for (const double yaw : {0.0, 123.0, 300.0}) {
            Camera camera;
            camera.pitch_deg = pitch;
            camera.yaw_deg = yaw;
            const Mesh mesh = build_mesh(camera, sea, 2.5);
            ASSERT_LT(mesh.rows_m.size(), static_cast<std::size_t>(Mesh::rows_max))
                << "the rows reach the horizon before they run out";
            for (double x = -1; x <= 1; x += 0.25)
                for (double y = -1; y <= 1; y += 0.25) {
                    const glm::dvec3 ray = camera.ray(x, y);
                    if (ray.z > -1e-3)
                        continue;
                    const glm::dvec2 from_apex =
                        glm::dvec2(ray) * (camera.z_m / -ray.z) - mesh.apex_m;
                    const double r = glm::length(from_apex);
                    EXPECT_GE(r, static_cast<double>(mesh.rows_m.front()) - 0.6);
                    EXPECT_LE(r, static_cast<double>(mesh.rows_m.back()));
                    double turn = std::atan2(from_apex.y, from_apex.x) - mesh.azimuth_rad;
                    turn -= 2 * pi * std::floor(turn / (2 * pi) + 1e-9);
                    EXPECT_LE(turn, mesh.step_rad * (mesh.columns - 1) + 1e-6)
                        << "pitch " << pitch << " yaw " << yaw << " at " << x << ", " << y;
                }
        }
}

// As of a path that keeps turning. Naive: its bearing becomes a float, of which a column is less than the rounding.
TEST(Mesh, is_the_same_after_a_million_turns) {
    const SeaFrame sea = high_sea();
    Camera camera, turned;
    camera.yaw_deg = 123;
    turned.yaw_deg = 123 + 360e6;
    const Mesh one = build_mesh(camera, sea, 2.5, false),
               other = build_mesh(turned, sea, 2.5, false);
    ASSERT_EQ(one.columns, other.columns);
    EXPECT_NEAR(one.azimuth_rad, other.azimuth_rad, 1e-6);
}

TEST(Mesh, rows_grow_and_end_beyond_the_horizon) {
    const SeaFrame sea = high_sea();
    Camera camera;
    const Mesh mesh = build_mesh(camera, sea, 2.5);
    for (std::size_t i = 1; i < mesh.rows_m.size(); ++i)
        ASSERT_GT(mesh.rows_m[i], mesh.rows_m[i - 1]);
    // Crests of 9 m show from beyond the horizon of the mean sea.
    EXPECT_GT(static_cast<double>(mesh.rows_m.back()),
              std::sqrt(2 * earth_radius_m * camera.z_m) + std::sqrt(2 * earth_radius_m * 9));
}

// Looking straight down there is no hole in the middle, whatever the waves do to it.
TEST(Mesh, is_closed_below_the_camera) {
    Camera camera;
    camera.pitch_deg = -89;
    for (const double z_m : {1.0, 4.0, 300.0, 20e3}) {
        camera.z_m = z_m;
        const Mesh mesh = build_mesh(camera, high_sea(), 2.5);
        EXPECT_EQ(mesh.rows_m.front(), 0) << z_m;
        EXPECT_EQ(mesh.apex_m, glm::dvec2(0)) << z_m;
        EXPECT_NEAR(mesh.step_rad * (mesh.columns - 1), 2 * pi, 1e-9) << z_m;
        EXPECT_LE(mesh.vertices(), Mesh::vertices_max);
        // Only as far as the picture goes: 31 degrees sideways.
        if (z_m == 300) {
            EXPECT_LT(mesh.rows_m.back(), 300);
        }
    }
}

TEST(Mesh, there_is_none_where_the_picture_shows_sky_alone) {
    Camera camera;
    camera.pitch_deg = 60;
    camera.z_m = 30;
    EXPECT_EQ(build_mesh(camera, high_sea(), 2.5).columns, 0);
    camera.z_m = 3; // below the crests of 9 m
    EXPECT_GT(build_mesh(camera, high_sea(), 2.5).columns, 0);
}

TEST(Mesh, is_of_the_camera_and_the_sea_state_alone) {
    SeaFrame now = high_sea(), later = high_sea();
    later.time_us = 987'654'321;
    const Mesh first = build_mesh({}, now, 5), second = build_mesh({}, later, 5);
    EXPECT_EQ(first.rows_m, second.rows_m);
    EXPECT_EQ(first.columns, second.columns);
}

// A picture of 16384 pixels has no more vertices than memory is set aside for.
TEST(Mesh, cells_grow_where_there_were_too_many) {
    Camera camera;
    camera.width = camera.height = 16384;
    for (const double pitch_deg : {-89.0, -30.0, 0.0}) {
        camera.pitch_deg = pitch_deg;
        const Mesh mesh = build_mesh(camera, high_sea(), 1.5);
        EXPECT_LE(mesh.vertices(), Mesh::vertices_max);
        EXPECT_GT(mesh.vertices(), Mesh::vertices_max / 8) << "as fine as it may be";
    }
}

// The last strip of a mesh is shorter: of each block of columns the first rows are drawn.
TEST(Mesh, ranges_of_a_shorter_strip_hold_its_rows_and_no_others) {
    const int columns = 40, rows = 16;
    const std::vector<std::uint32_t> all = strip_indices(columns, rows);
    for (const int used : {1, 7, 16}) {
        std::vector<std::uint32_t> drawn;
        for (const IndexRange& range : strip_ranges(columns, rows, used))
            drawn.insert(drawn.end(), all.begin() + range.first,
                         all.begin() + range.first + range.count);
        std::vector<std::uint32_t> expected = strip_indices(columns, used);
        std::sort(drawn.begin(), drawn.end());
        std::sort(expected.begin(), expected.end());
        EXPECT_EQ(drawn, expected) << used;
    }
}

TEST(Mesh, a_strip_has_two_triangles_a_cell_and_no_vertex_beyond_its_rows) {
    const std::vector<std::uint32_t> indices = strip_indices(5, 3);
    EXPECT_EQ(indices.size(), 4u * 3 * 6);
    for (const std::uint32_t index : indices)
        EXPECT_LT(index, 5u * 4);
}

} // namespace
} // namespace seaway::client
