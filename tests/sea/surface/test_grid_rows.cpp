// SPDX-License-Identifier: Apache-2.0
// A cascade at its grid points, which is what engines draw, beside the same places one by one.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "sea/surface/grid_rows.h"
#include "tests/support/explicit_sea.h"

namespace seaway::sea {
namespace {

constexpr TimeUs apart_us = 200'000;

// Single precision on both ways: 1e-6 of what is summed, differences of neighbours as much over the width of a cell.
TEST(GridRows, have_what_the_surface_has_at_each_grid_point) {
    const RealizationPtr sea = tests::make_sea({tests::random_cascade(200.0, 64, 8, 30, 0.02, 1),
                                                tests::random_cascade(37.3, 64, 10, 30, 0.02, 2)});
    for (int c = 0; c < 2; ++c) {
        const auto map = [&](TimeUs time_us) {
            return std::make_shared<SplineMap>(*tests::exact_keyframe(sea, c, time_us));
        };
        const auto first = map(0);
        for (const SplinePair& pair :
             {SplinePair{first, map(apart_us)}, SplinePair{first, first}}) {
            const Surface surface({pair}, sea->choppiness, {.reach_m = 5.0}, {});
            const double cell_m = first->length_m() / first->size();
            for (const TimeUs time_us :
                 {TimeUs{0}, TimeUs{73'000}, apart_us, TimeUs{5 * apart_us}, TimeUs{-30'000}}) {
                GridRows rows(pair, time_us);
                ASSERT_EQ(rows.size(), 64);
                for (int y = 0; y < 64; ++y) {
                    const std::span<const LagrangianPoint> row = rows.next();
                    ASSERT_EQ(row.size(), 64u);
                    for (int x = 0; x < 64; ++x) {
                        const LagrangianPoint p = row[static_cast<std::size_t>(x)];
                        const LagrangianPoint q = surface.at(x * cell_m, y * cell_m, time_us);
                        const double value_m = 3e-6, slope = 3e-6 / cell_m, speed_mps = 1e-4;
                        ASSERT_NEAR(p.height, q.height, value_m) << x << " " << y << " " << time_us;
                        ASSERT_NEAR(p.displacement_x, q.displacement_x, value_m);
                        ASSERT_NEAR(p.displacement_y, q.displacement_y, value_m);
                        ASSERT_NEAR(p.height_rate, q.height_rate, speed_mps);
                        ASSERT_NEAR(p.displacement_x_rate, q.displacement_x_rate, speed_mps);
                        ASSERT_NEAR(p.displacement_y_rate, q.displacement_y_rate, speed_mps);
                        ASSERT_NEAR(p.slope_x, q.slope_x, slope);
                        ASSERT_NEAR(p.slope_y, q.slope_y, slope);
                        ASSERT_NEAR(p.strain_xx, q.strain_xx, slope);
                        ASSERT_NEAR(p.strain_yy, q.strain_yy, slope);
                        ASSERT_NEAR(p.strain_xy, q.strain_xy, slope);
                    }
                }
                EXPECT_TRUE(rows.next().empty());
            }
        }
    }
}

} // namespace
} // namespace seaway::sea
