// SPDX-License-Identifier: Apache-2.0
// The schedule alone: times in, keyframes out.
#include <map>
#include <random>
#include <tuple>

#include <gtest/gtest.h>

#include "server/simulation/schedule.h"
#include "tests/server/simulation/simulation_bench.h"

namespace seaway::server {
namespace {

using sea::Field;
using sea::FieldSet;
using sea::TimeUs;

constexpr TimeUs long_us = 700'000;
constexpr TimeUs short_us = 90'000;
const FieldSet height{Field::height, Field::height_rate};

sea::ErrorBudget budget() {
    sea::ErrorBudget budget;
    budget.cascades.resize(2);
    budget.cascades[0].interval_us = long_us;
    budget.cascades[1].interval_us = short_us;
    return budget;
}

/// Of one sea with these intervals.
const SeaCourse& course() {
    static const SeaCoursePtr steady = [] {
        RunningSea sea{};
        sea.epoch = 1;
        sea.budget = budget();
        return steady_course(std::make_shared<const RunningSea>(std::move(sea)));
    }();
    return *steady;
}

EffectPlan plan(FieldSet first, FieldSet second) {
    return {{{first, long_us, 0}, {second, short_us, 0}}};
}

/// Takes all that is due; adds up what was left out.
std::vector<KeyframeRequest> all_due(Schedule& schedule, const EffectPlan& plan, TimeUs now_us,
                                     std::uint64_t* left_out = nullptr) {
    std::vector<KeyframeRequest> all;
    for (;;) {
        const Schedule::Due due = schedule.take_due(plan, now_us);
        if (left_out)
            *left_out += due.left_out;
        if (due.keyframes.empty())
            return all;
        all.insert(all.end(), due.keyframes.begin(), due.keyframes.end());
    }
}

TEST(Schedule, keyframes_of_several_intervals_meet_at_a_whole_multiple_of_all_where_that_is_near) {
    const auto meeting = [](TimeUs time_us, std::vector<TimeUs> intervals_us) {
        return next_meeting(time_us, intervals_us);
    };
    EXPECT_EQ(meeting(1, {400'000, 250'000}), 2'000'000);
    EXPECT_EQ(meeting(2'000'000, {400'000, 250'000}), 2'000'000);
    EXPECT_EQ(meeting(-1, {400'000, 250'000}), 0);
    EXPECT_EQ(meeting(1, {400'000, 250'001}), 1) << "they meet after days";
}

TEST(Schedule, intervals_hold_their_times_before_the_epoch_too) {
    EXPECT_EQ(interval_start(0, 10), 0);
    EXPECT_EQ(interval_start(19, 10), 10);
    EXPECT_EQ(interval_start(-1, 10), -10);
    EXPECT_EQ(interval_start(-10, 10), -10);
    std::mt19937_64 numbers(1);
    for (int i = 0; i < 10'000; ++i) {
        const TimeUs interval_us = 1 + static_cast<TimeUs>(numbers() % 3'600'000'000);
        const TimeUs time_us =
            static_cast<TimeUs>(numbers() % (2 * std::uint64_t{sea::time_us_max})) -
            sea::time_us_max;
        const TimeUs start_us = interval_start(time_us, interval_us);
        EXPECT_EQ(start_us % interval_us, 0);
        EXPECT_LE(start_us, time_us);
        EXPECT_GT(start_us + interval_us, time_us);
    }
}

TEST(Schedule, nothing_is_due_while_nobody_wants_anything) {
    Schedule schedule(course());
    EXPECT_TRUE(all_due(schedule, plan({}, {}), 5'000'000).empty());
    EXPECT_EQ(schedule.next_due_us(plan({}, {})), std::nullopt);
}

TEST(Schedule, each_keyframe_comes_once_ahead_of_its_time_whenever_it_is_looked_at) {
    std::mt19937_64 numbers(2);
    for (int round = 0; round < 50; ++round) {
        Schedule schedule(course());
        const EffectPlan wanted = plan(height, height);
        std::vector<TimeUs> seen[2];
        TimeUs now_us = -3'000'000;
        while (now_us < 3'000'000) {
            for (const KeyframeRequest& one : all_due(schedule, wanted, now_us))
                seen[one.cascade].push_back(one.time_us);
            EXPECT_GT(seen[0].back(), now_us + publish_lead_us) << "in time to be decoded";
            EXPECT_GT(seen[1].back(), now_us + publish_lead_us);
            EXPECT_GT(*schedule.next_due_us(wanted), now_us);
            now_us += 1 + static_cast<TimeUs>(numbers() % 400'000); // never above catch_up_us
        }
        for (int c = 0; c < 2; ++c)
            for (std::size_t i = 1; i < seen[c].size(); ++i)
                ASSERT_EQ(seen[c][i] - seen[c][i - 1], c == 0 ? long_us : short_us);
    }
}

// Naive: a quarter of a second of a sea that runs ten times as fast is 25 ms.
TEST(Schedule, of_a_sea_that_runs_faster_than_clocks_keyframes_come_as_much_earlier) {
    Schedule schedule(course());
    const EffectPlan both = plan(height, height);
    (void)all_due(schedule, both, 0);
    const auto next_lead = [&] {
        TimeUs now_us = *schedule.next_due_us(both);
        const auto due = all_due(schedule, both, now_us);
        EXPECT_FALSE(due.empty());
        const TimeUs interval_us = due.front().cascade == 0 ? long_us : short_us;
        return due.front().time_us - interval_us - now_us;
    };
    EXPECT_EQ(next_lead(), publish_lead_us);
    schedule.hurry(10);
    (void)all_due(schedule, both, long_us); // what is late for that comes at once
    EXPECT_EQ(next_lead(), 10 * publish_lead_us);
    schedule.hurry(1);
    for (int i = 0; i < 40; ++i) // what was ahead is not sent again
        EXPECT_GE(next_lead(), publish_lead_us);
}

// Naive: a stream stays where it was when the sea goes back to where a pause began, with nothing to send until then, and whoever
// comes is sent all that lies between.
TEST(Schedule, where_sea_time_goes_back_it_begins_anew_and_newcomers_are_sent_what_is_around_now) {
    Schedule schedule(course()), fresh(course());
    const EffectPlan wanted = plan(height, height);
    for (TimeUs now_us = 60'000'000; now_us < 63'000'000; now_us += 50'000)
        (void)all_due(schedule, wanted, now_us);
    constexpr TimeUs now_us = 3'000'000;
    const Demand demand{.cascades = 3, .fields = height};
    EXPECT_EQ(schedule.current(demand, now_us).size(), fresh.current(demand, now_us).size());
    const std::vector<KeyframeRequest> due = all_due(schedule, wanted, now_us);
    EXPECT_EQ(due.size(), all_due(fresh, wanted, now_us).size());
    EXPECT_FALSE(due.empty());
    EXPECT_EQ(schedule.next_due_us(wanted), fresh.next_due_us(wanted));
}

TEST(Schedule, after_a_leap_it_goes_on_with_the_keyframe_of_now_and_counts_the_rest) {
    Schedule schedule(course());
    const EffectPlan wanted = plan({}, height);
    const TimeUs last_us = all_due(schedule, wanted, 1'000'000).back().time_us;
    const TimeUs now_us = 11'000'000;
    std::uint64_t left_out = 0;
    const std::vector<KeyframeRequest> due = all_due(schedule, wanted, now_us, &left_out);
    EXPECT_EQ(due.front().time_us, interval_start(now_us, short_us));
    EXPECT_EQ(left_out, static_cast<std::uint64_t>((due.front().time_us - last_us) / short_us - 1));
    left_out = 0;
    all_due(schedule, wanted, now_us + catch_up_us, &left_out);
    EXPECT_EQ(left_out, 0u) << "a short stall is made up for";
}

TEST(Schedule, a_stream_that_ended_starts_anew_at_now) {
    Schedule schedule(course());
    all_due(schedule, plan(height, {}), 0);
    all_due(schedule, plan({}, {}), 100'000);
    std::uint64_t left_out = 0;
    const auto due = all_due(schedule, plan(height, {}), 50'000'000, &left_out);
    ASSERT_EQ(due.size(), 1u);
    EXPECT_EQ(due[0].time_us, interval_start(50'000'000 + long_us + publish_lead_us, long_us));
    EXPECT_EQ(left_out, 0u) << "nobody was there to miss them";
}

TEST(Schedule, what_a_new_subscriber_fetches_ends_where_the_stream_goes_on) {
    const Demand both{.cascades = ~0u, .fields = height};
    const TimeUs now_us = 1'234'567;
    for (const bool others_watch : {false, true}) {
        Schedule schedule(course());
        if (others_watch)
            all_due(schedule, plan(height, height), now_us);
        const std::vector<KeyframeRequest> current = schedule.current(both, now_us);
        std::vector<KeyframeRequest> streamed = all_due(schedule, plan(height, height), now_us);
        for (const auto& one : all_due(schedule, plan(height, height), now_us + 300'000))
            streamed.push_back(one);
        for (int c = 0; c < 2; ++c) {
            const TimeUs interval_us = c == 0 ? long_us : short_us;
            TimeUs next_us = interval_start(now_us, interval_us);
            for (const auto& list : {current, streamed})
                for (const KeyframeRequest& one : list)
                    if (one.cascade == c) {
                        EXPECT_EQ(one.time_us, next_us);
                        next_us += interval_us;
                    }
        }
    }
}

/// Sea 1 with intervals of budget(), a glide of shorter ones from 10 s on, and from 20 s on a sea of other ones.
std::shared_ptr<SeaCourse> changing_course() {
    const auto course = *SeaCourse::begin(*sea::parse_scene(small_sea, "small_sea", "."));
    sea::Scene stormy = course->first()->scene;
    std::get<sea::WindSea>(stormy.sea.systems[0]).wind_speed_10m_mps = 18.0;
    EXPECT_TRUE(course->add(stormy, 10'123'456, 20'234'567));
    return course;
}

// Each moment has the two keyframes around it of the sea that runs then, an interval and the lead before; none comes twice,
// and a newcomer's are those that the stream has had.
TEST(Schedule, where_one_sea_follows_another_the_stream_has_the_keyframes_of_both_in_time) {
    const auto course = changing_course();
    Schedule schedule(*course);
    EffectPlan wanted = plan(height, height);
    std::map<std::tuple<int, std::uint32_t, TimeUs>, TimeUs> out; // when it came
    std::mt19937_64 numbers(3);
    std::vector<KeyframeRequest> start = schedule.current({.cascades = 3u, .fields = height}, 0);
    for (const KeyframeRequest& one : start)
        out[{one.cascade, one.epoch, one.time_us}] = 0;
    for (TimeUs now_us = 0; now_us < 25'000'000;
         now_us += 1 + static_cast<TimeUs>(numbers() % 90'000)) {
        for (const KeyframeRequest& one : all_due(schedule, wanted, now_us))
            EXPECT_TRUE(
                out.emplace(std::tuple(one.cascade, one.epoch, one.time_us), now_us).second);
        for (const KeyframeRequest& one :
             schedule.current({.cascades = 3u, .fields = height}, now_us))
            EXPECT_TRUE(out.contains({one.cascade, one.epoch, one.time_us}))
                << one.epoch << ' ' << one.time_us << " at " << now_us;
    }
    for (TimeUs t_us = 0; t_us < 24'000'000; t_us += 7'001) {
        const RunningSeaPtr sea = course->at(t_us);
        for (int c = 0; c < 2; ++c) {
            const TimeUs interval_us =
                sea->budget.cascades[static_cast<std::size_t>(c)].interval_us;
            const TimeUs first_us = interval_start(t_us, interval_us);
            for (const TimeUs k_us : {first_us, first_us + interval_us}) {
                const auto found = out.find({c, sea->epoch, k_us});
                ASSERT_NE(found, out.end()) << sea->epoch << ' ' << k_us;
                EXPECT_LE(found->second, std::max<TimeUs>(t_us - publish_lead_us + 90'000, 0))
                    << k_us;
            }
        }
    }
}

// Naive: what follows is looked at, and so made, at every step: each change stops the stream of those who wait for none.
TEST(Schedule, a_sea_that_follows_is_not_made_for_the_stream_before_it_is_near) {
    const auto course = changing_course();
    Schedule schedule(*course);
    const EffectPlan wanted = plan(height, height);
    TimeUs now_us = 0;
    for (; now_us < 3'000'000; now_us += 50'000) {
        all_due(schedule, wanted, now_us);
        schedule.next_due_us(wanted);
        schedule.current({.cascades = 3u, .fields = height}, now_us);
    }
    EXPECT_EQ(course->sea_if_held(2), nullptr) << "the glide begins at 10 s";
    for (; now_us < 10'000'000; now_us += 50'000)
        all_due(schedule, wanted, now_us);
    EXPECT_NE(course->sea_if_held(2), nullptr) << "nobody else has made it";
    EXPECT_EQ(course->epochs(), 3u);
}

// Naive: those of the next sea begin when the last of this one is out: a burst, of which a reader loses what it cannot take.
TEST(Schedule, each_keyframe_of_both_seas_comes_at_its_own_due_time) {
    const auto course = changing_course();
    Schedule schedule(*course);
    constexpr TimeUs step_us = 5'000;
    for (TimeUs now_us = 5'000'000; now_us < 24'000'000; now_us += step_us)
        for (const KeyframeRequest& one : all_due(schedule, plan(height, height), now_us)) {
            const TimeUs interval_us = course->sea(one.epoch)
                                           ->budget.cascades[static_cast<std::size_t>(one.cascade)]
                                           .interval_us;
            const TimeUs due_us = one.time_us - interval_us - publish_lead_us;
            if (now_us > 8'000'000) {
                EXPECT_LE(now_us - due_us, step_us) << one.epoch << ' ' << one.time_us;
            }
        }
}

TEST(Schedule, around_times_each_keyframe_is_asked_for_once) {
    const TimeUs times_us[] = {100, 200, 89'999, 90'000, -1};
    const auto wanted = keyframes_around(course(), times_us, {.cascades = 2u, .fields = height});
    std::vector<TimeUs> times;
    for (const KeyframeRequest& one : wanted) {
        EXPECT_EQ(one.cascade, 1);
        times.push_back(one.time_us);
    }
    EXPECT_EQ(times, (std::vector<TimeUs>{-90'000, 0, 90'000, 180'000}));
    EXPECT_TRUE(keyframes_around(course(), {}, {.cascades = 3u, .fields = height}).empty());
}

} // namespace
} // namespace seaway::server
