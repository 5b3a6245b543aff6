// SPDX-License-Identifier: Apache-2.0
// When a client makes maps of waves: where so much is asked that sums would cost more, neither sooner nor later.
#include "tests/client/wave_maps_of.h"

namespace seaway::client {
namespace {

/// What all takes, of what is listed.
double machine_takes = 1;

/// What a thread has worked, for which each making of a keyframe takes as long as is expected of one of 64 x 64.
double worked_by_the_list_s() {
    static double s = 0;
    return s += machine_takes * 1e-6 * 64 * 64 * map_point_us;
}

// Whichever way it is asked: a point now and then is never worth four keyframes, what was spent is spent once, and no call waits for
// more than one.
TEST_F(WaveMapsOf, a_sea_are_made_one_a_call_once_sums_have_taken_as_much) {
    WaveMaps maps(state, sea_off_by({}), worked_by_the_list_s);
    const WavePrices prices(*state, *sea_off_by({}));
    HeldSurfaces::Lent surface;
    const double keyframes_us = 2 * (prices.keyframe_us(0) + prices.keyframe_us(1));
    const WaveBatch one{.time_us = 1000};
    for (int i = 0; i < 9; ++i) {
        ASSERT_FALSE(maps.lend(one, surface)) << i;
        maps.summed(one, keyframes_us / 10);
    }
    EXPECT_EQ(maps.made(), 0u);
    ASSERT_FALSE(maps.lend(one, surface)) << "not quite";
    maps.summed(one, keyframes_us / 10);
    for (std::uint64_t made = 1; made <= 2 * cascades; ++made) {
        EXPECT_EQ(maps.lend(one, surface), made == 2 * cascades) << "two a cascade";
        EXPECT_EQ(maps.made(), made);
    }
    for (int i = 0; i < 100; ++i)
        EXPECT_TRUE(maps.lend({.time_us = 2000 * i % interval_us}, surface)) << "of the same ones";
    EXPECT_EQ(maps.made(), 2 * cascades);
    // Of the next interval one of each pair is there already, and the others are paid for by what these have spared.
    const WaveBatch next{.time_us = interval_us + 1};
    EXPECT_FALSE(maps.lend(next, surface)) << "one of two";
    EXPECT_TRUE(maps.lend(next, surface));
    EXPECT_EQ(maps.made(), 3 * cascades);
}

class WavePricesOf : public WaveMapsOf {
  protected:
    WavePrices prices{*state, *sea_off_by({})};
    const double keyframes_us = prices.keyframe_us(0) + prices.keyframe_us(1); ///< one a cascade
    const double lay_out_us = prices.sum_us({.points = 0});                    ///< for one time
    const TimeSpan cell = cell_of(0), next = cell_of(1), third = cell_of(2), far = cell_of(10);

