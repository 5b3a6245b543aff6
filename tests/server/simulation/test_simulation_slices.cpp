// SPDX-License-Identifier: Apache-2.0
// How much is done in one go, and how much is held: a slice is a slice however large the sea, a crowd
// of fetches holds no more than there is room for, and one who asks much delays nobody.
#include <algorithm>

#include <fmt/format.h>

#include "sea/scene/weather.h"
#include "tests/server/simulation/simulation_bench.h"

namespace seaway::server {
namespace {

/// A third cascade of which two keyframes of six fields are more than a slice.
const std::string large = "[[cascade]]\nlength_m = 6.1\nsize = 512\n";
const FieldSet all_but_foam = sea::all_fields.without({Field::foam});

/// What has been synthesized when a question is answered that came last and takes no work.
std::uint64_t made_when_a_small_question_is_answered(Bench& bench) {
    std::promise<std::uint64_t> made;
    const auto here = std::make_shared<char>();
    bench.simulation->fetch(
        {}, {},
        [&](const auto&) { made.set_value(bench.simulation->counters().synthesis.keyframes); },
        Asker(here));
    return made.get_future().get();
}

/// Keyframes that are made by the time that a small question is answered which comes when a large one has begun.
std::uint64_t made_meanwhile(bool map) {
    Bench bench(large);
    std::promise<bool> answered;
    std::optional<Gate> gate(std::in_place, bench);
    if (map)
        bench.simulation->surface(
            7'000'000, [&](const auto& surface) { answered.set_value(surface.has_value()); },
            someone);
    else
        bench.simulation->answer(
            {{1.0, 2.0, 7'000'000}}, false,
            [&](const auto& answers) { answered.set_value(answers.has_value()); }, someone);
    gate.reset();
    const std::uint64_t made = made_when_a_small_question_is_answered(bench);
    EXPECT_TRUE(answered.get_future().get());
    EXPECT_EQ(bench.simulation->counters().synthesis.keyframes, 6u);
    return made;
}

// Naive: all keyframes of the surface around a point in one go, and then all their splines. Where this thread is held up until
// all is made it has seen nothing: it tries again, and never sees less than all where nobody is let in.
TEST(Slices, one_point_at_a_new_time_in_a_large_sea_lets_others_in_between) {
    for (const bool map : {false, true}) {
        bool let_in = false;
        for (int tries = 0; tries < 20 && !let_in; ++tries)
            let_in = made_meanwhile(map) < 6; // two of each cascade
        EXPECT_TRUE(let_in) << (map ? "a map" : "a point");
    }
}

// Naive: a number of points a slice, whatever a point takes. A point of this sea takes some
// milliseconds, 256 of them a second; a slice lasts 5 ms. On a slower machine it is all the more.
TEST(Slices, exact_points_let_others_in_between_however_many_waves_there_are) {
    Bench bench(large);
    std::atomic<bool> answered = false;
    std::promise<void> end;
    std::promise<bool> answered_before;
    const auto here = std::make_shared<char>();
    {
        const Gate gate(bench);
        std::vector<sea::QueryPoint> points;
        for (int i = 0; i < 256; ++i)
            points.push_back({i * 7.0, i * 3.0, 1'000'000});
        bench.simulation->answer(
            points, true,
            [&](const auto& answers) {
                answered = answers.has_value();
                end.set_value();
            },
            someone);
        bench.simulation->fetch(
            {}, {}, [&](const auto&) { answered_before.set_value(answered); }, Asker(here));
    }
    EXPECT_FALSE(answered_before.get_future().get());
    end.get_future().wait();
    EXPECT_TRUE(answered);
}

TEST(Slices, of_points_end_when_they_are_over_and_hold_one_point_at_least) {
    const SeaCoursePtr course = steady_course(running_sea());
    PointQuestion question(std::vector<sea::QueryPoint>{{1, 2, 0}, {3, 4, 0}, {5, 6, 1'000'000}});
    SumsRoom sums(Memory().room(MemoryUse::sums));
    for (int slice = 1; slice <= 3; ++slice) {
        EXPECT_FALSE(question.complete());
        question.sum_exactly(
            *course, [] { return true; }, sums);
    }
    EXPECT_TRUE(question.complete());
}

// Naive: each exact question keeps the waves of its time until it is answered: in a glide some MB of its own. A thousand sessions
// held gigabytes beside the budget.
TEST(Slices, a_crowd_of_exact_questions_holds_no_more_waves_than_there_is_room_for) {
    const RunningSeaPtr sea = running_sea();
    const auto course = std::make_shared<SeaCourse>(sea);
    const TomlAssignment wind{"systems.0.wind_speed_10m_mps", "14.0"};
    ASSERT_TRUE(course->add(*sea::changed(sea->scene, {&wind, 1}), 0, 100 * second_us));
    const auto tight = Room::of(2u << 20), wide = Room::of(1u << 30);
    struct Asked {
        PointQuestion question;
        SumsRoom& room;
    };
    SumsRoom tight_sums(tight), wide_sums(wide);
    std::vector<Asked> crowd;
    for (int i = 0; i < 32; ++i) {
        std::vector<sea::QueryPoint> points;
        for (int n = 0; n < 5; ++n) // in the glide, two at one time; and when it is over
            points.push_back({3.0 * n, 1.0 * i, (1 + n / 2) * 40 * second_us + i});
        crowd.push_back({PointQuestion(points), i % 2 == 0 ? tight_sums : wide_sums});
    }
    std::size_t most = 0;
    for (bool all = false; !all;) {
        all = true;
        for (Asked& one : crowd)
            if (!one.question.complete()) {
                one.question.sum_exactly(
                    *course, [] { return true; }, one.room);
                all = false;
                most = std::max(most, tight->held_bytes());
            }
    }
    EXPECT_LE(most, tight->bytes_max());
    EXPECT_GT(most, 1u << 20) << "it is used";
    EXPECT_GT(wide->held_bytes_most(), 4u << 20) << "what sixteen would hold";
    EXPECT_EQ(tight->held_bytes() + wide->held_bytes(), 0u) << "given back";
    for (std::size_t i = 0; i < crowd.size(); ++i) {
        const PointsAnswered answered = crowd[i].question.take_answers();
        for (std::size_t n = 0; n < answered.answers.size(); ++n) {
            const sea::TimeUs time_us =
                static_cast<sea::TimeUs>(1 + n / 2) * 40 * second_us + static_cast<sea::TimeUs>(i);
            const RunningSeaPtr then = course->sea(course->window_at(time_us).epoch);
            const auto truth = then->truth_at(time_us);
            EXPECT_EQ(answered.answers[n].height_m,
                      sea::surface_at(
                          {3.0 * static_cast<double>(n), 1.0 * static_cast<double>(i), time_us},
                          {then->choppiness_at(time_us), 1e-9, sea::fold_search(then->budget)},
                          truth->at_time(time_us))
                          .height_m)
                << "made anew they are the same waves";
        }
    }
}

// Naive: what belongs to the whole sea is nobody's. The course keeps a few of its seas; of others a question that is under
// way would be the one that holds 20 MB and more.
TEST(Slices, waves_of_a_sea_that_the_course_may_let_go_are_counted_by_who_holds_them) {
    const RunningSeaPtr sea = running_sea();
    const auto course = std::make_shared<SeaCourse>(sea);
    const TomlAssignment wind{"systems.0.wind_speed_10m_mps", "14.0"};
    ASSERT_TRUE(course->add(*sea::changed(sea->scene, {&wind, 1}), 10 * second_us, 20 * second_us));
    const auto held_at = [&](TimeUs time_us, int questions) {
        SumsRoom sums(Room::of(1u << 30));
        std::vector<PointQuestion> all;
        for (int i = 0; i < questions; ++i) {
            all.emplace_back(std::vector<sea::QueryPoint>{{1, 2, time_us}, {3, 4, time_us}});
            all.back().sum_exactly(
                *course, [] { return true; }, sums);
            EXPECT_FALSE(all.back().complete());
        }
        return sums.room().held_bytes();
    };
    const std::size_t of_first = held_at(0, 1), of_later = held_at(30 * second_us, 1);
    EXPECT_GE(of_later, of_first + sea->truth->bytes());
    EXPECT_LT(of_first, sea->truth->bytes()) << "whose sea stays made";
    EXPECT_EQ(held_at(30 * second_us, 5), of_later + 4 * of_first) << "one sum, kept by all";
    EXPECT_GE(held_at(15 * second_us, 2), 2 * (of_first + sea->truth->bytes()))
        << "in a glide each has its own";
}

// Naive: each fetch holds all its raw keyframes until the last is made: 24 fetches held 6.6 GB.
TEST(Slices, a_crowd_of_fetches_holds_no_more_raw_keyframes_than_there_is_room_for) {
    Bench bench(large);
    constexpr int fetches = 8; // of 12 MiB a keyframe, 6 keyframes each: twice the room
    std::mutex mutex;
    std::vector<sea::KeyframePtr> held;
    std::atomic<int> ended = 0;
    std::vector<std::shared_ptr<const void>> sessions;
    for (int i = 0; i < fetches; ++i)
        bench.simulation->fetch(
            {i * 60'000'000, i * 60'000'000 + 20'000'000, i * 60'000'000 + 40'000'000},
            {4u, all_but_foam},
            [&](Result<FetchedKeyframes> part) {
                ASSERT_TRUE(part);
                const std::scoped_lock lock(mutex);
                held.insert(held.end(), part->keyframes.begin(), part->keyframes.end());
                ended += part->last;
            },
            Asker(sessions.emplace_back(std::make_shared<char>())));
    const std::size_t fetch_room_bytes = Memory().share(MemoryUse::fetches);
    const std::size_t one = all_but_foam.size() * 512u * 512u * sizeof(float);
    // Questions that need no room go on meanwhile, and those that wait for it take no turns.
    const auto patience = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    const auto going_on = [&] {
        return ended < fetches && std::chrono::steady_clock::now() < patience;
    };
    while (bench.simulation->counters().fetch_bytes + one <= fetch_room_bytes && going_on())
        made_when_a_small_question_is_answered(bench);
    bench.settle();
    const std::uint64_t made = bench.simulation->counters().synthesis.keyframes;
    bench.settle();
    EXPECT_EQ(bench.simulation->counters().synthesis.keyframes, made) << "nothing is made ahead";
    EXPECT_LT(ended, fetches);
    while (going_on()) {
        const std::scoped_lock lock(mutex);
        held.clear(); // as the encoder does: each is let go
    }
    ASSERT_EQ(ended, fetches) << "some wait for room that nobody holds";
    held.clear();
    bench.settle(); // the thread that handed the last one over has let it go
    EXPECT_EQ(bench.simulation->counters().fetch_bytes, 0u);
    EXPECT_LE(bench.simulation->counters().fetch_bytes_most, fetch_room_bytes);
    EXPECT_GT(bench.simulation->counters().fetch_bytes_most, fetch_room_bytes / 2);
}

TEST(Slices, what_is_larger_than_all_room_is_made_when_nobody_else_holds_any) {
    const auto room = Room::of(100);
    const Room::Place small = room->take(1);
    ASSERT_TRUE(small);
    EXPECT_FALSE(room->fits(1000));
    EXPECT_FALSE(room->take(1000));
    EXPECT_TRUE(room->take(99));
    const_cast<Room::Place&>(small).reset();
    EXPECT_TRUE(room->take(1000));
    EXPECT_EQ(room->held_bytes(), 0u);
    EXPECT_EQ(room->held_bytes_most(), 1000u);
}

// Naive: one line for all. Ten sessions with 17 questions each let nobody else in for their time.
TEST(Slices, one_who_asks_much_delays_one_who_asks_little_by_a_slice) {
    Questions questions;
    std::string order;
    const auto ask = [&](const std::shared_ptr<const void>& who, char name, int slices) {
        questions.ask({[&order, name, left = slices]() mutable {
                           order += name;
                           return --left == 0;
                       },
                       [](const Error&) {}, Asker(who)});
    };
    const std::shared_ptr<const void> busy = std::make_shared<char>();
    const std::shared_ptr<const void> modest = std::make_shared<char>();
    for (int i = 0; i < 16; ++i)
        ask(busy, 'b', 2);
    ask(modest, 'm', 2);
    for (int i = 0; i < 6; ++i) {
        std::optional<Question> question = questions.take(0);
        ASSERT_TRUE(question);
        if (!question->slice())
            questions.put_back(*std::move(question));
        else
            questions.over(*question);
    }
    EXPECT_EQ(order, "bmbmbb");
}

TEST(Slices, one_asker_cannot_fill_the_line_and_who_comes_first_time_finds_room) {
    Questions questions;
    int refused = 0;
    const auto ask = [&](const Asker& asker) {
        questions.ask({[] { return true; },
                       [&](const Error& why) {
                           EXPECT_TRUE(why.is(Refusal::busy));
                           ++refused;
                       },
                       asker});
    };
    std::vector<std::shared_ptr<const void>> crowd;
    for (std::size_t i = 0; i * questions_of_one_max < questions_waiting_max; ++i) {
        crowd.push_back(std::make_shared<char>());
        for (std::size_t k = 0; k < questions_of_one_max + 1; ++k)
            ask(Asker(crowd.back()));
    }
    EXPECT_EQ(refused, static_cast<int>(crowd.size())) << "one of each is too many";
    const auto newcomer = std::make_shared<char>();
    ask(Asker(newcomer));
    EXPECT_EQ(refused, static_cast<int>(crowd.size()));
    ask(Asker(newcomer));
    EXPECT_EQ(refused, static_cast<int>(crowd.size()) + 1)
        << "the line is full, a second one waits";
}

// A question that is not ready is passed over, and so is who waits for nothing else.
TEST(Slices, a_question_that_is_not_ready_holds_up_nobody_behind_it) {
    Questions questions;
    bool ready = false;
    questions.ask({[] { return true; }, [](const Error&) {}, someone, [&] { return ready; }});
    EXPECT_FALSE(questions.take(0));
    std::string order;
    questions.ask({[&] { return order += 'x', true; }, [](const Error&) {}, someone});
    std::optional<Question> question = questions.take(0);
    ASSERT_TRUE(question);
    question->slice();
    questions.over(*question);
    EXPECT_EQ(order, "x") << "the one behind it";
    EXPECT_FALSE(questions.take(0));
    ready = true;
    questions.wake();
    EXPECT_FALSE(questions.take(0)) << "the wake itself";
    EXPECT_TRUE(questions.take(0));
}

// Naive: a device without memory for one request is taken for a lost one, three rebuilds long, and
// then for one that is gone for good: whoever asks for much ends the server for all.
TEST(Slices, a_request_for_which_there_is_no_memory_is_refused_and_nothing_is_lost) {
    Bench bench;
    bench.no_memory = 1;
    const auto refused = bench.fetch({0}, {1u, sea::surface_fields});
    ASSERT_FALSE(refused);
    EXPECT_TRUE(refused.error().is(Refusal::busy)) << refused.error().message;
    EXPECT_TRUE(bench.simulation->healthy());
    EXPECT_EQ(bench.simulation->counters().device_rebuilds, 0u);
    EXPECT_EQ(bench.answer({{1.0, 2.0, 0}}).size(), 1u);
    bench.subscriptions.set(1, {1u, sea::surface_fields});
    bench.no_memory = 1; // a keyframe of the stream: it is left out
    bench.advance(bench.sea->budget.cascades[0].interval_us);
    bench.advance(bench.sea->budget.cascades[0].interval_us);
    EXPECT_FALSE(bench.times(0).empty());
    EXPECT_TRUE(bench.simulation->healthy());
}

} // namespace
} // namespace seaway::server
