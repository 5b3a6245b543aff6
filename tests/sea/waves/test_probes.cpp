// SPDX-License-Identifier: Apache-2.0
// Probes tell a sea from every other one that a client may have made by mistake.
#include <cmath>
#include <limits>
#include <set>

#include <gtest/gtest.h>

#include "sea/waves/probes.h"
#include "tests/sea/sea_fixture.h"

namespace seaway::sea {
namespace {

using testing::realized;
using testing::three_cascades;
using testing::windy_sea;

constexpr TimeUs day_us = 86'400'000'000;

/// How far the sea that a mistake makes of the right one is from the right one's probes.
template <class Mistake>
double difference_m(const Mistake& mistake) {
    const RealizationPtr right = realized(windy_sea(), three_cascades);
    auto wrong = std::make_shared<Realization>(*right);
    mistake(*wrong);
    const ProbeDifference off =
        compare(DirectSum(wrong), make_probes(DirectSum(right), 1'000'000'000));
    return std::max(off.height_m, off.displacement_m);
}

TEST(Probes, are_sixteen_spread_over_a_day_and_both_sides_of_the_origin_beyond_a_tile) {
    constexpr TimeUs from_us = -5'000'000;
    const std::vector<Probe> probes =
        make_probes(DirectSum(realized(windy_sea(), three_cascades)), from_us);
    ASSERT_EQ(probes.size(), 16u);
    std::set<int> columns, rows, hours;
    for (const Probe& probe : probes) {
        EXPECT_GE(probe.time_us, from_us);
        EXPECT_LT(probe.time_us, from_us + day_us);
        // In eighths of what they are spread over: 16 points that are spread evenly leave none out.
        columns.insert(static_cast<int>(std::floor(probe.x_m / 512.0)));
        rows.insert(static_cast<int>(std::floor(probe.y_m / 512.0)));
        hours.insert(static_cast<int>((probe.time_us - from_us) / (day_us / 8)));
    }
    const std::set<int> eighths{-4, -3, -2, -1, 0, 1, 2, 3}, times{0, 1, 2, 3, 4, 5, 6, 7};
    EXPECT_EQ(columns, eighths);
    EXPECT_EQ(rows, eighths);
    EXPECT_EQ(hours, times);
}

TEST(Probes, of_a_sea_with_a_loop_lie_within_it) {
    SeaState state = windy_sea();
    state.loop_period_s = 60;
    for (const Probe& probe : make_probes(DirectSum(realized(state, three_cascades)), 7)) {
        EXPECT_GE(probe.time_us, 7);
        EXPECT_LT(probe.time_us, 60'000'007);
    }
}

// A change may begin within a day of the end of all times; beyond it nobody takes a time.
TEST(Probes, of_a_sea_that_begins_near_the_end_of_all_times_lie_before_it) {
    SeaState looped = windy_sea();
    looped.loop_period_s = 1e6;
    for (const SeaState& state : {windy_sea(), looped})
        for (const TimeUs before_us : {TimeUs{0}, TimeUs{50'000'000}})
            for (const Probe& probe :
                 make_probes(DirectSum(realized(state, three_cascades)), time_us_max - before_us)) {
                EXPECT_GE(probe.time_us, time_us_max - before_us);
                EXPECT_LE(probe.time_us, time_us_max);
            }
}

TEST(Probes, are_met_by_the_same_sea_to_the_bit_and_by_one_made_again_within_their_error) {
    EXPECT_EQ(difference_m([](Realization&) {}), 0);
    // Another libm: last places of amplitudes and frequencies.
    EXPECT_LE(difference_m([](Realization& sea) {
                  for (CascadeModes& cascade : sea.cascades)
                      for (std::size_t i = 0; i < cascade.h0.size(); ++i) {
                          cascade.h0[i] *= 1.0 + 4e-16;
                          cascade.rate[i] += 1;
                      }
              }),
              probe_error_m);
}

// Each is a mistake that clients make; the smallest is a thousand times what is allowed.
TEST(Probes, show_every_mistake_that_a_client_makes_of_a_sea) {
    const auto every_mode = [](Realization& sea, const auto& change) {
        for (CascadeModes& cascade : sea.cascades)
            for (std::size_t i = 0; i < cascade.h0.size(); ++i)
                change(cascade.h0[i], cascade.rate[i]);
    };
    constexpr double seen_m = 1e3 * probe_error_m;
    EXPECT_GT(
        difference_m([](Realization& sea) { sea = *realized(windy_sea(43), three_cascades); }),
        seen_m)
        << "another seed";
    EXPECT_GT(difference_m([&](Realization& sea) {
                  every_mode(sea, [](auto& h0, Rate&) { h0 = std::conj(h0); });
              }),
              seen_m)
        << "the sign of phases";
    EXPECT_GT(difference_m([](Realization& sea) {
                  for (CascadeModes& cascade : sea.cascades)
                      cascade.depth_m = deep_water_m;
              }),
              seen_m)
        << "displacement of deep water";
    EXPECT_GT(difference_m([&](Realization& sea) {
                  every_mode(sea, [](auto&, Rate& rate) {
                      rate = rate_from_omega(
                          static_cast<double>(static_cast<float>(omega_from_rate(rate))));
                  });
              }),
              seen_m)
        << "frequencies in single precision";
    EXPECT_GT(difference_m([](Realization& sea) { sea.cascades.pop_back(); }), seen_m)
        << "without its shortest waves";
}

// Naive: the largest of two numbers by <, which is false for what is none.
TEST(Probes, what_is_no_number_is_never_the_same_sea) {
    const RealizationPtr sea = realized(windy_sea(), three_cascades);
    std::vector<Probe> probes = make_probes(DirectSum(sea), 0);
    probes[3].height_m = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(compare(DirectSum(sea), probes).within(1e9, 1e9));
}

} // namespace
} // namespace seaway::sea
