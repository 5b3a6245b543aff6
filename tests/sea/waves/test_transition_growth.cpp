// SPDX-License-Identifier: Apache-2.0
// What a sea that glides grows by, in time rates.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sea/waves/transition.h"
#include "tests/sea/sea_fixture.h"

namespace seaway::sea {
namespace {

using testing::realized;
using testing::three_cascades;
using testing::windy_sea;

double height_at(const RealizationPtr& sea, TimeUs t) {
    return DirectSum(sea).at(3.0, 4.0, t).height;
}

/// To a stronger wind and other numbers, within ten seconds.
SeaTransition gust() {
    SeaState stronger = windy_sea();
    std::get<WindSea>(stronger.systems[0]).wind_speed_10m_mps = 20.0;
    stronger.seed = 5;
    return *SeaTransition::create(realized(windy_sea(), three_cascades),
                                  realized(stronger, three_cascades), 0, 10'000'000);
}

// The time rate of the sum, against differences of heights of the glide itself.
TEST(Transition, growth_times_the_rate_of_the_glide_is_what_rates_lack) {
    const SeaTransition change = gust();
    for (const TimeUs t : {1'000'000, 5'000'000, 9'000'000}) {
        const TimeUs step = 1000;
        const double rise = (height_at(change.gliding(t + step), t + step) -
                             height_at(change.gliding(t - step), t - step)) /
                            (2e-6 * static_cast<double>(step));
        const double waves = DirectSum(change.gliding(t)).at(3.0, 4.0, t).height_rate;
        const double growth = glide_rate(t, 0, 10'000'000) * height_at(change.growth(t), t);
        EXPECT_NEAR(rise, waves + growth, 1e-4) << t; // h^2 w^3 / 6 of the difference
        EXPECT_GT(std::abs(growth), 1e-3) << "else this says nothing";
    }
}

// Naive: the exact sum has the rates of waves that stand, and is the less exact one.
TEST(Transition, an_exact_sum_that_knows_the_growth_has_it_in_its_rates_and_in_the_water_below) {
    const SeaTransition change = gust();
    for (const Instructions instructions : supported_instructions())
        for (const TimeUs t : {1'000'000, 5'000'000, 9'000'000}) {
            constexpr TimeUs step = 1000;
            const auto at = [&](TimeUs time) {
                return DirectSum(change.gliding(time)).at(3.0, 4.0, time);
            };
            const LagrangianPoint before = at(t - step), after = at(t + step);
            const double per_s = 0.5e6 / static_cast<double>(step);
            const DirectSum sum(change.gliding(t), change.growing_at(t), instructions);
            const DirectSum::Moment moment = sum.at_time(t);
            const LagrangianPoint now = moment.at(3.0, 4.0);
            // h^2 w^3 / 6 of the difference.
            EXPECT_NEAR(now.height_rate, per_s * (after.height - before.height), 1e-4);
            EXPECT_NEAR(now.displacement_x_rate,
                        per_s * (after.displacement_x - before.displacement_x), 1e-4);
            EXPECT_NEAR(now.displacement_y_rate,
                        per_s * (after.displacement_y - before.displacement_y), 1e-4);
            EXPECT_EQ(now.height, DirectSum(change.gliding(t)).at(3.0, 4.0, t).height);
            const WaterMotion water = moment.motion(3.0, 4.0, 0.0); // at the surface the same
            EXPECT_NEAR(water.velocity_mps[0], now.displacement_x_rate, 1e-9);
            EXPECT_NEAR(water.velocity_mps[2], now.height_rate, 1e-9);
        }
    for (const TimeUs outside : {-1, 0, 10'000'000, 10'000'001})
        EXPECT_EQ(change.growing_at(outside).waves, nullptr);
}

// Naive: water in a sea that becomes shallower moves further sideways, and its rate says nothing of it. 1/d runs from 0 to
// 1/12; cascades whose waves are long and short for that.
TEST(Transition, rates_of_displacements_have_the_glide_of_the_depth_in_them) {
    SeaState shallow = windy_sea();
    shallow.depth_m = 12.0;
    const auto deep_sea = realized(windy_sea(), three_cascades);
    const auto shallow_sea = realized(shallow, three_cascades);
    for (const bool deepens : {false, true}) {
        const auto change = SeaTransition::create(deepens ? shallow_sea : deep_sea,
                                                  deepens ? deep_sea : shallow_sea, 0, 10'000'000);
        ASSERT_EQ(change->grown_otherwise(),
                  (FieldSet{Field::displacement_x, Field::displacement_y}));
        double missed = 0;
        for (const TimeUs t : {1'000'000, 5'000'000, 9'000'000})
            for (const double x : {0.0, 70.0, 333.0}) {
                const auto sideways = [x](const RealizationPtr& sea, TimeUs at) {
                    return DirectSum(sea).at(x, 4.0, at);
                };
                const TimeUs step = 1000;
                const double moved =
                    (sideways(change->gliding(t + step), t + step).displacement_x -
                     sideways(change->gliding(t - step), t - step).displacement_x) /
                    (2e-6 * static_cast<double>(step));
                const double waves = sideways(change->gliding(t), t).displacement_x_rate;
                const double rate = glide_rate(t, 0, 10'000'000);
                EXPECT_NEAR(moved,
                            waves +
                                rate * sideways(change->displacement_growth(t), t).displacement_x,
                            1e-4)
                    << t; // h^2 w^3 / 6 of the difference
                missed = std::max(
                    missed,
                    std::abs(moved - waves - rate * sideways(change->growth(t), t).displacement_x));
            }
        EXPECT_GT(missed, 1e-3) << "else this says nothing";
    }
    const auto stays = SeaTransition::create(deep_sea, deep_sea, 0, 10'000'000);
    EXPECT_TRUE(stays->grown_otherwise().empty());
    EXPECT_EQ(stays->grown(),
              (FieldSet{Field::height, Field::displacement_x, Field::displacement_y}));
}

} // namespace
} // namespace seaway::sea
