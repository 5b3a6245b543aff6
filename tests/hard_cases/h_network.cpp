// SPDX-License-Identifier: Apache-2.0
// Hard cases of networks: clocks, counters, a change of the sea that arrives late.
#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "client/held/keyframe_ring.h"
#include "client/link/clock.h"
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

// Replies take 10 to 30 ms each way, evenly: what the filter makes of it is milliseconds off. 1 cm is the
// case's, for a sea of Hs 4 m and Tp 8 s.
TEST(HardCase, H1_clocks_50_ms_apart_show_the_same_sea) {
    const TimeUs ahead = 50'000;
    client::ClockFilter clock;
    std::mt19937 random(1);
    std::uniform_int_distribution<TimeUs> delay(10'000, 30'000);
    TimeUs sea_now = 100'000'000;
    for (int reply = 0; reply < 20; ++reply, sea_now += 500'000) {
        const TimeUs there = delay(random), back = delay(random);
        clock.add(sea_now - there + ahead, sea_now + back + ahead, sea_now);
    }
    const TimeUs shown = clock.now(sea_now + ahead), by_local_clock = sea_now + ahead;
    const sea::DirectSum sum(testing::realized(testing::swell_sea(4.0, 8.0), {{800.0, 64}}));
    const auto rms_difference = [&](TimeUs time) {
        double squares = 0;
        for (int i = 0; i < 100; ++i) {
            const double x = 31.0 * i, y = 17.0 * i;
            squares += std::pow(sum.at(x, y, time).height - sum.at(x, y, sea_now).height, 2);
        }
        return std::sqrt(squares / 100);
    };
    EXPECT_LT(rms_difference(shown), 0.01);
    EXPECT_GT(rms_difference(by_local_clock), 0.01);
    record("Hs 4 m, Tp 8 s, a clock 50 ms ahead", "rms difference of two nodes, m",
           rms_difference(by_local_clock), rms_difference(shown));
}

client::HeldKeyframePtr keyframe_at(TimeUs time_us) {
    sea::Keyframe made;
    made.time_us = time_us;
    made.size = 4;
    made.length_m = 50;
    made.fields = {sea::Field::height};
    made.values.resize(made.plane_size());
    return std::make_shared<const client::HeldKeyframe>(std::move(made),
                                                        client::HeldKeyframe::FieldErrors{});
}

