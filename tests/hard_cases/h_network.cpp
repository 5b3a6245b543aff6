// SPDX-License-Identifier: Apache-2.0
// Hard case H5: a change of the sea that arrives late.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "protocol/messages.h"
#include "sea/waves/transition.h"
#include "tests/hard_cases/record.h"
#include "tests/naive/time.h"
#include "tests/protocol/sample_messages.h"
#include "tests/sea/sea_fixture.h"

namespace seaway::hard_cases {
namespace {

using sea::RealizationPtr;
using sea::SeaTransition;
using sea::TimeUs;

/// When the change begins for a node that was told of it by these bytes.
TimeUs stated_start(const protocol::Bytes& bytes) {
    protocol::MessageReader reader(protocol::Sender::server);
    const auto message = reader.read(bytes);
    return protocol::values(*(*message)->body_as_SeaState()).start_time_us;
}

// A sea state says from which time on it holds (SeaState.start_time_us), and a sea is a function of its
// states and the time. One node hears of the change in time, the other three seconds late; after that
// both have the same sea, to the bit.
TEST(HardCase, H5_nodes_that_hear_of_a_change_at_different_times_have_the_same_sea_after_it) {
    const RealizationPtr calm = testing::realized(testing::windy_sea(), {{200.0, 32}});
    sea::SeaState stronger = testing::windy_sea();
    std::get<sea::WindSea>(stronger.systems[0]).wind_speed_10m_mps = 12.0;
    stronger.depth_m = 30.0; // frequencies change too, and with them phases
    const RealizationPtr rough = testing::realized(stronger, {{200.0, 32}});
    const TimeUs glide = 10'000'000, early = 48'000'000, late = 53'000'000;
    protocol::SeaStateValues told = protocol::tests::some_state();
    told.start_time_us = 50'000'000;
    const protocol::Bytes bytes = protocol::sea_state(told);
    // A node's own change, and the heights that it then sees.
    const auto node = [&](TimeUs start) {
        return *SeaTransition::create(calm, rough, start, start + glide);
    };
    const auto height = [](const SeaTransition& change, TimeUs time, int i) {
        return sea::DirectSum(change.at(time)).at(3.0 * i, 5.0 * i, time).height;
    };
    const SeaTransition first = node(stated_start(bytes)), second = node(stated_start(bytes));
    const SeaTransition naive_first = node(naive::change_starts_us(early, told.start_time_us));
    const SeaTransition naive_second = node(naive::change_starts_us(late, told.start_time_us));
    EXPECT_EQ(first.start_us(), 50'000'000);
    double ours = 0, by_arrival = 0;
    for (const TimeUs time : {late, late + 4'000'000, late + 60'000'000})
        for (int i = 0; i < 10; ++i) {
            ours = std::max(ours, std::abs(height(first, time, i) - height(second, time, i)));
            by_arrival = std::max(
                by_arrival, std::abs(height(naive_first, time, i) - height(naive_second, time, i)));
        }
    EXPECT_EQ(ours, 0.0);
    EXPECT_GT(by_arrival, 0.01);
    record("wind of 10 to 12 m/s, told 2 s early and 3 s late",
           "largest difference of two nodes, m", by_arrival, ours);
}

} // namespace
} // namespace seaway::hard_cases
