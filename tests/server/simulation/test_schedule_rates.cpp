// SPDX-License-Identifier: Apache-2.0
// Streams of every k-th keyframe, beside that of all of them.
#include <map>
#include <random>
#include <set>
#include <tuple>

#include <gtest/gtest.h>

#include "server/simulation/schedule.h"
#include "tests/server/simulation/simulation_bench.h"

namespace seaway::server {
namespace {

using sea::Field;
using sea::FieldSet;

constexpr FieldSet two_fields{Field::height, Field::height_rate};
constexpr std::size_t two_a_second = 3;
constexpr std::size_t one_a_second = 4;
static_assert(rate_rungs_hz[two_a_second] == 2.0 && rate_rungs_hz[one_a_second] == 1.0);
/// Of a session that takes two keyframes a second.
constexpr Demand rare_demand() {
    return {.cascades = 3u,
            .fields = two_fields,
            .quality = number_of({.compact = true, .rate = two_a_second})};
}

/// A sea whose keyframes come more often than that, a glide from 10 s on, and from 20 s on another one.
std::shared_ptr<SeaCourse> course_with_a_change() {
    const auto course = *SeaCourse::begin(small_scene());
    sea::Scene stormy = course->first()->scene;
    std::get<sea::WindSea>(stormy.sea.systems[0]).wind_speed_10m_mps = 9.0;
    EXPECT_TRUE(course->add(stormy, 10'123'456, 20'234'567));
    return course;
}

EffectPlan plan_of(const RunningSea& sea, bool all, bool rare, std::size_t rate = two_a_second) {
    EffectPlan plan;
    for (const sea::CascadeBudget& cascade : sea.budget.cascades) {
        CascadePlan one{all ? two_fields : FieldSet{}, cascade.interval_us, 0};
        if (rare)
            one.rarer[rate] = two_fields;
        plan.cascades.push_back(one);
    }
    return plan;
}

struct Came {
    TimeUs at_us;
    RateSet rates;
};
using Key = std::tuple<int, std::uint32_t, TimeUs>; ///< cascade, epoch, time

/// All that is due until 25 s, looked for every so often.
std::multimap<Key, Came> stream(const SeaCourse& course, bool all, bool rare) {
    Schedule schedule(course);
    std::multimap<Key, Came> out;
    std::mt19937_64 numbers(3);
    for (TimeUs now_us = 0; now_us < 25'000'000;
         now_us += 1 + static_cast<TimeUs>(numbers() % 90'000))
        for (;;) {
            const Schedule::Due due =
                schedule.take_due(plan_of(*course.at(now_us), all, rare), now_us);
            if (due.keyframes.empty())
                break;
            for (std::size_t i = 0; i < due.keyframes.size(); ++i) {
                const KeyframeRequest& one = due.keyframes[i];
                out.emplace(Key(one.cascade, one.epoch, one.time_us), Came{now_us, due.rates[i]});
            }
        }
    return out;
}

TimeUs rare_interval_us(const RunningSea& sea, int cascade, std::size_t rate = two_a_second) {
    const auto& budget = sea.budget.cascades[static_cast<std::size_t>(cascade)];
    return sea::every_for(budget, rate_rungs_hz[rate]) * budget.interval_us;
}

// Naive: every k-th of a stream that is one interval ahead: for k - 1 intervals its reader has nothing behind now.
TEST(ScheduleRates, who_takes_fewer_keyframes_has_the_two_around_each_moment_in_time) {
    const auto course = course_with_a_change();
    ASSERT_GT(rare_interval_us(*course->first(), 1),
              course->first()->budget.cascades[1].interval_us);
    for (const bool others : {false, true}) {
        std::map<Key, TimeUs> out;
        for (const KeyframeRequest& one : Schedule(*course).current(rare_demand(), 0))
            out[{one.cascade, one.epoch, one.time_us}] = 0;
        for (const auto& [key, came] : stream(*course, others, true))
            if (came.rates[two_a_second]) {
                EXPECT_TRUE(out.emplace(key, came.at_us).second);
                const RunningSeaPtr sea = course->sea(std::get<1>(key));
                EXPECT_EQ(std::get<2>(key) % rare_interval_us(*sea, std::get<0>(key)), 0);
            }
        for (TimeUs t_us = 0; t_us < 24'000'000; t_us += 7'001) {
            const RunningSeaPtr sea = course->at(t_us);
            for (int c = 0; c < 2; ++c) {
                const TimeUs interval_us = rare_interval_us(*sea, c);
                EXPECT_LE(1e6, 2.0 * static_cast<double>(interval_us) + 1);
                const TimeUs first_us = interval_start(t_us, interval_us);
                for (const TimeUs k_us : {first_us, first_us + interval_us}) {
                    const auto found = out.find({c, sea->epoch, k_us});
                    ASSERT_NE(found, out.end()) << sea->epoch << ' ' << k_us;
                    EXPECT_LE(found->second, std::max<TimeUs>(t_us - publish_lead_us + 90'000, 0));
                }
            }
        }
    }
}

// Naive: one stream as far ahead as the slowest needs it: a burst for all others, of whose credit most is lost.
TEST(ScheduleRates, the_stream_of_all_keyframes_is_the_same_whoever_takes_fewer) {
    const auto course = course_with_a_change();
    const auto alone = stream(*course, true, false);
    std::multimap<Key, TimeUs> beside;
    for (const auto& [key, came] : stream(*course, true, true))
        if (came.rates[0])
            beside.emplace(key, came.at_us);
    ASSERT_EQ(alone.size(), beside.size());
    for (auto a = alone.begin(), end = alone.end(); a != end; ++a) {
        const auto same = beside.find(a->first);
        ASSERT_NE(same, beside.end());
        EXPECT_EQ(same->second, a->second.at_us);
    }
}

// Naive: the stream of the sea that never begins goes on where it is, ahead of the beginning of the one that takes over: for an
// interval, a second, its reader has nothing behind now.
TEST(ScheduleRates, who_takes_fewer_has_those_of_a_change_that_takes_over_from_one_to_come) {
    for (int c = 0; c < 2; ++c) {
        const auto course = SeaCourse::begin(small_scene()).value();
        const RunningSeaPtr first = course->first();
        sea::Scene other = first->scene;
        std::get<sea::WindSea>(other.sea.systems[0]).wind_speed_10m_mps = 5.0;
        const TimeUs rare_us = rare_interval_us(*first, c, one_a_second);
        const TimeUs never_us = interval_start(10'000'000, rare_us); // a keyframe lies there
        ASSERT_TRUE(course->add(other, never_us, never_us + 30'000'000));
        // That keyframe is out by then, and the change begins an interval of all keyframes and the lead later.
        const TimeUs now_us = never_us - rare_us - 200'000, start_us = never_us - rare_us / 3;
        const TimeUs all_us = first->budget.cascades[static_cast<std::size_t>(c)].interval_us;
        ASSERT_GT(start_us, now_us + all_us + publish_lead_us);
        Schedule schedule(*course);
        const EffectPlan plan = plan_of(*first, false, true, one_a_second);
        std::map<Key, TimeUs> out;
        const auto take = [&](TimeUs from_us, TimeUs until_us) {
            for (TimeUs at_us = from_us; at_us <= until_us; at_us += 20'000)
                for (Schedule::Due due; !(due = schedule.take_due(plan, at_us)).keyframes.empty();)
                    for (const KeyframeRequest& one : due.keyframes)
                        out.emplace(Key(one.cascade, one.epoch, one.time_us), at_us);
        };
        take(0, now_us);
        ASSERT_TRUE(out.contains({c, 1, never_us}));
        ASSERT_TRUE(course->add(other, start_us, start_us + 30'000'000));
        take(now_us, 15'000'000);
        for (TimeUs t_us = start_us; t_us < 14'000'000; t_us += 7'001) {
            const RunningSeaPtr sea = course->at(t_us);
            const TimeUs interval_us = rare_interval_us(*sea, c, one_a_second);
            const TimeUs before_us = interval_start(t_us, interval_us);
            for (const TimeUs k_us : {before_us, before_us + interval_us}) {
                const auto found = out.find({c, sea->epoch, k_us});
                ASSERT_NE(found, out.end()) << c << ' ' << sea->epoch << ' ' << k_us;
                EXPECT_LE(found->second, t_us) << k_us;
            }
        }
    }
}

// Keyframes of those who take fewer are some of those that others have: they wait in the store.
TEST(ScheduleRates, nothing_is_computed_twice_for_who_takes_fewer_keyframes) {
    std::uint64_t transforms[2];
    std::size_t rarer = 0;
    for (const bool rare : {false, true}) {
        Bench bench;
        bench.subscriptions.set(1, {.cascades = 3u, .fields = two_fields});
        if (rare)
            bench.subscriptions.set(2, rare_demand());
        for (int step = 0; step < 100; ++step)
            bench.advance(50'000);
        transforms[rare ? 1 : 0] = bench.simulation->counters().synthesis.transforms;
        const std::scoped_lock lock(bench.mutex);
        rarer = bench.published_rarer.size();
    }
    EXPECT_GT(rarer, 10u);
    // Two seconds ahead of the others at the end, at most: what they have not asked for yet.
    EXPECT_GE(transforms[1], transforms[0]);
    EXPECT_LE(transforms[1], transforms[0] + 2 * 2 * 4);
}

} // namespace
} // namespace seaway::server
