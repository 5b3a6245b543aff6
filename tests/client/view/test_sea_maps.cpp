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

TEST(SeaMaps, statistics_are_those_of_the_wave) {
    SyntheticSea sea(one_wave(0.7, 90, 3));
    const SeaStatistics s = build_maps(sea.at(1'000'000)).statistics;
    EXPECT_NEAR(s.significant_height_m, 4 * 0.7 / std::sqrt(2.0), 0.02);
    EXPECT_NEAR(s.crest_m, 0.7, 0.01);
    EXPECT_NEAR(s.reach_m, 0.7, 0.01);
}

} // namespace
} // namespace seaway::client