// 300 orders by lot of 16 keyframes, each once to three times: what is held is a matter of which have come. Naive: what
// came last is the newest, and playback runs backward.
TEST(HardCase,
     H2_whatever_order_keyframes_come_in_and_how_often_the_sea_is_that_of_those_that_have) {
    const TimeUs interval_us = 100'000;
    std::mt19937 random(2);
    int ours = 0, backward = 0, arrivals = 0;
    for (int order = 0; order < 300; ++order) {
        std::vector<TimeUs> coming;
        for (TimeUs n = 0; n < 16; ++n)
            coming.insert(coming.end(), 1 + random() % 3, n * interval_us);
        std::shuffle(coming.begin(), coming.end(), random);
        client::KeyframeRing ring;
        std::set<TimeUs> there;
        for (const TimeUs time_us : coming) {
            backward += !there.empty() && time_us < *there.rbegin();
            ++arrivals;
            ring.insert(keyframe_at(time_us));
            there.insert(time_us);
            ASSERT_EQ(ring.size(0), there.size());
            ours += ring.newest(0)->keyframe().time_us != *there.rbegin();
            for (TimeUs n = 0; n < 15; ++n) {
                const TimeUs before = n * interval_us, after = before + interval_us;
                const auto pair =
                    ring.around(0, 0, before + 1 + static_cast<TimeUs>(random() % 99'999),
                                interval_us, {sea::Field::height});
                ASSERT_TRUE(pair);
                ASSERT_EQ(pair->covers, there.contains(before) && there.contains(after));
                if (pair->covers) {
                    ASSERT_EQ(pair->before->keyframe().time_us, before);
                    ASSERT_EQ(pair->after->keyframe().time_us, after);
                }
            }
        }
    }
    EXPECT_EQ(ours, 0);
    EXPECT_GT(backward, 0);
    record("300 orders of 16 keyframes, some twice or thrice",
           "share of arrivals at which time runs backward",
           static_cast<double>(backward) / arrivals, static_cast<double>(ours) / arrivals);
}

// A keyframe of another is told by its 64 bits of microseconds. 30 frames each around where numbers of 16 bits wrap, and
// where microseconds of 31 and of 32 would.
TEST(HardCase, H3_no_frame_is_taken_for_an_old_one_where_counters_wrap) {
    const TimeUs interval_us = 100'000;
    int ours = 0, by_number = 0;
    for (const TimeUs wrap_us : {65'536 * interval_us, TimeUs{1} << 31, TimeUs{1} << 32}) {
        const TimeUs first = wrap_us / interval_us - 6;
        client::KeyframeRing ring;
        auto last_number = static_cast<std::uint16_t>(first - 1);
        for (TimeUs frame = first; frame < first + 30; ++frame) {
            const auto number = static_cast<std::uint16_t>(frame);
            by_number += !naive::newer(number, last_number);
            last_number = std::max(last_number, number);
            ring.insert(keyframe_at(frame * interval_us));
            ours += ring.newest(0)->keyframe().time_us != frame * interval_us;
        }
    }
    EXPECT_EQ(ours, 0);
    EXPECT_GT(by_number, 0);
    record("30 frames from number 65 530 on, and around 2^31 and 2^32 us", "new ones taken for old",
           by_number, ours);
}

/// When the change begins for a node that was told of it by these bytes.
TimeUs stated_start(const protocol::Bytes& bytes) {
    protocol::MessageReader reader(protocol::Sender::server);
    const auto message = reader.read(bytes);
    return protocol::values(*(*message)->body_as_SeaState()).start_time_us;
}

// A sea state says from which time on it holds (SeaState.start_time_us), and a sea is a function of its
// states and the time. One node hears of the change in time, the other three seconds late, when it draws
// both seas for itself, and looks at later times first; after that both have the same sea, to the bit. A
// node that took another start for its own would not: the last lines.
TEST(HardCase, H5_nodes_that_hear_of_a_change_at_different_times_have_the_same_sea_after_it) {
    sea::SeaState stronger = testing::windy_sea();
    std::get<sea::WindSea>(stronger.systems[0]).wind_speed_10m_mps = 12.0;
    stronger.depth_m = 30.0; // frequencies change too, and with them phases
    const TimeUs glide = 10'000'000, early = 48'000'000, late = 53'000'000;
    protocol::SeaStateValues told = protocol::tests::some_state();
    told.start_time_us = 50'000'000;
    const protocol::Bytes bytes = protocol::sea_state(told);
    // A node's own change, and the heights that it then sees.
    const auto node = [&](TimeUs start) {
        const RealizationPtr calm = testing::realized(testing::windy_sea(), {{200.0, 32}});
        const RealizationPtr rough = testing::realized(stronger, {{200.0, 32}});
        return *SeaTransition::create(calm, rough, start, start + glide);
    };
    const auto height = [](const SeaTransition& change, TimeUs time, int i) {
        return sea::DirectSum(change.at(time)).at(3.0 * i, 5.0 * i, time).height;
    };
    const TimeUs times[] = {late, late + 4'000'000, late + 60'000'000};
    const SeaTransition first = node(stated_start(bytes));
    double before_the_other[3][10];
    for (int t = 0; t < 3; ++t)
        for (int i = 0; i < 10; ++i)
            before_the_other[t][i] = height(first, times[t], i);
    const SeaTransition second = node(stated_start(bytes));
    const SeaTransition naive_first = node(naive::change_starts_us(early, told.start_time_us));
    const SeaTransition naive_second = node(naive::change_starts_us(late, told.start_time_us));
    EXPECT_EQ(first.start_us(), 50'000'000);
    double ours = 0, by_arrival = 0;
    for (int t = 2; t >= 0; --t)
        for (int i = 0; i < 10; ++i) {
            const TimeUs time = times[t];
            ours = std::max(ours, std::abs(before_the_other[t][i] - height(second, time, i)));
            by_arrival = std::max(
                by_arrival, std::abs(height(naive_first, time, i) - height(naive_second, time, i)));
        }
    EXPECT_EQ(ours, 0.0);
    EXPECT_GT(by_arrival, 0.01);
    const SeaTransition elsewhere = node(told.start_time_us + 100'000);
    EXPECT_NE(height(elsewhere, late, 0), height(second, late, 0));
    EXPECT_EQ(height(second, early, 0), height(elsewhere, early, 0)); // calm before either
    record("wind of 10 to 12 m/s, told 2 s early and 3 s late",
           "largest difference of two nodes, m", by_arrival, ours);
}

} // namespace
} // namespace seaway::hard_cases