    TimeSpan cell_of(sea::TimeUs n) const { return {n * interval_us, (n + 1) * interval_us}; }
    /// Single points, until they have taken this.
    void sum_in(const TimeSpan& in, double until_us) {
        const double one_us = prices.sum_us({});
        for (double took_us = 0; took_us < until_us; took_us += one_us)
            prices.summed(in, {}, one_us, lay_out_us);
    }
};

// Naive: what sums have paid goes from cell to cell whatever keyframes cost there: one point a frame, which they spare nothing, has some made
// each second or two, and waits for them.
TEST_F(WavePricesOf, sums_pay_for_the_time_that_follows_with_what_they_take_beyond_its_keyframes) {
    const WaveBatch one; // 0.07 of keyframes_us
    sum_in(cell, 0.9 * keyframes_us);
    EXPECT_FALSE(prices.pays(next, one, 0.2 * keyframes_us)) << "nothing is left";
    sum_in(next, 1.5 * keyframes_us);
    EXPECT_TRUE(prices.pays(third, one, 0.5 * keyframes_us));
    EXPECT_FALSE(prices.pays(third, one, 0.7 * keyframes_us)) << "nor is there more";
    EXPECT_FALSE(prices.pays(far, one, 0.5 * keyframes_us)) << "time does not run there";
    prices.spend(third, 0.5 * keyframes_us);
    EXPECT_FALSE(prices.pays(third, one, 0.2 * keyframes_us)) << "once";
}

// Where maps answer all there are no sums to tell what they would take.
TEST_F(WavePricesOf,
       what_keyframes_spare_pays_for_those_that_follow_and_for_no_more_than_all_of_a_cell) {
    const WaveBatch many_points{.points = many};
    prices.spend(cell, keyframes_us);
    prices.spared(cell, many_points);
    EXPECT_TRUE(prices.pays(next, {}, 2 * keyframes_us));
    EXPECT_FALSE(prices.pays(next, {}, 2.2 * keyframes_us))
        << "though they spared a thousand times that";
}

// Places that are no numbers, and a time of a glide that is asked about again, take next to nothing.
TEST_F(WavePricesOf, sums_that_cost_nothing_do_not_make_all_sums_cheap) {
    const WaveBatch one;
    const double before_us = prices.sum_us(one);
    for (int i = 0; i < 10'000; ++i)
        prices.summed(far, one, 0, 0);
    EXPECT_GT(prices.sum_us(one), 0.49 * before_us);
}

TEST_F(WavePricesOf, sums_of_few_waves_pay_for_no_keyframe) {
    auto few = std::make_shared<sea::Realization>(*waves);
    for (sea::CascadeModes& modes : few->cascades)
        for (std::size_t i = 0; i < modes.h0.size(); ++i)
            modes.h0[i] *= i < 10 ? 1.0 : 0.0;
    WavePrices of_few(*state, RebuiltSea(few, *state, {}));
    of_few.summed(cell, {}, 1e9, 0);
    EXPECT_FALSE(of_few.pays(cell, {}, 1)) << "a point from maps takes longer than such a sum";
}

TEST_F(WavePricesOf, sums_and_keyframes_follow_what_they_take) {
    const WaveBatch one{.points = 1}, many_times{.points = 10, .times = 10};
    const double before_us = prices.sum_us(one), keyframe_us = prices.keyframe_us(1);
    EXPECT_NEAR(prices.sum_us(many_times), 10 * before_us, 1e-9 * before_us);
    EXPECT_LT(prices.sum_us({.points = 10}), 6.5 * before_us) << "which share what a time takes";
    EXPECT_LT(prices.sum_us({.cascades = 1}), before_us);
    for (int i = 0; i < 60; ++i) { // a steep sea, whose sheets are looked for
        prices.summed(cell, one, 10 * before_us, lay_out_us);
        prices.made(1, 30 * keyframe_us);
    }
    EXPECT_NEAR(prices.sum_us(one), 10 * before_us, 0.1 * before_us);
    EXPECT_NEAR(prices.keyframe_us(1), 30 * keyframe_us, 0.1 * keyframe_us);
    prices.made(1, 1e9);
    EXPECT_LT(prices.keyframe_us(1), 60 * keyframe_us) << "who lost the processor once";
}

// Naive: keyframes are thought as cheap as they were elsewhere until one has been made, where sums take what they take here: on a slow
// machine, or beside others on a busy one, one point a frame has 30 MB of maps made that never pay.
TEST_F(WavePricesOf, keyframes_that_nobody_has_made_yet_cost_as_much_more_as_laying_out_waves) {
    const double one_us = prices.sum_us({}), keyframe_us = prices.keyframe_us(0);
    for (int i = 0; i < 60; ++i)
        prices.summed(cell, {}, 3 * one_us, 3 * lay_out_us);
    EXPECT_NEAR(prices.keyframe_us(0), 3 * keyframe_us, 0.01 * keyframe_us);
    for (int i = 0; i < 60; ++i) // where all takes three times as long, this is what is listed
        prices.made(0, 6 * keyframe_us);
    EXPECT_NEAR(prices.keyframe_us(0), 6 * keyframe_us, 0.01 * keyframe_us);
    for (int i = 0; i < 60; ++i) // nobody else runs now
        prices.summed(cell, {}, one_us, lay_out_us);
    EXPECT_NEAR(prices.keyframe_us(0), 2 * keyframe_us, 0.01 * keyframe_us);
    for (int i = 0; i < 60; ++i)
        prices.summed(cell, {}, one_us, 0);
    EXPECT_NEAR(prices.keyframe_us(0), 2 * keyframe_us, 0.01 * keyframe_us) << "not known";
}

/// Frames of a point each, as far apart as makes their sums take `share` of what keyframes of their time cost.
class WaveFrames : public WavePricesOf {
  protected:
    static constexpr int intervals = 200;
    struct Took {
        double us = 0;
        double best_us = 0; ///< all sums, or keyframes from the first frame on
        std::uint64_t made = 0;
        std::uint64_t most_made_at_once = 0;
    };
    /// `steep`: so much more do sums take than is listed, and laying out waves does not.
    Took frames(double share, double machine = 1, double steep = 1) {
        machine_takes = machine;
        WaveMaps maps(state, sea_off_by({}), worked_by_the_list_s);
        const double sum_us = machine * steep * prices.sum_us({});
        const double made_us = machine * prices.keyframe_us(0);
        const double span_us = 1.0 * intervals * interval_us;
        const double apart_us =
            sum_us * static_cast<double>(interval_us) / (share * cascades * made_us);
        Took took;
        for (double time_us = 0; time_us < span_us; time_us += apart_us) {
            const WaveBatch now{.time_us = static_cast<sea::TimeUs>(time_us)};
            HeldSurfaces::Lent surface;
            if (!maps.lend(now, surface)) {
                maps.summed(now, sum_us, machine * lay_out_us);
                took.us += sum_us;
            }
            took.best_us += sum_us;
            took.most_made_at_once = std::max(took.most_made_at_once, maps.made() - took.made);
            took.made = maps.made();
        }
        took.us += static_cast<double>(took.made) * made_us;
        took.best_us = std::min(took.best_us, (intervals + 1) * cascades * made_us);
        machine_takes = 1;
        return took;
    }
};

// One point of the gale at 60 frames a second is 0.74: a sum of 258 us, and keyframes of 3.3 ms each 0.8, 0.5 and 0.32 s. On another
// machine 0.57: 390 us, and 6.5 ms.
TEST_F(WaveFrames, whose_sums_take_less_than_keyframes_have_none_made) {
    for (const double machine : {1.0, 0.5, 3.0})
        for (const double share : {0.1, 0.5, 0.74, 0.9}) {
            EXPECT_EQ(frames(share, machine).made, 0u) << share << " of " << machine;
            EXPECT_EQ(frames(share, machine, 2).made, 0u) << share << " of " << machine;
        }
}

// What is lost is sums until those have come to the first keyframes: of sums that take little more than keyframes some twenty intervals.
TEST_F(WaveFrames,
       whose_sums_take_more_have_keyframes_made_and_take_a_third_more_than_the_best_at_most) {
    for (const double machine : {1.0, 0.5, 3.0})
        for (const double share : {1.2, 2.0, 5.0, 20.0}) {
            const Took took = frames(share, machine);
            EXPECT_GT(took.made, intervals * cascades * 4 / 5) << share << " of " << machine;
            EXPECT_LT(took.us, 1.33 * took.best_us) << share << " of " << machine;
            EXPECT_EQ(took.most_made_at_once, 1u)
                << share << ": a frame waits for no more than one";
        }
    const Took steep = frames(2, 1, 10);
    EXPECT_GT(steep.made, intervals * cascades * 4 / 5);
    EXPECT_LT(steep.us, 1.33 * steep.best_us);
}

} // namespace
} // namespace seaway::client
