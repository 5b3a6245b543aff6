// SPDX-License-Identifier: Apache-2.0
// What shaders are told, and the maps they look it up in: every value against one worked out here, in a
// sea where east is not north and no two cascades are alike.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "client/view/renderer.h"
#include "client/view/water_optics.h"
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
    RenderOptions options;

    Shown() {
        SyntheticSea sea(crossing_waves());
        frame = sea.at(1'234'567);
        frame.significant_height_m = 2.1;
        frame.foam_threshold = 0.37;
        frame.foam_mean = 0.021;
        frame.reach_m = 3.7;
        frame.depth_m = 6.5;
        frame.water = {sea::WaterType::jerlov_1b, {0.3, 0.4, 0.5}};
        mesh = build_mesh(camera, frame, 3);
    }
    shaders::ViewValues values(const DebugChoice& debug = {}, const Display& display = {}) const {
        return view_values(frame, camera, sky, mesh, options, debug, display);
    }
};

TEST(ViewValues, water_is_that_of_the_frame) {
    const Shown shown;
    const shaders::ViewValues v = shown.values();
    const auto expect = [](double value, double expected, const char* what) {
        EXPECT_NEAR(value, expected, 1e-6 * std::abs(expected)) << what; // floats
    };
    const WaterLook water = water_look(shown.frame.water, 6.5, 2.1);
    expect(v.water_reflectance.x, water.reflectance.r, "water");
    expect(v.water_reflectance.z, water.reflectance.b, "water");
    expect(v.water.attenuation_per_m.y, water.attenuation_per_m.g, "attenuation");
    expect(v.water.floor_attenuation_per_m.y, water.floor_attenuation_per_m.g, "to the floor");
    expect(v.water.crest.y, water.crest.g, "crests");
    expect(v.water.bubbles.y, water.bubbles.g, "bubbles");
    expect(v.water.floor_reflectance.x, water.floor.r, "floor");
    expect(v.water.depth_m, 6.5, "depth");
    EXPECT_EQ(v.water.floor_seen, 1);
    // The sun at this hour stands 15.7 degrees high, 45.9 from the zenith in water: 1.437; light of the sky 1 / 0.86.
    const double beam = luminance_of(shown.sky.sun_irradiance()) * sun_direction(16.5).z;
    const double share = beam / (beam + luminance_of(shown.sky.sky_irradiance()));
    const double down_path = share * 1.437 + (1 - share) * 1.163;
    EXPECT_NEAR(v.water.down_path, down_path, 1e-3);
    Shown coast;
    coast.frame.water.type = sea::WaterType::coastal_1;
    EXPECT_NEAR(coast.values().water.down_path, down_path / 1.18, 1e-3)
        << "a slant is in its attenuation already";
}

