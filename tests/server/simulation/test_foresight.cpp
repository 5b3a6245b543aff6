// SPDX-License-Identifier: Apache-2.0
// What is made ready for whom: those who ask about now over and over, and nobody else.
#include "tests/server/simulation/simulation_bench.h"
#include "tests/support/eventually.h"

namespace seaway::server {
namespace {

constexpr TimeUs foreseen_us = Foresight::ahead_us, foreseen_step_us = Foresight::step_us;

TEST(Foresight, nothing_is_made_ready_for_who_asks_once_or_for_a_clock_that_stands) {
    Foresight foresight;
    for (int i = 0; i < 3; ++i)
        EXPECT_FALSE(foresight.asked(5'000'000, 5'000'000)) << i;
}

TEST(Foresight, who_asks_about_now_again_has_what_follows_made_ready_once) {
    Foresight foresight;
    EXPECT_FALSE(foresight.asked(0, 0));
    EXPECT_EQ(foresight.asked(10'000, 10'000), 10'000 + foreseen_us);
    EXPECT_FALSE(foresight.asked(10'001, 10'001)) << "it is ready";
    EXPECT_FALSE(foresight.asked(9'000, 12'000)) << "another who asks about a little earlier";
    EXPECT_EQ(foresight.asked(10'000 + foreseen_step_us, 30'000),
              10'000 + foreseen_step_us + foreseen_us);
}

TEST(Foresight, who_asks_about_other_times_or_seldom_has_nothing_made_ready) {
    Foresight foresight;
    for (TimeUs now_us = 0; now_us < second_us; now_us += 10'000) {
        EXPECT_FALSE(foresight.asked(now_us + 3'600'000'000, now_us));
        EXPECT_FALSE(foresight.asked(now_us - 3'600'000'000, now_us));
    }
    for (TimeUs now_us = 0; now_us < 20 * second_us; now_us += 2 * second_us)
        EXPECT_FALSE(foresight.asked(now_us, now_us)) << now_us;
}

TEST(Foresight, it_goes_on_where_the_clock_goes_back_and_ends_where_time_does) {
    Foresight foresight;
    EXPECT_FALSE(foresight.asked(100 * second_us, 100 * second_us));
    EXPECT_TRUE(foresight.asked(100 * second_us + 1, 100 * second_us + 1));
    EXPECT_FALSE(foresight.asked(0, 0));
    EXPECT_TRUE(foresight.asked(1, 1));
    Foresight last;
    EXPECT_FALSE(last.asked(sea::time_us_max - 1, sea::time_us_max - 1));
    EXPECT_FALSE(last.asked(sea::time_us_max, sea::time_us_max));
}

// Naive: the first who asks after a keyframe's time waits for its spline.
TEST(Foresight, splines_of_the_stream_are_there_before_anybody_asks_about_their_times) {
    Bench bench;
    bench.subscriptions.set(1, {3u, sea::surface_fields});
    bench.now_us = bench.sea->budget.cascades[1].interval_us - foreseen_us / 2;
    bench.settle();
    for (int i = 0; i < 3; ++i) {
        bench.answer({{1, 2, bench.now_us}});
        bench.advance(1000);
    }
    const auto splined = [&] {
        const StoreCounters store = bench.simulation->counters().store;
        const std::size_t raw = store.keyframes * 6u * 64 * 64 * sizeof(float);
        return (store.bytes - raw) / sea::SplineMap::bytes_of(64);
    };
    const TimeUs times_us[] = {bench.now_us, bench.now_us + foreseen_us};
    const Demand all{3u, sea::surface_fields};
    const std::size_t now = keyframes_around(*bench.course, {times_us, 1}, all).size();
    const std::size_t expected = keyframes_around(*bench.course, times_us, all).size();
    ASSERT_GT(expected, now) << "a keyframe begins between";
    EXPECT_TRUE(tests::eventually([&] { return splined() >= expected; }));
    // What the server asks itself is not counted.
    const std::uint64_t questions = bench.simulation->counters().questions;
    bench.now_us += 3 * foreseen_step_us;
    bench.answer({{1, 2, bench.now_us}});
    EXPECT_EQ(bench.simulation->counters().questions, questions + 1);
}

} // namespace
} // namespace seaway::server
