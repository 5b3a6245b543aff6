// SPDX-License-Identifier: Apache-2.0
// Periods of seas at the ends of what a scene may ask for: what is told of them must be numbers, or no client takes it.
#include <gtest/gtest.h>

#include <cmath>

#include "sea/waves/realize.h"
#include "sea/waves/statistics/moments.h"
#include "tests/sea/sea_fixture.h"

namespace seaway::sea {
namespace {

SeaSummary summary_of(const SeaState& state) {
    return summarize(state, *testing::realized(state, testing::three_cascades));
}

// Naive: energies are weighed by their fourth powers, which no double holds below a height of 1e-32 m, as of a wind of 0.22 m/s.
TEST(Periods, of_the_same_sea_at_any_height_are_the_same) {
    const SeaStatistics one = summary_of(testing::swell_sea(1, 9)).realised;
    EXPECT_NEAR(one.peak_period_s, 9, 2) << "a tile of 512 m has few waves there";
    for (const double height_m : {1e-9, 1e-24, 1e-33, 1e-38, 1e-45, 1e-90}) {
        const SeaStatistics small = summary_of(testing::swell_sea(height_m, 9)).realised;
        EXPECT_NEAR(small.significant_height_m / height_m / one.significant_height_m, 1, 1e-9);
        EXPECT_NEAR(small.peak_period_s, one.peak_period_s, 1e-9) << height_m;
        EXPECT_NEAR(small.zero_crossing_period_s, one.zero_crossing_period_s, 1e-9) << height_m;
        EXPECT_NEAR(small.mean_period_s, one.mean_period_s, 1e-9) << height_m;
    }
    const SeaStatistics none = summary_of(testing::swell_sea(1e-150, 9)).realised;
    EXPECT_EQ(none.significant_height_m, 0) << "squares of it are no numbers";
    EXPECT_EQ(none.peak_period_s, 0);
}

// Each wave of a ramp a tenth as fast as the one before: after some ten of them they stand still.
TEST(Periods, are_of_the_waves_that_move) {
    for (const SineKind kind :
         {SineKind::sine, SineKind::gerstner, SineKind::exponential, SineKind::noise}) {
        SineRamps ramps;
        ramps.kind = kind;
        ramps.count = kind == SineKind::noise ? 16 : 24;
        ramps.speed_ratio = 0.1;
        ramps.amplitude_ratio = 1;
        ramps.wavenumber_ratio = 1;
        SeaState state;
        state.systems.emplace_back(ramps);
        const SeaSummary summary = summarize(state, *testing::realized(state, {{256.0, 128}}));
        for (const SeaStatistics& of : {summary.requested, summary.realised}) {
            EXPECT_GT(of.significant_height_m, 0);
            for (const double period_s :
                 {of.peak_period_s, of.zero_crossing_period_s, of.mean_period_s}) {
                EXPECT_GT(period_s, 1) << static_cast<int>(kind);
                EXPECT_LT(period_s, period_max_s) << static_cast<int>(kind);
            }
        }
    }
}

} // namespace
} // namespace seaway::sea
