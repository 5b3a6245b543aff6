// SPDX-License-Identifier: Apache-2.0
// The sea in the device's memory, map by map, against what queries are answered from. Validation layers are on.
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>

#include <gtest/gtest.h>

#include <Imath/half.h>

#include "client/view/sea/device_sea.h"
#include "tests/client/view/small_seas.h"
#include "tests/client/view/synthetic_sea.h"
#include "tests/gpu/device_for_tests.h"

namespace seaway::client {
namespace {

/// Of a half float of so much.
double half_step(double value) {
    return std::max(std::abs(value), 6e-5) / 1024;
}

/// Gradients as shaders/view/gradient_texel.glsl packs them.
struct Gradient {
    double slope_x, slope_y, strain_xx, strain_yy, strain_xy, foam;
    double variance_xx, variance_yy, variance_xy;
};

double half_of(std::uint32_t word, int shift) {
    Imath::half h;
    h.setBits(static_cast<unsigned short>(word >> shift));
    return static_cast<double>(static_cast<float>(h));
}

Gradient unpacked(const std::uint32_t* words) {
    const double trace = half_of(words[3], 0);
    const auto side = [&](int shift) {
        return std::max(static_cast<std::int8_t>(words[3] >> shift) / 127.0, -1.0);
    };
    return {half_of(words[0], 0),       half_of(words[0], 16),      half_of(words[1], 0),
            half_of(words[1], 16),      half_of(words[2], 0),       half_of(words[2], 16),
            trace * (1 + side(16)) / 2, trace * (1 - side(16)) / 2, trace * side(24) / 2};
}

/// All maps of a frame, read back.
struct Maps {
    shaders::ViewValues values;
    std::vector<float> displacements;
    std::vector<std::uint32_t> gradients;

    static int first_of(int side, int level) { // texels of the levels above
        int first = 0;
        for (int l = 0; l < level; ++l)
            first += (side >> l) * (side >> l);
        return first;
    }
    const float* displacement(int cascade, int level, int x, int y) const {
        const shaders::ViewCascade& tile = values.cascade[cascade];
        const int side = tile.points >> level;
        return &displacements[4u * static_cast<std::size_t>(
                                       tile.displacement_first + first_of(tile.points, level) +
                                       (y & (side - 1)) * side + (x & (side - 1)))];
    }
    Gradient gradient(int cascade, int level, int x, int y) const {
        const shaders::ViewCascade& tile = values.cascade[cascade];
        const int side = tile.nodes >> level;
        return unpacked(&gradients[4u * static_cast<std::size_t>(
                                            tile.gradient_first + first_of(tile.nodes, level) +
                                            (y & (side - 1)) * side + (x & (side - 1)))]);
    }
};

class DeviceSeaTest : public gpu::DeviceTest {
  protected:
    void SetUp() override {
        gpu::DeviceTest::SetUp();
        make({});
    }
    gpu::Device& device() { return staged_ ? *staged_ : *device_; }
    void make(const DeviceSeaOptions& options) {
        Result<DeviceSea> made = DeviceSea::create(device(), options);
        ASSERT_TRUE(made) << made.error().message;
        sea_ = std::move(*made);
        Result<gpu::Buffer> values = gpu::Buffer::create(
            device(), "values", sizeof(shaders::ViewValues), gpu::BufferKind::upload);
        ASSERT_TRUE(values) << values.error().message;
        values_ = std::move(*values);
    }
    /// Copies go through staging buffers there.
    void on_a_device_with_memory_of_its_own() {
        Result<std::unique_ptr<gpu::Device>> staged =
            gpu::Device::create({.validation = true, .staged = true});
        ASSERT_TRUE(staged) << staged.error().message;
        staged_ = std::move(*staged);
        make({});
    }
    Maps maps_of(const SeaFrame& frame, const glm::dvec2& camera_m = {0, 0}) {
        Maps maps;
        const Result<void> taken = sea_.take(frame, values_);
        EXPECT_TRUE(taken) << taken.error().message;
        sea_.describe(frame, camera_m, maps.values);
        std::memcpy(values_.mapped().data(), &maps.values, sizeof maps.values);
        const Result<void> ran = gpu::run_once(
            device(), [&](gpu::Commands& commands) { sea_.record(commands, values_); });
        EXPECT_TRUE(ran) << ran.error().message;
        maps.displacements.resize(sea_.displacement_buffer().size_bytes() / sizeof(float));
        maps.gradients.resize(sea_.gradient_buffer().size_bytes() / sizeof(std::uint32_t));
        EXPECT_TRUE(gpu::download(device(), sea_.displacement_buffer(),
                                  std::as_writable_bytes(std::span(maps.displacements))));
        EXPECT_TRUE(gpu::download(device(), sea_.gradient_buffer(),
                                  std::as_writable_bytes(std::span(maps.gradients))));
        return maps;
    }
    void TearDown() override {
        sea_ = {};
        values_ = {};
        if (staged_)
            expect_no_messages(staged_->validation());
        gpu::DeviceTest::TearDown();
    }

