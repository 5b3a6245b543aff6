// SPDX-License-Identifier: Apache-2.0
// Who waits for whom in the simulation: streams, foam that starts and questions take turns, and none
// of them keeps another waiting for its end.
#include <algorithm>
#include <chrono>
#include <cmath>

#include "tests/server/simulation/simulation_bench.h"

namespace seaway::server {
namespace {

const FieldSet heights{Field::height, Field::height_rate};
const FieldSet with_foam = heights | FieldSet{Field::foam};

/// Its memory is foam_ticks_max ticks: the longest start there is.
const std::string long_foam = "[foam]\nthreshold = 0.8\ndecay_s = 100\n";

/// Long enough for any machine; a test that fails ends all the same.
constexpr std::chrono::seconds patience{60};

TEST(Turns, a_stream_that_never_catches_up_keeps_no_question_waiting) {
    Bench bench;
    bench.subscriptions.set(1, {3u, sea::surface_fields});
    bench.leap_us = 1'000'000; // something is due at every look at the clock
    std::promise<void> answered;
    bench.simulation->answer(
        {{1.0, 2.0, 0}}, false,
        [&](const Result<std::vector<sea::Answer>>& answers) {
            EXPECT_TRUE(answers);
            answered.set_value();
        },
        someone);
    const bool in_time = answered.get_future().wait_for(patience) == std::future_status::ready;
    bench.leap_us = 0;
    bench.settle();
    EXPECT_TRUE(in_time);
    EXPECT_GT(bench.simulation->counters().keyframes_published, 0u);
}

TEST(Turns, a_flood_of_wakes_passes_nobody_over_twice) {
    Questions questions;
    int slices = 0;
    questions.ask({[&] { return ++slices == 3; }, [](const Error&) {}, someone});
    for (int i = 0; i < 6; ++i) {
        questions.wake(); // before every look
        std::optional<Question> question = questions.take(0);
        EXPECT_EQ(question.has_value(), i % 2 == 1) << i;
        if (question && !question->slice())
            questions.put_back(*std::move(question));
    }
    EXPECT_EQ(slices, 3);
}

TEST(Turns, foam_that_starts_delays_no_question_and_no_stream_of_who_wants_none) {
    Bench bench(long_foam);
    bench.subscriptions.set(1, {1u, heights});
    bench.settle();
    const std::uint64_t before = bench.simulation->counters().synthesis.foam_ticks;
    std::promise<std::vector<sea::KeyframePtr>> fetched;
    std::promise<std::uint64_t> made_at_answer;
    std::promise<std::size_t> streamed_at_answer;
    {
        const Gate gate(bench);
        bench.now_us += bench.sea->budget.cascades[0].interval_us;
        bench.subscriptions.set(2, {1u, with_foam});
        bench.simulation->fetch_current(
            {1u, with_foam}, whole([&](const auto& keyframes) { fetched.set_value(*keyframes); }),
            someone);
        bench.simulation->fetch(
            {0}, {3u, sea::surface_fields},
            [&](const auto&) {
                made_at_answer.set_value(bench.simulation->counters().synthesis.foam_ticks -
                                         before);
                streamed_at_answer.set_value(bench.times(0).size());
            },
            someone);
    }
    // Two slices of the start - one before the look at the new demand, one after it - each 128 ticks
    // of 64 x 64; one of the stream, and what the answer needs.
    EXPECT_LT(made_at_answer.get_future().get(), 2 * 128u + 10);
    EXPECT_EQ(streamed_at_answer.get_future().get(), 2u) << "on time, without foam";
    const std::vector<sea::KeyframePtr> current = fetched.get_future().get();
    const std::uint64_t made = bench.simulation->counters().synthesis.foam_ticks - before;
    EXPECT_GE(made, static_cast<std::uint64_t>(sea::foam_ticks_max))
        << "the start is as long as it was thought to be";
    EXPECT_LT(made, static_cast<std::uint64_t>(sea::foam_ticks_max + sea::foam_ticks_max / 2))
        << "one start serves the stream and the fetch";
    bench.settle();

    // What was fetched and what was streamed with foam are one sequence.
    const TimeUs interval_us = bench.sea->budget.cascades[0].interval_us;
    ASSERT_FALSE(current.empty());
    EXPECT_EQ(current.front()->time_us, interval_start(bench.now_us, interval_us));
    for (const sea::KeyframePtr& keyframe : current)
        EXPECT_TRUE(keyframe->fields.contains(with_foam));
    bench.advance(interval_us);
    const std::scoped_lock lock(bench.mutex);
    const auto first = std::ranges::find_if(bench.published, [](const auto& keyframe) {
        return keyframe->fields.contains(Field::foam);
    });
    ASSERT_NE(first, bench.published.end()) << "the stream carries foam from now on";
    EXPECT_EQ((*first)->time_us, current.back()->time_us + interval_us);
}

TEST(Turns, fetches_with_foam_far_apart_are_all_made_and_none_starts_over_for_another) {
    const Demand foam{1u, {Field::foam}};
    const std::vector<TimeUs> times_us{5'000'000, 900'000'000, -40'000'000};
    Bench bench(long_foam);
    std::vector<std::promise<Result<std::vector<sea::KeyframePtr>>>> fetched(times_us.size());
    {
        const Gate gate(bench);
        for (std::size_t i = 0; i < times_us.size(); ++i)
            bench.simulation->fetch(
                {times_us[i]}, foam,
                whole([&, i](auto made) { fetched[i].set_value(std::move(made)); }), someone);
    }
    for (std::size_t i = 0; i < times_us.size(); ++i) {
        auto waits = fetched[i].get_future();
        ASSERT_EQ(waits.wait_for(patience), std::future_status::ready) << i;
        const Result<std::vector<sea::KeyframePtr>> made = waits.get();
        ASSERT_TRUE(made);
        Bench alone(long_foam);
        const auto same = alone.fetch({times_us[i]}, foam);
        ASSERT_TRUE(same);
        for (std::size_t k = 0; k < made->size(); ++k)
            EXPECT_TRUE(
                std::ranges::equal((*made)[k]->plane(Field::foam), (*same)[k]->plane(Field::foam)))
                << "a start is the same start, in however many slices";
    }
    // Each a start, what lies between two keyframes, and the two themselves.
    EXPECT_LE(bench.simulation->counters().synthesis.foam_ticks,
              times_us.size() * (sea::foam_ticks_max + 20));
}

// Naive: starts of subscriptions take their turn with all who walk through foam, and wait until the
// last of eight walks far away is done.
TEST(Turns, a_newcomer_to_foam_waits_for_no_fetch_of_foam_far_away) {
    Bench bench(long_foam);
    std::atomic<bool> far_made = false;
    std::promise<void> far_end;
    std::promise<bool> far_made_before;
    const auto other = std::make_shared<char>();
    {
        const Gate gate(bench);
        std::vector<TimeUs> times_us;
        for (TimeUs i = 1; i <= 8; ++i)
            times_us.push_back(i * 900'000'000);
        bench.simulation->fetch(
            times_us, {1u, {Field::foam}},
            [&](const auto& part) {
                if (part && !part->last)
                    return;
                far_made = part.has_value();
                far_end.set_value();
            },
            someone);
    }
    bench.settle(); // it is under way
    bench.subscriptions.set(1, {1u, with_foam});
    bench.simulation->fetch_current({1u, with_foam}, whole([&](const auto& made) {
                                        EXPECT_TRUE(made && !made->empty());
                                        far_made_before.set_value(far_made);
                                    }),
                                    Asker(other));
    EXPECT_FALSE(far_made_before.get_future().get());
    far_end.get_future().wait();
    EXPECT_TRUE(far_made);
}

// Where the stream has walked to, nobody walks again: neither who starts there nor who asks about now.
TEST(Turns, one_walk_to_now_serves_the_stream_the_starts_and_the_questions) {
    Bench bench(long_foam);
    const auto made = [&] { return bench.simulation->counters().synthesis.foam_ticks; };
    const auto starts_left = [&](const auto& ask) {
        const std::uint64_t before = made();
        EXPECT_TRUE(ask());
        return made() - before;
    };
    bench.subscriptions.set(1, {1u, with_foam});
    bench.settle();
    const TimeUs interval_us = bench.sea->budget.cascades[0].interval_us;
    EXPECT_LT(starts_left([&] { return !bench.fetch_current({1u, with_foam}).empty(); }), 50u);
    EXPECT_LT(starts_left([&] {
                  return bench.fetch({bench.now_us + 3 * interval_us}, {1u, with_foam}).has_value();
              }),
              50u)
        << "a question about nearly now goes on from there";
    EXPECT_GE(starts_left([&] {
                  return bench.fetch({bench.now_us}, {2u, with_foam}).has_value();
              }),
              static_cast<std::uint64_t>(sea::foam_ticks_max))
        << "of the other cascade there is none yet";
}

// Foam that paused for an interval is one tick away, as it is from keyframe to keyframe: no keyframe of
// who asks again comes without it.
TEST(Turns, foam_that_is_asked_for_again_an_interval_later_comes_with_the_next_keyframe) {
    // Of so short a memory that there is a tick a keyframe.
    Bench bench("[foam]\nthreshold = 0.8\ndecay_s = 5\n");
    const TimeUs interval_us = bench.sea->budget.cascades[0].interval_us;
    bench.subscriptions.set(1, {1u, with_foam});
    bench.subscriptions.set(2, {1u, heights}); // has its keyframes with foam or without
    bench.settle();
    bench.advance(interval_us);
    bench.subscriptions.erase(1);
    bench.settle();
    std::size_t before = 0;
    {
        const std::scoped_lock lock(bench.mutex);
        before = bench.published.size();
        ASSERT_TRUE(bench.published.back()->fields.contains(Field::foam));
    }
    {
        const Gate gate(bench);
        bench.now_us += interval_us;
        bench.subscriptions.set(1, {1u, with_foam});
    }
    bench.settle();
    const std::scoped_lock lock(bench.mutex);
    ASSERT_GT(bench.published.size(), before);
    for (std::size_t i = before; i < bench.published.size(); ++i)
        EXPECT_TRUE(bench.published[i]->fields.contains(Field::foam)) << i;
}

// Two walk to the foam of now: who asks for more is there first, and who asks for less, and was under way before anything was held,
// takes nothing away.
TEST(Turns, a_keyframe_with_fewer_fields_that_is_made_later_replaces_none_with_more) {
    bool more_was_first = false;
    // A busy machine lets who asks second ask when the first has arrived.
    for (int i = 0; i < 20 && !more_was_first; ++i) {
        Bench bench(long_foam);
        std::promise<bool> less, more;
        std::atomic<bool> more_made = false;
        const auto other = std::make_shared<char>();
        bench.simulation->fetch({-5'000'000'000, 0}, {1u, {Field::foam}},
                                whole([&](const auto& all) {
                                    more_was_first = more_made.load();
                                    less.set_value(all.has_value());
                                }),
                                someone);
        while (bench.simulation->counters().synthesis.foam_ticks == 0)
            std::this_thread::yield();
        bench.simulation->fetch_current({1u, with_foam}, whole([&](const auto& all) {
                                            more_made = true;
                                            more.set_value(all.has_value());
                                        }),
                                        Asker(other));
        EXPECT_TRUE(more.get_future().get());
        EXPECT_TRUE(less.get_future().get());
        const std::uint64_t before = bench.simulation->counters().synthesis.keyframes;
        EXPECT_FALSE(bench.fetch_current({1u, heights}).empty());
        EXPECT_EQ(bench.simulation->counters().synthesis.keyframes, before) << "all of it is held";
    }
    EXPECT_TRUE(more_was_first) << "one walk is shorter than two";
}

// One thread makes it all: what effects have cost together is no more than the time that has passed.
TEST(Turns, what_effects_cost_together_is_time_that_has_passed_once) {
    Bench bench(long_foam);
    const auto start = std::chrono::steady_clock::now();
    ASSERT_TRUE(bench.fetch({0}, {3u, {Field::foam}}));
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
    const EffectCosts costs = bench.simulation->costs();
    double together_s = 0;
    for (std::size_t cascade = 0; cascade < 2; ++cascade)
        for (std::size_t effect = 0; effect < effect_table().size(); ++effect)
            together_s += costs.cost(cascade, effect).device_seconds;
    EXPECT_GT(together_s, 0);
    EXPECT_LE(together_s, passed.count());
}

// What the stream shares is no use to who is half-way to somewhere else.
TEST(Turns, a_walk_of_foam_to_far_away_goes_on_where_it_was_though_foam_starts_for_the_stream) {
    Bench bench(long_foam);
    const auto made = [&] { return bench.simulation->counters().synthesis.foam_ticks; };
    const auto ticks = static_cast<std::uint64_t>(sea::foam_ticks_max);
    std::promise<bool> far;
    {
        const Gate gate(bench);
        bench.simulation->fetch(
            {5'000'000'000, 10'000'000'000, 15'000'000'000}, {1u, {Field::foam}},
            whole([&](const auto& all) { far.set_value(all.has_value()); }), someone);
    }
    while (made() < ticks / 2)
        std::this_thread::yield();
    bench.subscriptions.set(1, {1u, with_foam});
    EXPECT_TRUE(far.get_future().get());
    bench.settle();
    EXPECT_GE(made(), 4 * ticks) << "each of them is as long as it was thought to be";
    EXPECT_LT(made(), 4 * ticks + ticks / 8) << "and none was begun anew";
}

TEST(Turns, a_map_of_foam_that_is_held_is_taken_over_and_not_walked_for_again) {
    Bench bench(long_foam);
    const Result<std::vector<sea::KeyframePtr>> foam = bench.fetch({0}, {1u, {Field::foam}});
    ASSERT_TRUE(foam);
    const std::uint64_t before = bench.simulation->counters().synthesis.keyframes;
    const Result<std::vector<sea::KeyframePtr>> more =
        bench.fetch({0}, {1u, {Field::slope_x, Field::slope_y}});
    ASSERT_TRUE(more);
    EXPECT_EQ(bench.simulation->counters().synthesis.keyframes - before, more->size());
    const Result<std::vector<sea::KeyframePtr>> again =
        bench.fetch({0}, {1u, {Field::slope_x, Field::foam}});
    ASSERT_TRUE(again);
    EXPECT_EQ(bench.simulation->counters().synthesis.keyframes - before, more->size())
        << "held by now";
    for (std::size_t i = 0; i < foam->size(); ++i)
        EXPECT_TRUE(
            std::ranges::equal((*again)[i]->plane(Field::foam), (*foam)[i]->plane(Field::foam)));
}

TEST(Turns, questions_of_who_has_gone_are_dropped_without_work) {
    Bench bench;
    auto here = std::make_shared<char>();
    std::mutex mutex;
    std::vector<Error> refusals;
    const auto note = [&](const auto& result) {
        ASSERT_FALSE(result);
        const std::scoped_lock lock(mutex);
        refusals.push_back(result.error());
    };
    {
        const Gate gate(bench);
        const Asker asker(here);
        bench.simulation->answer({{1.0, 2.0, 0}}, false, note, asker);
        bench.simulation->answer(std::vector<sea::QueryPoint>(500), true, note, asker);
        bench.simulation->fetch({0}, {~0u, sea::surface_fields}, note, asker);
        bench.simulation->fetch_current({~0u, sea::surface_fields}, note, asker);
        here = nullptr;
    }
    const auto refused = [&] {
        const std::scoped_lock lock(mutex);
        return refusals.size();
    };
    const auto end = std::chrono::steady_clock::now() + patience;
    while (refused() < 4 && std::chrono::steady_clock::now() < end)
        bench.settle(); // askers take turns: each time it is one of theirs
    ASSERT_EQ(refused(), 4u) << "each is answered all the same";
    for (const Error& refusal : refusals)
        EXPECT_TRUE(refusal.is(Refusal::gone));
    EXPECT_EQ(bench.simulation->counters().synthesis.keyframes, 0u);
    EXPECT_EQ(bench.answer({{1.0, 2.0, 0}}).size(), 1u);
}

TEST(Turns, a_simulation_that_ends_while_foam_starts_refuses_who_waits_for_it) {
    std::promise<Error> refused;
    {
        Bench bench(long_foam);
        const Gate gate(bench);
        bench.subscriptions.set(1, {3u, with_foam});
        bench.simulation->fetch_current(
            {3u, with_foam},
            [&](const auto& made) {
                if (!made)
                    refused.set_value(made.error());
            },
            someone);
        *bench.failures = 1000;
    }
    EXPECT_TRUE(refused.get_future().get().is(Refusal::gone));
}

TEST(Turns, who_gives_up_foam_while_it_starts_leaves_nobody_waiting) {
    Bench bench(long_foam);
    bench.subscriptions.set(1, {3u, with_foam});
    std::promise<std::uint64_t> fetched;
    std::uint64_t before = 0;
    {
        const Gate gate(bench); // after a look at the demand: the start is under way
        before = bench.simulation->counters().stream_slices;
        ASSERT_GT(before, 0u);
        bench.simulation->fetch_current({3u, with_foam}, whole([&](const auto& made) {
                                            EXPECT_TRUE(made && !made->empty());
                                            fetched.set_value(
                                                bench.simulation->counters().stream_slices);
                                        }),
                                        someone);
        bench.subscriptions.erase(1);
    }
    auto waits = fetched.get_future();
    ASSERT_EQ(waits.wait_for(patience), std::future_status::ready);
    EXPECT_EQ(waits.get(), before) << "nobody walks on for a stream that nobody wants";
    EXPECT_TRUE(bench.times(0).empty());
}

} // namespace
} // namespace seaway::server
