// SPDX-License-Identifier: Apache-2.0
// Points are answered by threads of their own: whatever the simulation thread is at, in any number of
// threads, with the same bits; and what that thread alone can do is left to it.
#include <algorithm>
#include <bit>
#include <memory>
#include <new>
#include <utility>

#include "tests/server/simulation/simulation_bench.h"
#include "tests/support/allocations.h"
#include "tests/support/eventually.h"

namespace seaway::server {
namespace {

constexpr std::chrono::seconds soon{30}; ///< long enough for any machine

/// Holds the simulation thread alone.
class HeldSimulation {
  public:
    explicit HeldSimulation(Bench& bench) {
        std::promise<void> entered;
        bench.simulation->fetch(
            {}, {},
            [&entered, opened = opened_](const auto&) {
                entered.set_value();
                opened.wait();
            },
            someone);
        entered.get_future().wait();
    }
    ~HeldSimulation() { open_.set_value(); }

  private:
    std::promise<void> open_;
    const std::shared_future<void> opened_ = open_.get_future().share();
};

std::vector<sea::QueryPoint> some_points(int count, TimeUs step_us) {
    std::vector<sea::QueryPoint> points;
    for (int i = 0; i < count; ++i)
        points.push_back({7.3 * i, -11.1 * i, (i % 5) * step_us});
    return points;
}

/// Whether it is answered by and by, without the simulation thread.
bool is_answered(Bench& bench, std::vector<sea::QueryPoint> points, bool exact) {
    const auto answered = std::make_shared<std::promise<bool>>();
    bench.simulation->answer(
        std::move(points), exact,
        [answered](const auto& answers) { answered->set_value(answers.has_value()); }, someone);
    auto waits = answered->get_future();
    return waits.wait_for(soon) == std::future_status::ready && waits.get();
}

// Naive: points wait for the slice of a keyframe, a fetch, a tick of foam: up to 50 ms.
TEST(AnswerThreads, what_is_held_is_answered_while_the_simulation_thread_is_busy) {
    Bench bench;
    ASSERT_TRUE(bench.fetch({0}, {3u, sea::surface_fields})) << "keyframes, without splines";
    const HeldSimulation held(bench);
    EXPECT_TRUE(is_answered(bench, {{1, 2, 3}}, false));
    EXPECT_TRUE(is_answered(bench, some_points(500, 1), false));
}

TEST(AnswerThreads, exact_sums_need_no_simulation_thread) {
    Bench bench;
    const HeldSimulation held(bench);
    EXPECT_TRUE(is_answered(bench, some_points(20, second_us), true));
}

TEST(AnswerThreads, a_map_of_what_is_held_is_begun_while_the_simulation_thread_is_busy) {
    Bench bench;
    ASSERT_TRUE(bench.fetch({0}, {3u, sea::surface_fields}));
    const HeldSimulation held(bench);
    std::promise<bool> made;
    bench.simulation->surface(
        0, [&](const auto& surface) { made.set_value(surface.has_value()); }, someone);
    auto waits = made.get_future();
    ASSERT_EQ(waits.wait_for(soon), std::future_status::ready);
    EXPECT_TRUE(waits.get());
}

// Naive: a question about a sea of long ago has it made by the thread that has the stream, 0.2 s each.
TEST(AnswerThreads, make_the_seas_that_fetches_and_points_are_of) {
    Bench bench;
    for (int i = 0; i < 3; ++i)
        ASSERT_TRUE(bench.course->add(bench.sea->scene, (100 + 100 * i) * second_us,
                                      (120 + 100 * i) * second_us));
    const HeldSimulation held(bench);
    const auto is_made = [&](std::uint32_t epoch) {
        return tests::eventually([&] { return bench.course->sea_if_held(epoch) != nullptr; });
    };
    // Each has one long question under way.
    const std::shared_ptr<const void> one = std::make_shared<int>(), two = std::make_shared<int>();
    bench.simulation->fetch(
        {150 * second_us}, {1u, {Field::height}}, [](const auto&) {}, Asker(one));
    EXPECT_TRUE(is_made(3)) << "by a fetch";
    bench.simulation->answer(
        {{1, 2, 250 * second_us}}, false, [](const auto&) {}, Asker(two));
    EXPECT_TRUE(is_made(5)) << "by a point";
    EXPECT_TRUE(is_answered(bench, {{1, 2, 350 * second_us}}, true));
    EXPECT_TRUE(is_made(7)) << "by an exact sum";
}

TEST(AnswerThreads, what_is_not_held_waits_for_the_simulation_thread_and_holds_up_nobody_else) {
    Bench bench;
    ASSERT_TRUE(bench.fetch({0}, {3u, sea::surface_fields}));
    std::promise<bool> far;
    auto far_made = far.get_future();
    {
        const HeldSimulation held(bench);
        bench.simulation->answer(
            {{1, 2, 3'600'000'000}}, false,
            [&](const auto& answers) { far.set_value(answers.has_value()); }, someone);
        for (int i = 0; i < 20; ++i)
            ASSERT_TRUE(is_answered(bench, {{1, 2, 3}}, false)) << i;
        EXPECT_EQ(far_made.wait_for(std::chrono::seconds(0)), std::future_status::timeout);
    }
    EXPECT_TRUE(far_made.get());
}

// Times that share keyframes and times that do not, in batches that are preempted by each other.
TEST(AnswerThreads, give_the_same_bits_however_many_ask_at_once) {
    const auto bits = [](double value) { return std::bit_cast<std::uint64_t>(value); };
    Bench bench;
    for (const bool exact : {false, true}) {
        const std::vector<sea::QueryPoint> points = some_points(400, 1'700'000);
        const std::vector<sea::Answer> alone = Bench().answer(points, exact);
        std::vector<std::promise<std::vector<sea::Answer>>> many(12);
        std::vector<std::shared_ptr<const void>> here;
        for (auto& one : many)
            bench.simulation->answer(
                points, exact, [&](const auto& answers) { one.set_value(*answers); },
                Asker(here.emplace_back(std::make_shared<char>())));
        for (auto& one : many) {
            const std::vector<sea::Answer> answers = one.get_future().get();
            ASSERT_EQ(answers.size(), alone.size());
            for (std::size_t i = 0; i < alone.size(); ++i) {
                EXPECT_EQ(bits(answers[i].height_m), bits(alone[i].height_m));
                for (int k = 0; k < 3; ++k) {
                    EXPECT_EQ(bits(answers[i].normal[k]), bits(alone[i].normal[k]));
                    EXPECT_EQ(bits(answers[i].velocity_mps[k]), bits(alone[i].velocity_mps[k]));
                }
                EXPECT_EQ(answers[i].flags, alone[i].flags);
            }
        }
    }
}

TEST(AnswerThreads, one_that_does_not_come_on_shows) {
    Bench bench;
    std::promise<void> open;
    const auto opened = open.get_future().share();
    bench.simulation->answer(
        {}, false, [opened](const auto&) { opened.wait(); }, someone);
    const auto comes = [&](const auto& condition) {
        return tests::eventually([&] { return condition(bench.simulation->turn()); });
    };
    EXPECT_TRUE(comes([](auto turn) { return turn > std::chrono::milliseconds(100); }));
    open.set_value();
    EXPECT_TRUE(comes([](auto turn) { return turn == std::chrono::milliseconds(0); }));
}

// Of three threads: who has asked for so much waits a third of what it would wait for one. The rate is so low that the
// account stands still while the test runs.
TEST(AnswerThreads, a_share_of_the_work_is_a_share_of_all_threads) {
    constexpr double rate = 1e-3, burst_us = 1000;
    Bench bench({}, {.rate = rate, .burst_s = 1e-6 * burst_us});
    const std::vector<sea::QueryPoint> points = some_points(4096, 1);
    const double price_us = Prices(bench.course).exact_us(points);
    const Gate gate(bench); // nothing is settled
    std::promise<double> retry;
    const auto here = std::make_shared<char>();
    bench.simulation->answer(
        points, true, [](const auto&) {}, Asker(here));
    bench.simulation->answer(
        points, true,
        [&](const auto& answers) {
            retry.set_value(answers ? 0.0 : answers.error().retry_after_ms);
        },
        Asker(here));
    auto refused = retry.get_future();
    ASSERT_EQ(refused.wait_for(std::chrono::seconds(0)), std::future_status::ready);
    const double expected_ms = (price_us - burst_us) / (3 * rate) / 1000;
    EXPECT_NEAR(refused.get(), expected_ms, 0.1 * expected_ms);
}

Question question_for(Hand hand, const Asker& asker, const char* name, std::string& order,
                      bool prompt = false) {
    Question question{[&order, name] {
                          order += name;
                          return false;
                      },
                      [](const Error&) {}, asker};
    question.hand = [hand] { return hand; };
    question.prompt = prompt;
    return question;
}

TEST(Hands, each_takes_what_is_for_it) {
    Questions questions;
    std::string order;
    const auto here = std::make_shared<char>(), there = std::make_shared<char>();
    questions.ask(question_for(Hand::answers, Asker(here), "a", order));
    EXPECT_FALSE(questions.take(0));
    questions.ask(question_for(Hand::simulation, Asker(there), "s", order));
    questions.take(0)->slice();
    questions.take_to_answer()->slice();
    EXPECT_EQ(order, "sa");
}

// Naive: two threads, two batches of one asker under way, and what both hold.
TEST(Hands, have_one_long_question_of_an_asker_under_way_and_all_of_its_prompt_ones) {
    Questions questions;
    std::string order;
    const auto one = std::make_shared<char>(), other = std::make_shared<char>();
    for (const char* name : {"1", "2"})
        questions.ask(question_for(Hand::answers, Asker(one), name, order));
    questions.ask(question_for(Hand::answers, Asker(other), "x", order));
    std::optional<Question> first = questions.take_to_answer();
    std::optional<Question> second = questions.take_to_answer();
    first->slice();
    second->slice();
    EXPECT_TRUE(order == "1x" || order == "x1") << order;
    questions.put_back(*std::move(order == "1x" ? first : second));
    order.clear();
    questions.take_to_answer()->slice();
    EXPECT_EQ(order, "1") << "the one that has begun, not the next one";
    for (const char* name : {"p", "q"})
        questions.ask(question_for(Hand::answers, Asker(one), name, order, true));
    questions.take_to_answer()->slice();
    questions.take_to_answer()->slice();
    EXPECT_EQ(order, "1pq");
}

// The simulation works on a fetch of an asker; its batch does not begin meanwhile, however idle the others are.
TEST(Hands, a_long_question_in_one_hand_keeps_the_next_of_its_asker_from_the_other) {
    Questions questions;
    std::string order;
    const auto here = std::make_shared<char>();
    questions.ask(question_for(Hand::simulation, Asker(here), "fetch ", order));
    questions.ask(question_for(Hand::answers, Asker(here), "batch", order));
    std::optional<Question> fetch = questions.take(0);
    ASSERT_TRUE(fetch);
    std::atomic<bool> over = false;
    std::atomic<bool> over_before = false;
    std::thread answers([&] {
        std::optional<Question> batch = questions.take_to_answer();
        over_before = over.load();
        batch->slice();
        questions.over(*batch);
    });
    fetch->slice();
    questions.put_back(*std::move(fetch));
    fetch = questions.take(0);
    ASSERT_TRUE(fetch);
    over = true;
    questions.over(*fetch);
    answers.join();
    EXPECT_TRUE(over_before);
    EXPECT_EQ(order, "fetch batch");
}

// Naive: its place in line is made anew each time, and where there is no memory for that the question is lost and nobody hears of it.
TEST(Hands, what_goes_on_comes_back_into_its_line_without_memory) {
    for (const bool prompt : {true, false}) {
        Questions questions;
        std::string order;
        const auto here = std::make_shared<char>();
        for (const char* name : {"a", "b", "c"})
            questions.ask(question_for(Hand::answers, Asker(here), name, order, prompt));
        for (int i = 0; i < 8; ++i) {
            std::optional<Question> taken = questions.take_to_answer();
            ASSERT_TRUE(taken);
            const tests::NoMemoryOnce none(0);
            questions.put_back(*std::move(taken));
        }
        for (int i = 0; i < 3; ++i) {
            const std::optional<Question> taken = questions.take_to_answer();
            ASSERT_TRUE(taken);
            taken->slice();
            questions.over(*taken);
        }
        std::ranges::sort(order);
        EXPECT_EQ(order, "abc") << "each is there, once";
    }
}

// Naive: the first refusal for which there is no memory is the last one, and the thread that says them ends with it.
TEST(Hands, whoever_waits_or_comes_back_at_the_end_is_refused_though_there_is_no_memory_at_first) {
    Questions questions;
    std::string order, told;
    const auto asked = [&](const char* name) {
        Question question = question_for(Hand::simulation, someone, name, order);
        question.refuse = [&told, name, first = std::make_shared<bool>(true)](const Error& why) {
            if (std::exchange(*first, false))
                throw std::bad_alloc();
            told += name + why.message + " ";
        };
        return question;
    };
    for (const char* name : {"a ", "b ", "c "})
        questions.ask(asked(name));
    std::optional<Question> taken = questions.take(0);
    ASSERT_TRUE(taken);
    questions.close(Error{Refusal::gone, "ends"});
    EXPECT_EQ(told, "b ends c ends ");
    questions.put_back(*std::move(taken));
    EXPECT_EQ(told, "b ends c ends a ends ");
}

TEST(Hands, who_comes_back_after_the_end_is_refused_with_the_reason) {
    Questions questions;
    std::string order;
    Question asked = question_for(Hand::answers, someone, "a", order);
    std::string why;
    asked.refuse = [&](const Error& error) { why += error.message; };
    questions.ask(std::move(asked));
    std::optional<Question> taken = questions.take_to_answer();
    questions.close(Error{Refusal::gone, "the end"});
    EXPECT_FALSE(questions.take_to_answer()) << "nobody waits any more";
    EXPECT_EQ(why, "");
    questions.put_back(*std::move(taken));
    EXPECT_EQ(why, "the end");
}

} // namespace
} // namespace seaway::server