    std::unique_ptr<gpu::Device> staged_; ///< of the tests that need one
    DeviceSea sea_;
    gpu::Buffer values_;
};

/// An oblique wave in a tile of 90 m and another in one of 31 m, of half the size.
sea::Realization waves_that_cross() {
    sea::Realization sea = one_wave(0.7, 90, 3, -2);
    sea.cascades[0].band = {0.05, 0.4};
    sea::Realization second = one_wave(0.2, 31, -1, 4);
    second.cascades[0].band = {0.4, 2.9};
    sea.cascades.push_back(std::move(second.cascades[0]));
    sea.choppiness = {0.9, 0.4};
    return sea;
}

// Level 0 of the displacements holds coefficients: a grid point is (c[-1] + 4 c[0] + c[1]) / 6 along both axes.
TEST_F(DeviceSeaTest,
       every_channel_of_every_cascade_is_what_a_query_of_that_cascade_is_answered_from) {
    SyntheticSea sea(waves_that_cross());
    const SeaFrame frame = sea.at(1'234'567);
    const Maps maps = maps_of(frame);
    ASSERT_EQ(maps.values.cascades, 2);
    for (int c = 0; c < 2; ++c) {
        const CascadeFrame& cascade = frame.cascades[static_cast<std::size_t>(c)];
        const sea::Surface surface({cascade.keyframes}, frame.choppiness, {}, {});
        const double length_m = cascade.spec.length_m;
        ASSERT_EQ(maps.values.cascade[c].points, 64);
        ASSERT_EQ(maps.values.cascade[c].nodes, 128) << "twice the tile's";
        for (const int x : {0, 1, 29, 63})
            for (const int y : {0, 32, 51}) {
                const sea::LagrangianPoint p =
                    surface.at(length_m * x / 64, length_m * y / 64, frame.time_us);
                double point[3] = {};
                for (int j = -1; j <= 1; ++j)
                    for (int i = -1; i <= 1; ++i)
                        for (int channel = 0; channel < 3; ++channel)
                            point[channel] +=
                                (i == 0 ? 4 : 1) * (j == 0 ? 4 : 1) / 36.0 *
                                static_cast<double>(maps.displacement(c, 0, x + i, y + j)[channel]);
                EXPECT_NEAR(point[0], p.displacement_x, 1e-6);
                EXPECT_NEAR(point[1], p.displacement_y, 1e-6);
                EXPECT_NEAR(point[2], p.height, 1e-6) << "floats of 0.7 m";
            }
        for (const int x : {0, 19, 76, 127}) // grid points and halfway between them
            for (const int y : {0, 23, 100}) {
                const sea::LagrangianPoint p =
                    surface.at(length_m * x / 128, length_m * y / 128, frame.time_us);
                const Gradient g = maps.gradient(c, 0, x, y);
                EXPECT_NEAR(g.slope_x, p.slope_x, half_step(p.slope_x));
                EXPECT_NEAR(g.slope_y, p.slope_y, half_step(p.slope_y));
                EXPECT_NEAR(g.strain_xx, p.strain_xx, half_step(p.strain_xx));
                EXPECT_NEAR(g.strain_yy, p.strain_yy, half_step(p.strain_yy));
                EXPECT_NEAR(g.strain_xy, p.strain_xy, half_step(p.strain_xy));
                EXPECT_EQ(g.variance_xx + g.variance_yy, 0) << "a node is a point";
                EXPECT_EQ(g.foam, 1) << "average where nothing is known";
            }
    }
}

// With one node a point the same, at fewer places.
TEST_F(DeviceSeaTest, nodes_of_a_coarser_map_lie_on_grid_points) {
    make({.nodes_a_point = 1});
    SyntheticSea sea(waves_that_cross());
    const SeaFrame frame = sea.at(700'000);
    const Maps maps = maps_of(frame);
    const sea::Surface surface({frame.cascades[1].keyframes}, frame.choppiness, {}, {});
    ASSERT_EQ(maps.values.cascade[1].nodes, 64);
    for (const auto& [x, y] : {std::pair(0, 0), {63, 1}, {17, 40}}) {
        const sea::LagrangianPoint p = surface.at(31.0 * x / 64, 31.0 * y / 64, frame.time_us);
        const Gradient g = maps.gradient(1, 0, x, y);
        EXPECT_NEAR(g.slope_x, p.slope_x, half_step(p.slope_x));
        EXPECT_NEAR(g.strain_xy, p.strain_xy, half_step(p.strain_xy));
    }
}

// Mean, and mean square: a level's variance is what its four had, and what they differ by.
TEST_F(DeviceSeaTest, each_level_is_the_mean_of_four_of_the_one_above_and_of_its_own_cascade) {
    SyntheticSea sea(waves_that_cross());
    const Maps maps = maps_of(sea.at(1'234'567));
    for (int c = 0; c < 2; ++c)
        for (int level = 1; level <= 5; ++level)
            for (const auto& [x, y] : {std::pair(0, 0), {1, 3}, {3, 2}}) {
                Gradient mean{};
                double xx = 0, yy = 0, xy = 0;
                for (const auto& [i, j] : {std::pair(0, 0), {1, 0}, {0, 1}, {1, 1}}) {
                    const Gradient g = maps.gradient(c, level - 1, 2 * x + i, 2 * y + j);
                    mean.slope_x += g.slope_x / 4;
                    mean.slope_y += g.slope_y / 4;
                    mean.strain_xx += g.strain_xx / 4;
                    mean.strain_yy += g.strain_yy / 4;
                    mean.strain_xy += g.strain_xy / 4;
                    xx += (g.variance_xx + g.slope_x * g.slope_x) / 4;
                    yy += (g.variance_yy + g.slope_y * g.slope_y) / 4;
                    xy += (g.variance_xy + g.slope_x * g.slope_y) / 4;
                }
                const Gradient g = maps.gradient(c, level, x, y);
                const double trace =
                    xx + yy - mean.slope_x * mean.slope_x - mean.slope_y * mean.slope_y;
                EXPECT_NEAR(g.slope_x, mean.slope_x, half_step(mean.slope_x)) << level;
                EXPECT_NEAR(g.slope_y, mean.slope_y, half_step(mean.slope_y));
                EXPECT_NEAR(g.strain_xx, mean.strain_xx, half_step(mean.strain_xx));
                EXPECT_NEAR(g.strain_yy, mean.strain_yy, half_step(mean.strain_yy));
                EXPECT_NEAR(g.strain_xy, mean.strain_xy, half_step(mean.strain_xy));
                // Sides of the covariance are kept in steps of 1/127 of its trace.
                const double step = trace / 127 + 1e-6;
                EXPECT_NEAR(g.variance_xx, xx - mean.slope_x * mean.slope_x, step);
                EXPECT_NEAR(g.variance_yy, yy - mean.slope_y * mean.slope_y, step);
                EXPECT_NEAR(g.variance_xy, xy - mean.slope_x * mean.slope_y, step);
            }
}

TEST_F(DeviceSeaTest, the_last_level_knows_the_mean_square_slope) {
    const double amplitude_m = 0.7, k_radpm = 2 * std::numbers::pi * 3 / 90;
    SyntheticSea sea(one_wave(amplitude_m, 90, 3));
    const Maps maps = maps_of(sea.at(1'000'000));
    const Gradient all = maps.gradient(0, 7, 0, 0);
    const double square = 0.5 * amplitude_m * amplitude_m * k_radpm * k_radpm;
    // Time: Hermite keeps 1 cm of 70 cm in the worst case; the spline loses less than 1e-3.
    EXPECT_NEAR(all.variance_xx / square, 1, 0.03);
    EXPECT_NEAR(all.variance_yy / square, 0, 0.01) << "it runs east";
    EXPECT_NEAR(all.slope_x, 0, 1e-5) << "whole waves: no mean slope";
}

// The mesh averages away what it cannot carry: means of values, not of coefficients.
TEST_F(DeviceSeaTest, levels_of_displacement_are_means_over_their_texel) {
    SyntheticSea sea(waves_that_cross());
    const SeaFrame frame = sea.at(1'234'567);
    const Maps maps = maps_of(frame);
    for (int c = 0; c < 2; ++c) {
        const CascadeFrame& cascade = frame.cascades[static_cast<std::size_t>(c)];
        const sea::Surface surface({cascade.keyframes}, frame.choppiness, {}, {});
        for (const int level : {1, 2, 4})
            for (const auto& [x, y] : {std::pair(0, 0), {3, 1}, {2, 3}}) {
                const int side = 1 << level;
                double height = 0, moved_y = 0;
                for (int j = 0; j < side; ++j)
                    for (int i = 0; i < side; ++i) {
                        const double step_m = cascade.spec.length_m / 64;
                        const sea::LagrangianPoint p = surface.at(
                            (x * side + i) * step_m, (y * side + j) * step_m, frame.time_us);
                        height += p.height / (side * side);
                        moved_y += p.displacement_y / (side * side);
                    }
                EXPECT_NEAR(static_cast<double>(maps.displacement(c, level, x, y)[2]), height,
                            2e-6);
                EXPECT_NEAR(static_cast<double>(maps.displacement(c, level, x, y)[1]), moved_y,
                            2e-6);
            }
    }
}

TEST_F(DeviceSeaTest,
       lies_where_the_camera_is_and_the_longest_wave_says_how_many_levels_tell_something) {
    SyntheticSea sea(waves_that_cross());
    const SeaFrame frame = sea.at(0);
    const Maps maps = maps_of(frame, {-1234.5, 777.25});
    for (int c = 0; c < 2; ++c) {
        const double length_m = c == 0 ? 90 : 31;
        const shaders::ViewCascade& tile = maps.values.cascade[c];
        EXPECT_NEAR(tile.origin.x, -1234.5 / length_m - std::floor(-1234.5 / length_m), 1e-6);
        EXPECT_NEAR(tile.origin.y, 777.25 / length_m - std::floor(777.25 / length_m), 1e-6);
        EXPECT_NEAR(tile.maps_per_m, 1 / length_m, 1e-8);
    }
    // 2 pi / 0.4 rad/m are 15.7 m: 64.9 nodes of 31 m / 128, less than 2^7, and 32.4 points.
    EXPECT_EQ(maps.values.cascade[1].gradient_levels, 7);
    EXPECT_EQ(maps.values.cascade[1].displacement_levels, 6);
    // 126 m do not fit into the tile: all of its levels.
    EXPECT_EQ(maps.values.cascade[0].gradient_levels, 7);
}

/// A foam map of a cascade: rises by `step` a texel along x and a quarter of it along y, starting at
/// `first`.
sea::KeyframePtr foam_ramp(const sea::CascadeSpec& spec, sea::TimeUs time_us, float first,
                           float step) {
    sea::Keyframe keyframe;
    keyframe.time_us = time_us;
    keyframe.size = spec.size;
    keyframe.length_m = spec.length_m;
    keyframe.fields = {sea::Field::foam};
    keyframe.values.resize(keyframe.plane_size());
    const auto side = static_cast<std::size_t>(spec.size);
    for (std::size_t i = 0; i < keyframe.values.size(); ++i) {
        const std::size_t row = i / side, column = i % side;
        keyframe.values[i] =
            first + step * (static_cast<float>(column) + 0.25f * static_cast<float>(row));
    }
    return std::make_shared<const sea::Keyframe>(std::move(keyframe));
}

TEST_F(DeviceSeaTest, foam_is_linear_in_space_and_time_and_its_last_level_is_the_mean) {
    SyntheticSea sea(one_wave(0.7, 90, 3));
    SeaFrame frame = sea.at(1'250'000);
    frame.cascades[0].foam_before = foam_ramp(frame.cascades[0].spec, 1'000'000, 0, 0.5f);
    frame.cascades[0].foam_after = foam_ramp(frame.cascades[0].spec, 2'000'000, 4, 0.5f);
    const Maps maps = maps_of(frame);
    for (const int x : {0, 2, 31, 124}) // a node is half a texel of the foam map
        for (const int y : {0, 77}) {
            const double expected = 1.0 + 0.25 * x + 0.0625 * y;
            EXPECT_NEAR(maps.gradient(0, 0, x, y).foam, expected, half_step(expected));
        }
    // 0 .. 63 texels, half a node's step more in the mean, but for the seam back to the first.
    EXPECT_NEAR(maps.gradient(0, 7, 0, 0).foam, 1.0 + 0.625 * 31.5, 7 * half_step(20));
    // A share of the way that is not its own rest, and foam that differs in shape, not in height alone.
    frame.time_us = 1'300'000;
    frame.cascades[0].foam_after = foam_ramp(frame.cascades[0].spec, 2'000'000, 5, 1.5f);
    const Maps later = maps_of(frame);
    for (const int x : {3, 31, 124}) {
        const double expected = 0.3 * 5 + (0.7 * 0.5 + 0.3 * 1.5) * (0.5 * x + 0.75);
        EXPECT_NEAR(later.gradient(0, 0, x, 6).foam, expected, half_step(expected)) << x;
    }
}

// Nothing is copied twice, whatever the order of times; and what a frame under way reads stays: the maps of both
// keyframes are right after every step.
TEST_F(DeviceSeaTest, a_keyframe_is_copied_once_and_is_never_overwritten_by_its_neighbour) {
    SyntheticSea sea(waves_that_cross());
    std::vector<SeaFrame> frames;
    for (int i = 0; i < 6; ++i)
        frames.push_back(sea.at(i * 700'000));
    const auto height = [&](const SeaFrame& frame) {
        return static_cast<double>(maps_of(frame).displacement(0, 2, 5, 3)[2]);
    };
    std::vector<double> first;
    for (const SeaFrame& frame : frames)
        first.push_back(height(frame));
    const std::uint64_t copies = sea_.copies();
    for (int repeat = 0; repeat < 3; ++repeat)
        EXPECT_EQ(height(frames.back()), first.back());
    EXPECT_EQ(sea_.copies(), copies) << "the same keyframes again";
    SeaFrame between = frames.back();
    between.time_us += 1000;
    height(between);
    EXPECT_EQ(sea_.copies(), copies) << "another time between the same keyframes";
    for (const std::size_t i : {3u, 0u, 5u, 1u, 4u, 2u, 0u}) // forth and back
        EXPECT_EQ(height(frames[i]), first[i]) << i;
}

// The first keyframe is the one that was used longest ago when the other of the pair needs room.
TEST_F(DeviceSeaTest, a_keyframe_that_is_needed_makes_no_room_for_the_other_one) {
    SyntheticSea sea(waves_that_cross());
    SeaFrame first = sea.at(0), last = sea.at(5'000'000);
    SeaFrame across = first;
    across.time_us = 2'000'000;
    for (std::size_t c = 0; c < 2; ++c)
        across.cascades[c].keyframes.after = last.cascades[c].keyframes.after;
    const Maps expected = maps_of(across);
    make({});
    maps_of(first);
    maps_of(sea.at(3'000'000)); // all four places are taken
    EXPECT_EQ(maps_of(across).displacements, expected.displacements);
}

TEST_F(DeviceSeaTest, reads_the_same_where_the_cpu_cannot_see_the_devices_memory) {
    SyntheticSea sea(waves_that_cross());
    const SeaFrame frame = sea.at(1'234'567), next = sea.at(2'000'000);
    const Maps here = maps_of(frame);
    const Maps later = maps_of(next);
    on_a_device_with_memory_of_its_own();
    EXPECT_EQ(maps_of(frame).gradients, here.gradients);
    EXPECT_EQ(maps_of(next).displacements, later.displacements);
}

// A camera that looks at the sky: every frame takes the sea, none records it. Naive: what they left is recorded by the first
// frame of the sea, whose device still reads those places while the next one fills them.
TEST_F(DeviceSeaTest, copies_that_nobody_recorded_are_of_the_last_frame_alone) {
    on_a_device_with_memory_of_its_own();
    SyntheticSea sea(waves_that_cross());
    const SeaFrame before = sea.at(98 * 700'000), last = sea.at(100 * 700'000);
    const Maps of_before = maps_of(before), of_last = maps_of(last);
    make({});
    for (int i = 0; i < 100; ++i) {
        ASSERT_TRUE(sea_.take(i == 98 ? before : sea.at(i * 700'000), values_));
        EXPECT_LE(sea_.waiting(), 2u * 2u) << "two cascades, two keyframes of each";
    }
    // What was forgotten is not taken for held.
    EXPECT_EQ(maps_of(before).displacements, of_before.displacements);
    EXPECT_EQ(maps_of(last).displacements, of_last.displacements);
    EXPECT_EQ(sea_.waiting(), 0u);
}

// A server is started again with a smaller sea while the camera looks at the sky.
TEST_F(DeviceSeaTest, what_nobody_recorded_of_a_larger_sea_is_forgotten_with_it) {
    on_a_device_with_memory_of_its_own();
    sea::Realization large = one_wave(0.5, 90, 3, -2, 256);
    for (const double length_m : {31.0, 11.0})
        large.cascades.push_back(one_wave(0.1, length_m, 2, 1, 256).cascades[0]);
    SyntheticSea before(std::move(large)), after(one_wave(0.5, 40, 2));
    const SeaFrame next = after.at(500'000);
    const Maps expected = maps_of(next);
    make({});
    ASSERT_TRUE(sea_.take(before.at(500'000), values_));
    EXPECT_EQ(sea_.waiting(), 3u * 2u);
    ASSERT_TRUE(sea_.take(next, values_));
    EXPECT_EQ(sea_.waiting(), 2u);
    EXPECT_EQ(maps_of(next).displacements, expected.displacements);
}

// From one sea to another of more cascades and other sizes.
TEST_F(DeviceSeaTest, makes_room_when_the_sea_is_another) {
    SyntheticSea small(one_wave(0.5, 40, 2)), large(waves_that_cross());
    const Maps alone = maps_of(large.at(500'000));
    EXPECT_NE(maps_of(small.at(500'000)).displacements.size(), alone.displacements.size());
    EXPECT_EQ(maps_of(large.at(500'000)).displacements, alone.displacements);
}

} // namespace
} // namespace seaway::client
