// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "client/view/sea_maps.h"
#include "tests/client/view/small_seas.h"
#include "tests/client/view/synthetic_sea.h"

namespace seaway::client {
namespace {

TEST(SeaMaps, nodes_are_what_a_query_is_answered_from) {
    SyntheticSea sea(one_wave(0.7, 90, 3));
    const SeaFrame frame = sea.at(1'234'567);
    const SeaMaps maps = build_maps(frame);
    const sea::Surface surface = sea.surface(frame);
    ASSERT_EQ(maps.nodes, 128) << "twice the tile's 64";
    for (const int x : {0, 1, 57, 127})
        for (const int y : {0, 64, 101}) {
            const sea::LagrangianPoint p =
                surface.at(90.0 * x / 128, 90.0 * y / 128, frame.time_us);
            const std::size_t at = 4u * static_cast<std::size_t>(y * 128 + x);
            // Coefficients: a node is (c[-1] + 4 c[0] + c[1]) / 6, along both axes.
            double height = 0;
            for (int j = -1; j <= 1; ++j)
                for (int i = -1; i <= 1; ++i) {
                    const int node = ((y + j) & 127) * 128 + ((x + i) & 127);
                    height += (i == 0 ? 4 : 1) * (j == 0 ? 4 : 1) / 36.0 *
                              static_cast<double>(
                                  maps.displacement[4u * static_cast<std::size_t>(node) + 2]);
                }
            EXPECT_NEAR(height, p.height, 1e-6) << "floats of 0.7 m";
            EXPECT_FLOAT_EQ(maps.gradient[at], static_cast<float>(p.slope_x));
            EXPECT_FLOAT_EQ(maps.gradient[at + 2], static_cast<float>(p.strain_xx));
        }
}

TEST(SeaMaps, the_last_mip_knows_the_mean_square_slope) {
    const double amplitude_m = 0.7, k_radpm = 2 * std::numbers::pi * 3 / 90;
    SyntheticSea sea(one_wave(amplitude_m, 90, 3));
    const SeaMaps maps = build_maps(sea.at(1'000'000));
    const double square = 0.5 * amplitude_m * amplitude_m * k_radpm * k_radpm;
    // Time: Hermite keeps 1 cm of 70 cm in the worst case; the spline loses less than 1e-3.
    EXPECT_NEAR(static_cast<double>(maps.moment[maps.moment.size() - 3]) / square, 1, 0.03);
    EXPECT_NEAR(static_cast<double>(maps.gradient[maps.gradient.size() - 4]), 0, 1e-6)
        << "whole waves: no mean slope";
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

TEST(SeaMaps, foam_is_linear_in_space_and_time_and_its_last_mip_is_the_mean) {
    SyntheticSea sea(one_wave(0.7, 90, 3));
    SeaFrame frame = sea.at(1'250'000);
    const SeaMaps without = build_maps(frame);
    EXPECT_FLOAT_EQ(without.displacement[3], 1) << "average where nothing is known";
    frame.cascades[0].foam_before = foam_ramp(frame.cascades[0].spec, 1'000'000, 0, 0.5f);
    frame.cascades[0].foam_after = foam_ramp(frame.cascades[0].spec, 2'000'000, 4, 0.5f);
    const SeaMaps maps = build_maps(frame);
    ASSERT_EQ(maps.nodes, 128);
    for (const int x : {0, 2, 31, 124}) // a node is half a texel of the foam map
        for (const int y : {0, 77})
            EXPECT_FLOAT_EQ(maps.displacement[4u * static_cast<std::size_t>(y * 128 + x) + 3],
                            1.0f + 0.25f * static_cast<float>(x) + 0.0625f * static_cast<float>(y));
    // A share of the way that is not its own rest, and foam that differs in shape, not in height alone.
    frame.time_us = 1'300'000;
    frame.cascades[0].foam_after = foam_ramp(frame.cascades[0].spec, 2'000'000, 5, 1.5f);
    const SeaMaps later = build_maps(frame);
    for (const int x : {3, 31, 124})
        EXPECT_NEAR(later.displacement[4u * static_cast<std::size_t>(6 * 128 + x) + 3],
                    0.3f * 5 + (0.7f * 0.5f + 0.3f * 1.5f) * (0.5f * static_cast<float>(x) + 0.75f),
                    1e-4f);
    // 0 .. 63 texels, half a node's step more in the mean, but for the seam back to the first.
    EXPECT_NEAR(static_cast<double>(maps.displacement.back()), 1.0 + 0.625 * 31.5, 1e-3);
}

TEST(SeaMaps, statistics_are_those_of_the_wave) {
    SyntheticSea sea(one_wave(0.7, 90, 3));
    const SeaStatistics s = build_maps(sea.at(1'000'000)).statistics;
    EXPECT_NEAR(s.significant_height_m, 4 * 0.7 / std::sqrt(2.0), 0.02);
    EXPECT_NEAR(s.crest_m, 0.7, 0.01);
    EXPECT_NEAR(s.reach_m, 0.7, 0.01);
}

} // namespace
} // namespace seaway::client
