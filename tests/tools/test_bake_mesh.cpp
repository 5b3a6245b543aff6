// SPDX-License-Identifier: Apache-2.0
// seaway-bake's meshes, and the foam of the summed sea.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sea/surface/inverse.h"
#include "tests/tools/bake_fixture.h"

namespace seaway {
namespace {

using namespace tests_of_bake;
using testing::ExrFile;
using tests::Output;

struct PlyVertex {
    float position[3];
    float normal[3];
    float texture[2];
};

/// Vertices and faces of a mesh that --mesh ply wrote.
struct Ply {
    std::vector<PlyVertex> vertices;
    std::vector<std::array<std::int32_t, 4>> faces;

    explicit Ply(const std::string& path) {
        std::ifstream file(path, std::ios::binary);
        std::string line;
        std::size_t vertex_count = 0, face_count = 0;
        while (std::getline(file, line) && line != "end_header") {
            if (line.starts_with("element vertex "))
                vertex_count = std::stoul(line.substr(15));
            if (line.starts_with("element face "))
                face_count = std::stoul(line.substr(13));
        }
        vertices.resize(vertex_count);
        file.read(reinterpret_cast<char*>(vertices.data()),
                  static_cast<std::streamsize>(vertex_count * sizeof(PlyVertex)));
        faces.resize(face_count);
        for (auto& face : faces) {
            EXPECT_EQ(file.get(), 4);
            file.read(reinterpret_cast<char*>(face.data()), sizeof(face));
        }
        EXPECT_TRUE(file.good());
        EXPECT_EQ(file.get(), std::char_traits<char>::eof()) << "nothing behind the faces";
    }
};

TEST(Bake, mesh_lies_on_the_surface_and_repeats_without_a_gap) {
    const std::string out = tests::folder().file("mesh");
    ASSERT_EQ(run_bake("--out " + out +
                       " --frames 1 --fps 24 --start 7 --size 64 --mesh ply --fields height")
                  .status,
              0);
    const Ply mesh(out + "/cascade0.00000.ply");
    ASSERT_EQ(mesh.vertices.size(), 65u * 65u);
    ASSERT_EQ(mesh.faces.size(), 64u * 64u);
    sea::Realization one = sea::realize(small_scene()).value();
    one.cascades.resize(1);
    const sea::DirectSum sum(std::make_shared<const sea::Realization>(one));
    const sea::DirectSum::Moment now = sum.at_time(7'000'000);
    for (int i = 0; i < 200; ++i) {
        const int x = (i * 37) % 65, y = (i * 53 + i / 7) % 65;
        const PlyVertex& v = mesh.vertices[static_cast<std::size_t>(y * 65 + x)];
        const sea::LagrangianPoint p = now.at(x * 401.0 / 64, y * 401.0 / 64);
        // Maps are within 1e-5 Hs; positions are floats of up to 401 m (3e-5 m).
        EXPECT_NEAR(v.position[0], x * 401.0 / 64 + 1.2 * p.displacement_x, 2e-4);
        EXPECT_NEAR(v.position[1], y * 401.0 / 64 + 0.8 * p.displacement_y, 2e-4);
        EXPECT_NEAR(v.position[2], p.height, 2e-4);
        // The middle of the pixel of the map beside it; a repeated texture begins anew on the seam.
        EXPECT_EQ(v.texture[0], (static_cast<float>(x) + 0.5f) / 64);
        EXPECT_EQ(v.texture[1], (static_cast<float>(y) + 0.5f) / 64);
        const sea::QueryPoint point{v.position[0], v.position[1], 7'000'000};
        const sea::Answer there = sea::surface_at(point, {{1.2, 0.8}, 1e-9, {}}, now);
        for (int axis = 0; axis < 3; ++axis) // the same surface as a query finds
            EXPECT_NEAR(v.normal[axis], there.normal[axis], 2e-3) << x << ", " << y;
    }
    for (std::size_t i = 0; i < 65; ++i) { // the seam
        const PlyVertex &west = mesh.vertices[i * 65], &east = mesh.vertices[i * 65 + 64];
        EXPECT_NEAR(east.position[0] - west.position[0], 401.0, 1e-4);
        EXPECT_EQ(east.position[2], west.position[2]);
    }
    for (const auto& face : mesh.faces) { // anticlockwise from above, in undisplaced order
        ASSERT_EQ(face[1], face[0] + 1);
        ASSERT_EQ(face[2], face[0] + 66);
        ASSERT_EQ(face[3], face[0] + 65);
    }
}

/// What stands in a mesh that --mesh obj wrote.
struct Obj {
    std::vector<std::array<double, 3>> points, normals;
    std::vector<std::array<double, 2>> textures;
    std::vector<std::string> faces;
};

Obj read_obj(const std::string& path) {
    Obj obj;
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        std::string kind;
        words >> kind;
        if (kind == "v") {
            std::array<double, 3> point{};
            words >> point[0] >> point[1] >> point[2];
            obj.points.push_back(point);
        }
        if (kind == "vn") {
            std::array<double, 3> normal{};
            words >> normal[0] >> normal[1] >> normal[2];
            obj.normals.push_back(normal);
        }
        if (kind == "vt") {
            std::array<double, 2> texture{};
            words >> texture[0] >> texture[1];
            obj.textures.push_back(texture);
        }
        if (kind == "f")
            obj.faces.push_back(line);
    }
    return obj;
}

TEST(Bake, obj_holds_the_mesh_of_the_summed_sea_with_y_up) {
    const std::string out = tests::folder().file("obj");
    ASSERT_EQ(run_bake("--out " + out +
                       " --frames 1 --fps 24 --start 7 --size 64 --summed --mesh obj --up y")
                  .status,
              0);
    const auto& [points, normals, textures, faces] = read_obj(out + "/sea.00000.obj");
    ASSERT_EQ(points.size(), 64u * 64u); // 401 and 83 m do not repeat together: no seam is closed
    ASSERT_EQ(normals.size(), points.size());
    ASSERT_EQ(textures.size(), points.size());
    ASSERT_EQ(faces.size(), 63u * 63u);
    // Place, texture and normal of a corner have the same number, from one; anticlockwise from above.
    EXPECT_EQ(faces[0], "f 1/1/1 2/2/2 66/66/66 65/65/65");
    EXPECT_EQ(faces[63], "f 65/65/65 66/66/66 130/130/130 129/129/129") << "the second row";
    const sea::DirectSum sum = small_sea();
    const sea::DirectSum::Moment now = sum.at_time(7'000'000);
    for (int i = 0; i < 100; ++i) {
        const int x = (i * 37) % 64, y = (i * 53 + i / 7) % 64;
        const sea::LagrangianPoint p = now.at(x * 401.0 / 64, y * 401.0 / 64);
        const auto& point = points[static_cast<std::size_t>(y * 64 + x)];
        EXPECT_NEAR(point[0], x * 401.0 / 64 + 1.2 * p.displacement_x, 0.02); // splines, as above
        EXPECT_NEAR(point[1], p.height, 0.02);
        EXPECT_NEAR(point[2], -(y * 401.0 / 64 + 0.8 * p.displacement_y), 0.02);
        const auto& texture = textures[static_cast<std::size_t>(y * 64 + x)];
        EXPECT_NEAR(texture[0], (x + 0.5) / 64, 1e-6);
        EXPECT_NEAR(texture[1], (y + 0.5) / 64, 1e-6);
        // d/dX x d/dY of (east, north, up), told as (east, up, south). Where derivatives count, splines
        // miss a few hundredths.
        const double a = 1 + 1.2 * p.strain_xx, d = 1 + 0.8 * p.strain_yy;
        const double b = 1.2 * p.strain_xy, c = 0.8 * p.strain_xy;
        const double east = c * p.slope_y - d * p.slope_x, north = b * p.slope_x - a * p.slope_y;
        const double up = a * d - b * c, length = std::hypot(east, north, up);
        const auto& normal = normals[static_cast<std::size_t>(y * 64 + x)];
        EXPECT_NEAR(normal[0], east / length, 0.04);
        EXPECT_NEAR(normal[1], up / length, 0.04);
        EXPECT_NEAR(normal[2], -north / length, 0.04);
    }
}

// docs/foam.md: the mean times (2 prod (1 + ratio)/2 - 1), 0 .. 1.
TEST(Bake, foam_of_the_summed_sea_is_what_the_ratios_of_all_tiles_make) {
    const auto bake = [](double second_m, const std::string& how) {
        std::string text = scene_text;
        text.replace(text.find("83.0"), 4, std::to_string(second_m));
        const std::string scene = tests::folder().write("foam.toml", text);
        const std::string out = tests::folder().file(how.empty() ? "foam_apart" : "foam_together");
        const Output ran =
            tests::run_program("seaway-bake", scene + " --out " + out +
                                                  " --frames 1 --fps 8 --start 31 --size 64 "
                                                  "--fields foam" +
                                                  how);
        EXPECT_EQ(ran.status, 0) << ran.err;
        return out;
    };
    // Every point of the long tile is one of a tile of half the length.
    const std::string apart = bake(200.5, ""), together = bake(200.5, " --summed");
    ExrFile one(apart + "/cascade0.00000.exr"), other(apart + "/cascade1.00000.exr");
    ExrFile sum(together + "/sea.00000.exr");
    EXPECT_EQ(sum.text("seaway.repeats"), "yes");
    const double mean = sum.number("seaway.foam_mean");
    EXPECT_EQ(mean, one.number("seaway.foam_mean"));
    const std::vector<float> a = one.values("foam"), b = other.values("foam"),
                             foam = sum.values("foam");
    double largest = 0;
    for (std::size_t y = 0; y < 64; ++y)
        for (std::size_t x = 0; x < 64; ++x) {
            const double first = a[y * 64 + x], second = b[2 * y % 64 * 64 + 2 * x % 64];
            const double coverage = mean * (0.5 * (1 + first) * (1 + second) - 1);
            // A spline gives its own samples back to rounding, which products and tall peaks multiply.
            ASSERT_NEAR(foam[y * 64 + x], std::clamp(coverage, 0.0, 1.0),
                        1e-4 * (1 + std::abs(coverage)))
                << x << ", " << y;
            largest = std::max(largest, coverage);
        }
    EXPECT_GT(largest, 2 * mean);
    // Between its samples a spline may dip below zero beside a crest: less foam than none.
    ExrFile long_tile(bake(83, "") + "/cascade0.00000.exr");
    ExrFile uneven(bake(83, " --summed") + "/sea.00000.exr");
    const std::vector<float> ratio = long_tile.values("foam"), all = uneven.values("foam");
    for (std::size_t i = 0; i < all.size(); ++i)
        ASSERT_GE(all[i], std::clamp(uneven.number("seaway.foam_mean") * (0.5 * (1 + ratio[i]) - 1),
                                     0.0, 1.0) *
                              0.999)
            << "at least what the first tile alone makes where the second has none";
}

} // namespace
} // namespace seaway
