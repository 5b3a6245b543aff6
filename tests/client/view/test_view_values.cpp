// SPDX-License-Identifier: Apache-2.0
// What shaders are told, and the maps they look it up in: every value against one worked out here, in a
// sea where east is not north and no two cascades are alike.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "client/view/renderer.h"
#include "client/view/sea_maps.h"
#include "tests/client/view/small_seas.h"
#include "tests/client/view/synthetic_sea.h"

namespace seaway::client {
namespace {

constexpr double two_pi = 2 * std::numbers::pi;

/// An oblique wave in a tile of 90 m and another in one of 31 m, which is coarser.
sea::Realization crossing_waves() {
    sea::Realization sea = one_wave(0.7, 90, 3, -2);
    sea.cascades[0].band = {0.05, 0.4};
    sea::Realization second = one_wave(0.2, 31, -1, 4);
    second.cascades[0].band = {0.4, 2.9};
    sea.cascades.push_back(std::move(second.cascades[0]));
    sea.choppiness = {0.9, 0.4};
    return sea;
}

double fraction(double value) {
    return value - std::floor(value);
}

struct Shown {
    SeaFrame frame;
    SeaMaps maps;
    Camera camera{.x_m = -1234.5,
                  .y_m = 777.25,
                  .z_m = 23,
                  .yaw_deg = 130,
                  .pitch_deg = -12,
                  .view_deg = 50,
                  .width = 320,
                  .height = 180};
    Sky sky{sun_direction(16.5)};
    Mesh mesh;
    RenderOptions options{.cell_pixels = 3, .visibility_m = 12e3};

    Shown() {
        SyntheticSea sea(crossing_waves());
        frame = sea.at(1'234'567);
        frame.significant_height_m = 2.1;
        frame.foam_threshold = 0.37;
        frame.foam_mean = 0.021;
        maps = build_maps(frame);
        mesh = build_mesh(camera, maps.statistics, 0.3, 3);
    }
    shaders::ViewValues values(const DebugChoice& debug = {}) const {
        return view_values(frame, maps, camera, sky, mesh, options, debug);
    }
};

TEST(ViewValues, every_value_is_the_one_of_its_name) {
    const Shown shown;
    const shaders::ViewValues v = shown.values({DebugView::cascade, 1});
    const auto expect = [](double value, double expected, const char* what) {
        EXPECT_NEAR(value, expected, 1e-6 * std::abs(expected) + 1e-9) << what; // floats
    };
    expect(v.camera_m.x, 0, "the local frame moves with the camera");
    expect(v.camera_m.z, 23, "camera");
    expect(v.pixel_rad, 2 * std::tan(25 * two_pi / 360) / 320, "pixel");
    const glm::dvec3 sun = sun_direction(16.5);
    expect(v.sun_direction.x, sun.x, "sun");
    expect(v.sun_direction.y, sun.y, "sun");
    expect(v.sun_direction.z, sun.z, "sun");
    expect(v.sun_disk_cosine, std::cos(0.00465), "disk");
    // A cone of that half angle.
    EXPECT_NEAR(v.sun_disk_per_sr * (two_pi * (1 - std::cos(0.00465))), 1, 1e-5);
    expect(v.sun_irradiance_klx.x, shown.sky.sun_irradiance().r, "red of the sun");
    expect(v.sun_irradiance_klx.z, shown.sky.sun_irradiance().b, "blue of the sun");
    expect(v.sky_irradiance_klx.x, shown.sky.sky_irradiance().r, "red of the sky");
    expect(v.sky_irradiance_klx.z, shown.sky.sky_irradiance().b, "blue of the sky");
    EXPECT_NEAR(std::exp(-v.extinction_per_m * 12e3), 0.02, 1e-6) << "2 % of contrast are left";
    EXPECT_LT(v.water_reflectance.x, v.water_reflectance.y) << "red is swallowed first";
    expect(v.significant_height_m, shown.maps.statistics.significant_height_m, "height");
    EXPECT_GT(std::abs(shown.maps.statistics.significant_height_m - 2.1), 0.01) << "told apart";
    expect(v.mesh_apex_m.x, shown.mesh.apex_m.x, "apex");
    expect(v.mesh_apex_m.y, shown.mesh.apex_m.y, "apex");
    expect(v.mesh_azimuth_rad, shown.mesh.azimuth_rad, "azimuth");
    expect(v.mesh_step_rad, shown.mesh.step_rad, "step");
    EXPECT_EQ(v.mesh_columns, shown.mesh.columns);
    EXPECT_EQ(v.mesh_rows, static_cast<int>(shown.mesh.rows_m.size()));
    expect(v.choppiness.x, 0.9, "choppiness");
    expect(v.choppiness.y, 0.4, "choppiness");
    expect(v.curvature_per_m, 1 / (2 * 6371e3), "curvature");
    expect(v.slope_variance, shown.maps.statistics.slope_variance, "slopes");
    expect(v.foam_noise_origin_m.x, fraction(-1234.5 / 256) * 256, "noise");
    expect(v.foam_noise_origin_m.y, fraction(777.25 / 256) * 256, "noise");
    expect(v.foam_threshold, 0.37, "threshold");
    expect(v.foam_mean, 0.021, "foam");
    // Cells of 0.6 of the wave height of the sea state, 1.26 m: the nearest power of two is 1 m.
    EXPECT_EQ(v.foam_level, 0);
    EXPECT_EQ(v.what, shaders::view_cascade);
    EXPECT_EQ(v.what_cascade, 1);
    EXPECT_EQ(shown.values({DebugView::cascade, 5}).what_cascade, 1) << "there are two";
    EXPECT_EQ(v.cascades, 2);
    for (std::size_t c = 0; c < 2; ++c) {
        const double length_m = c == 0 ? 90 : 31;
        // A node is the middle of a texel.
        const double half_texel = 0.5 / shown.maps.nodes;
        expect(v.cascade[c].origin.x, fraction(-1234.5 / length_m) + half_texel, "origin");
        expect(v.cascade[c].origin.y, fraction(777.25 / length_m) + half_texel, "origin");
        expect(v.cascade[c].maps_per_m, 1 / length_m, "maps");
        expect(v.cascade[c].texel_m, length_m / shown.maps.nodes, "texel");
    }
}

TEST(ViewValues, what_is_seen_and_what_is_drawn_are_each_others_inverse) {
    const Shown shown;
    const shaders::ViewValues v = shown.values();
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column) {
            double sum = 0, size = 0;
            for (int i = 0; i < 4; ++i) {
                const double term =
                    static_cast<double>(v.clip_from_local.column_major[std::size_t(4 * i + row)]) *
                    static_cast<double>(
                        v.local_from_clip.column_major[std::size_t(4 * column + i)]);
                sum += term;
                size += std::abs(term);
            }
            EXPECT_NEAR(sum, row == column ? 1 : 0, 1e-6 * (1 + size)) << row << ", " << column;
        }
    // A point to the right of the eye's direction lies right on the picture: columns are not rows.
    const double ahead = shown.camera.azimuth_rad();
    const double local[4] = {100 * std::cos(ahead - 0.1), 100 * std::sin(ahead - 0.1), 23, 1};
    double x = 0, w = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        x += static_cast<double>(v.clip_from_local.column_major[4 * i]) * local[i];
        w += static_cast<double>(v.clip_from_local.column_major[4 * i + 3]) * local[i];
    }
    EXPECT_GT(x / w, 0.1);
}