TEST(ViewValues, every_value_is_the_one_of_its_name) {
    const Shown shown;
    const shaders::ViewValues v = shown.values({DebugView::cascade, 1}, {DebugView::cascade, 1, 1});
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
    expect(v.significant_height_m, 2.1, "height");
    expect(v.mesh_apex_m.x, shown.mesh.apex_m.x, "apex");
    expect(v.mesh_apex_m.y, shown.mesh.apex_m.y, "apex");
    expect(v.mesh_azimuth_rad, shown.mesh.azimuth_rad, "azimuth");
    expect(v.mesh_step_rad, shown.mesh.step_rad, "step");
    EXPECT_EQ(v.mesh_columns, shown.mesh.columns);
    EXPECT_EQ(v.mesh_rows, static_cast<int>(shown.mesh.rows_m.size()));
    expect(v.choppiness.x, 0.9, "choppiness");
    expect(v.choppiness.y, 0.4, "choppiness");
    expect(v.curvature_per_m, 1 / (2 * 6371e3), "curvature");
    expect(v.reach_m, 3.7, "reach");
    expect(v.foam_noise_origin_m.x, fraction(-1234.5 / 256) * 256, "noise");
    expect(v.foam_noise_origin_m.y, fraction(777.25 / 256) * 256, "noise");
    expect(v.foam_threshold, 0.37, "threshold");
    expect(v.foam_mean, 0.021, "foam");
    // Cells of 0.6 of the wave height of the sea state, 1.26 m: the nearest power of two is 1 m.
    EXPECT_EQ(v.foam_level, 0);
    EXPECT_EQ(v.what, shaders::view_cascade);
    EXPECT_EQ(v.what_cascade, 1);
    EXPECT_EQ(shown.values({DebugView::cascade, 5}).what_cascade, 1) << "there are two";
    EXPECT_EQ(v.probes, shown.options.quality.probes);
    EXPECT_EQ(v.between_levels, shown.options.quality.between_levels ? 1 : 0);
    EXPECT_EQ(v.debug.channel, -1) << "slopes are red and green";
    expect(v.debug.low, -1, "scale of slopes");
    expect(v.debug.high, 1, "scale of slopes");
    const shaders::ViewValues lit = shown.values({}, {DebugView::final, 0.25, 5});
    expect(lit.exposure, 0.25, "exposure");
    const shaders::ViewValues heights = shown.values({}, {DebugView::height, 1, 5});
    expect(heights.debug.low, -2.5, "half of Hs has the full colour");
    expect(heights.debug.high, 2.5, "half of Hs has the full colour");
    expect(lit.picture_per_shown.x, shown.options.quality.scale, "scale");
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
    const double east = c * -1234.5 - s * 777.25, north = s * -1234.5 + c * 777.25;
    // The turn is a float here: 1e-7 of 1500 m, in tiles of 4 m.
    EXPECT_NEAR(v.detail_origin.x, fraction(east * smaller / 31), 2e-4);
    EXPECT_NEAR(v.detail_origin.y, fraction(north * smaller / 31), 2e-4);
    // What lies between the copy's end and 370 rad/m, each axis half.
    EXPECT_NEAR(v.detail_slope_share, 0.5 * std::log(370 / (2.9 * smaller)) / std::log(smaller),
                1e-6);
    Shown plain;
    plain.options.detail = false;
    EXPECT_EQ(plain.values().detail_amplitude, 0);
    EXPECT_EQ(plain.values().detail_slope_share, 0);
    Shown one;
    one.frame.cascades.erase(one.frame.cascades.begin());
    EXPECT_EQ(one.values().detail_amplitude, 0) << "its peak says nothing of shorter waves";
}

TEST(ViewValues, rows_of_foam_run_with_the_waves_and_stay_where_they_are) {
    Shown shown;
    shown.frame.mean_from_deg = 300; // they run towards 120: east and a little south
    const shaders::ViewValues v = shown.values();
    const double east = std::sin(two_pi / 3), north = std::cos(two_pi / 3);
    EXPECT_NEAR(v.wind_turn.x, east, 1e-6);
    EXPECT_NEAR(v.wind_turn.y, north, 1e-6);
    // Cells of 40 m along and 5 m across; the noise repeats after 256 of them.
    const double along = (-1234.5 * east + 777.25 * north) / 40;
    const double across = (777.25 * east + 1234.5 * north) / 5;
    EXPECT_NEAR(v.foam_rows_origin.x, along - 256 * std::floor(along / 256), 1e-3);
    EXPECT_NEAR(v.foam_rows_origin.y, across - 256 * std::floor(across / 256), 1e-3);
    EXPECT_FLOAT_EQ(v.foam_rows, 0.8f) << "foam covers 2.1 %";
    for (const auto& [cover, rows] :
         {std::pair(0.0, 0.0), {0.005, 0.0}, {0.0125, 0.4}, {0.02, 0.8}, {0.5, 0.8}}) {
        shown.frame.foam_mean = cover;
        EXPECT_NEAR(shown.values().foam_rows, rows, 1e-6) << cover;
    }
}

TEST(ViewValues, patches_of_foam_are_as_large_as_the_sea_is_high) {
    Shown shown;
    for (const auto& [hs_m, level] :
         {std::pair(0.0, 4), {0.06, 4}, {0.4, 2}, {1.0, 1}, {3.4, -1}, {8.0, -2}, {100.0, -4}}) {
        shown.frame.significant_height_m = hs_m;
        EXPECT_EQ(shown.values().foam_level, level) << hs_m;
    }
}

} // namespace
} // namespace seaway::client
