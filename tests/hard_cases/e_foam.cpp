// SPDX-License-Identifier: Apache-2.0
// Hard cases E1, E2 beside foam that frames multiply and add to. All criteria are held in tests/sea/foam.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "sea/foam/foam.h"
#include "tests/hard_cases/record.h"
#include "tests/naive/foam.h"
#include "tests/sea/foam/foam_seas.h"

namespace seaway::hard_cases {
namespace {

// 2 % is the case's.
TEST(HardCase, E1_foam_fades_alike_at_30_and_144_hz) {
    const auto after_a_second = [](int rate_hz) {
        double left = 1;
        for (int frame = 0; frame < rate_hz; ++frame)
            left *= sea::foam_remains(1.0 / rate_hz, 4.0);
        return left;
    };
    const double ours = std::abs(after_a_second(30) - after_a_second(144));
    const double by_frames = std::abs(naive::faded(30) - naive::faded(144));
    EXPECT_LT(ours, 0.02);
    EXPECT_GT(by_frames, 0.02);
    record("a second of calm at 30 and at 144 Hz", "difference of what is left", by_frames, ours);
}

TEST(HardCase, E2_an_hour_of_storm_covers_no_more_than_all) {
    const sea::FoamLawPtr law = sea::make_foam_law(*sea::storm(), sea::foam_model);
    sea::FoamHistory history(law, 0, 8, sea::interval_us);
    const sea::Keyframe breaking =
        sea::uniform_strains(8, -0.6f); // J = 0.4, below the threshold of 0.6
    naive::SummedFoam summed;
    double most = 0;
    float after_a_minute = 0, largest = 0;
    for (int second = 0; second < 3600; ++second) {
        history.advance(breaking, 1.0);
        summed.advance(0.2, sea::foam_model.gain_per_s, 1.0);
        for (const float ratio : history.ratios()) {
            most = std::max(most, sea::foam_coverage(law->mean_coverage, {&ratio, 1}));
            largest = std::max(largest, ratio);
        }
        if (second == 59)
            after_a_minute = largest;
    }
    EXPECT_EQ(most, 1);
    // The ratio itself is clamped by nothing: what fades keeps it at what breaks here over what breaks on average. e^-15 of the
    // way is left after a minute of decays of 4 s, 3e-7; 2e-5 covers the fitted functions of a tick.
    EXPECT_NEAR(largest / after_a_minute, 1, 1e-6);
    const double steady =
        sea::conditional_breaking(law->threshold, 0, law->cascades[0].others, -0.6, 0, 0) /
        law->cascades[0].mean_breaking;
    EXPECT_NEAR(largest / steady, 1, 2e-5);
    EXPECT_GT(summed.coverage(), 1);
    record("an hour of breaking", "coverage, of all", summed.coverage(), most);
}

} // namespace
} // namespace seaway::hard_cases