// docs: in the equilibrium range the variance of slope is the same in every octave.
TEST(ViewValues, waves_beyond_the_finest_cascade_are_a_smaller_turned_copy_of_it) {
    const Shown shown;
    const shaders::ViewValues v = shown.values();
    const double smaller = 2.9 / 0.4; // the copy's band begins where the cascade's ends
    EXPECT_FLOAT_EQ(v.detail_amplitude, 1);
    EXPECT_NEAR(v.detail_maps_per_m, smaller / 31, 1e-6);
    const double c = v.detail_turn.x, s = v.detail_turn.y;
    EXPECT_NEAR(c * c + s * s, 1, 1e-6);
    EXPECT_GT(s, 0.1) << "turned, or crests of both would lie on each other";
    const double half_texel = 0.5 / shown.maps.nodes;
    const double east = c * -1234.5 - s * 777.25, north = s * -1234.5 + c * 777.25;
    // The turn is a float here: 1e-7 of 1500 m, in tiles of 4 m.
    EXPECT_NEAR(v.detail_origin.x, fraction(east * smaller / 31 + half_texel), 2e-4);
    EXPECT_NEAR(v.detail_origin.y, fraction(north * smaller / 31 + half_texel), 2e-4);
    // What lies between the copy's end and 370 rad/m, each axis half.
    const double per_octave = shown.maps.statistics.finest_slope_variance / std::log(smaller);
    EXPECT_NEAR(v.detail_slope_variance, 0.5 * per_octave * std::log(370 / (2.9 * smaller)), 1e-7);
    Shown plain;
    plain.options.detail = false;
    EXPECT_EQ(plain.values().detail_amplitude, 0);
    EXPECT_EQ(plain.values().detail_slope_variance, 0);
    Shown one;
    one.frame.cascades.erase(one.frame.cascades.begin());
    EXPECT_EQ(one.values().detail_amplitude, 0) << "its peak says nothing of shorter waves";
}

TEST(ViewValues, patches_of_foam_are_as_large_as_the_sea_is_high) {
    Shown shown;
    for (const auto& [hs_m, level] :
         {std::pair(0.0, 4), {0.06, 4}, {0.4, 2}, {1.0, 1}, {3.4, -1}, {8.0, -2}, {100.0, -4}}) {
        shown.frame.significant_height_m = hs_m;
        EXPECT_EQ(shown.values().foam_level, level) << hs_m;
    }
}

