// SPDX-License-Identifier: Apache-2.0
// What a client lets go of the waves that servers sent to it, so that no server fills its memory.
#include "client/wave_room.h"

#include <limits>
#include <memory>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sea/waves/realization.h"

namespace seaway::client {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(WaveRoom, is_800_mb_of_points_of_an_amplitude_and_a_frequency) {
    using Modes = sea::CascadeModes;
    EXPECT_EQ(sizeof(decltype(Modes::h0)::value_type) + sizeof(decltype(Modes::rate)::value_type),
              wave_point_bytes);
    EXPECT_LT(wave_points_max * wave_point_bytes, 810'000'000u);
    EXPECT_GT(wave_points_max * wave_point_bytes, 790'000'000u) << "what docs/security.md says";
}

TEST(WaveRoom,
     a_sea_is_as_far_as_its_beginning_or_that_of_the_next_and_at_no_distance_while_it_runs) {
    const auto from = [](std::uint32_t epoch, sea::TimeUs start_time_us) {
        auto state = std::make_shared<SeaState>();
        state->epoch = epoch;
        state->start_time_us = start_time_us;
        return state;
    };
    const std::vector<SeaStatePtr> seas{from(7, 0), from(3, 100),
                                        from(5, 250)}; // not by their number
    EXPECT_EQ(away_us(seas, 130, 7), 30) << "over since";
    EXPECT_EQ(away_us(seas, 130, 3), 0) << "it runs";
    EXPECT_EQ(away_us(seas, 130, 5), 120) << "to come";
    EXPECT_EQ(away_us(seas, 1000, 5), 0) << "the last has no end";
    EXPECT_EQ(away_us(seas, 130, 4), std::numeric_limits<double>::infinity())
        << "nobody told of it";
}

TEST(WaveRoom, lets_nothing_go_while_there_is_some) {
    EXPECT_THAT(waves_to_let_go({}, 0, 10), IsEmpty());
    EXPECT_THAT(waves_to_let_go({{1, 4, 7e6}, {2, 3, 0}}, 3, 10), IsEmpty()) << "the last point";
    EXPECT_THAT(waves_to_let_go({{1, wave_points_max / 2, 0}}, wave_points_max / 2), IsEmpty());
}

TEST(WaveRoom, is_made_by_those_furthest_from_now_and_no_more_of_them_than_it_takes) {
    constexpr double never = std::numeric_limits<double>::infinity();
    const std::vector<WavesHeld> held{{1, 3, 2e6}, {2, 3, 0}, {3, 3, 9e6}, {4, 3, never}};
    EXPECT_THAT(waves_to_let_go(held, 1, 12), ElementsAre(4)) << "a sea that is over";
    EXPECT_THAT(waves_to_let_go(held, 3, 12), ElementsAre(4)) << "what it leaves is just enough";
    EXPECT_THAT(waves_to_let_go(held, 4, 12), ElementsAre(4, 3));
    EXPECT_THAT(waves_to_let_go(held, 7, 12), ElementsAre(4, 3, 1));
    EXPECT_THAT(waves_to_let_go(held, 13, 12), ElementsAre(4, 3, 1, 2)) << "that of now last";
    EXPECT_THAT(waves_to_let_go({{1, 3, 2e6}, {2, 3, 2e6}}, 1, 5), ElementsAre(1)) << "the older";
}

// Three of the largest seas and the next: as many as of four fit, the fifth does not.
TEST(WaveRoom, of_the_largest_seas_there_may_be_four_fit) {
    std::vector<WavesHeld> held{{1, sea::spectrum_modes_max, 0},
                                {2, sea::spectrum_modes_max, 1},
                                {3, sea::spectrum_modes_max, 2}};
    EXPECT_THAT(waves_to_let_go(held, sea::spectrum_modes_max), IsEmpty());
    held.push_back({4, sea::spectrum_modes_max, 3});
    EXPECT_THAT(waves_to_let_go(held, sea::spectrum_modes_max), ElementsAre(4));
}

} // namespace
} // namespace seaway::client