TEST(SeaMaps, every_channel_of_every_cascade_is_what_a_query_of_that_cascade_is_answered_from) {
    SyntheticSea sea(crossing_waves());
    const SeaFrame frame = sea.at(1'234'567);
    const SeaMaps maps = build_maps(frame);
    ASSERT_EQ(maps.cascades, 2);
    ASSERT_EQ(maps.nodes, 128);
    for (int c = 0; c < 2; ++c) {
        const auto index = static_cast<std::size_t>(c);
        const sea::Surface surface({frame.cascades[index].keyframes}, frame.choppiness, {}, {});
        const double length_m = frame.cascades[index].spec.length_m;
        double crest = 0, moved = 0, squares = 0, slopes = 0;
        for (int y = 0; y < 128; y += 1)
            for (int x = 0; x < 128; x += 1) {
                const sea::LagrangianPoint p =
                    surface.at(length_m * x / 128, length_m * y / 128, frame.time_us);
                crest = std::max(crest, std::abs(p.height));
                moved = std::max(moved, std::hypot(0.9 * p.displacement_x, 0.4 * p.displacement_y));
                squares += p.height * p.height / (128 * 128);
                slopes += (p.slope_x * p.slope_x + p.slope_y * p.slope_y) / (128 * 128);
                if (x % 19 != 0 || y % 23 != 0)
                    continue;
                const std::size_t at = 4u * static_cast<std::size_t>((c * 128 + y) * 128 + x);
                // Coefficients of a spline: a node is (c[-1] + 4 c[0] + c[1]) / 6 along both axes.
                double node[3] = {};
                for (int j = -1; j <= 1; ++j)
                    for (int i = -1; i <= 1; ++i)
                        for (std::size_t channel = 0; channel < 3; ++channel)
                            node[channel] +=
                                (i == 0 ? 4 : 1) * (j == 0 ? 4 : 1) / 36.0 *
                                static_cast<double>(
                                    maps.displacement[4u * static_cast<std::size_t>(
                                                               (c * 128 + ((y + j) & 127)) * 128 +
                                                               ((x + i) & 127)) +
                                                      channel]);
                EXPECT_NEAR(node[0], p.displacement_x, 1e-6);
                EXPECT_NEAR(node[1], p.displacement_y, 1e-6);
                EXPECT_NEAR(node[2], p.height, 1e-6);
                const double gradient[4] = {p.slope_x, p.slope_y, p.strain_xx, p.strain_yy};
                const double moment[4] = {p.strain_xy, p.slope_x * p.slope_x, p.slope_y * p.slope_y,
                                          p.slope_x * p.slope_y};
                for (std::size_t channel = 0; channel < 4; ++channel) {
                    EXPECT_NEAR(maps.gradient[at + channel], gradient[channel], 1e-6) << channel;
                    EXPECT_NEAR(maps.moment[at + channel], moment[channel], 1e-6) << channel;
                }
            }
        if (c == 1) {
            EXPECT_NEAR(maps.statistics.finest_slope_variance, slopes, 1e-6);
        }
        SeaFrame alone = frame;
        alone.cascades = {frame.cascades[index]};
        const SeaStatistics s = build_maps(alone).statistics;
        EXPECT_NEAR(s.crest_m, crest, 1e-6);
        EXPECT_NEAR(s.reach_m, moved, 1e-6);
        EXPECT_NEAR(s.significant_height_m, 4 * std::sqrt(squares), 1e-5);
        EXPECT_NEAR(s.slope_variance, slopes, 1e-6);
    }
}

TEST(SeaMaps, each_mip_is_the_mean_of_four_of_the_one_above_and_of_its_own_cascade) {
    SyntheticSea sea(crossing_waves());
    const SeaMaps maps = build_maps(sea.at(1'234'567));
    std::size_t above = 0;
    for (int side = 64; side >= 16; side /= 2) {
        const int parent = 2 * side;
        const std::size_t here = above + 4u * static_cast<std::size_t>(2 * parent * parent);
        for (int c = 0; c < 2; ++c)
            for (const auto& [x, y] : {std::pair(0, 0), {3, 11}, {15, 2}, {side - 1, side - 2}}) {
                double mean = 0;
                for (const auto& [i, j] : {std::pair(0, 0), {1, 0}, {0, 1}, {1, 1}})
                    mean += 0.25 *
                            static_cast<double>(
                                maps.gradient[above + 4u * static_cast<std::size_t>(
                                                               (c * parent + 2 * y + j) * parent +
                                                               2 * x + i)]);
                EXPECT_NEAR(
                    maps.gradient[here + 4u * static_cast<std::size_t>((c * side + y) * side + x)],
                    mean, 1e-6)
                    << side << ": " << c << ", " << x << ", " << y;
            }
        above = here;
    }
}

} // namespace
} // namespace seaway::client
