// SPDX-License-Identifier: Apache-2.0
// Few points of what is held are answered by who asks: no thread is woken for them. Only in their turn, and for no more than a
// share of the time of who asks, which has keyframes to send.
#include <thread>

#include "tests/server/simulation/simulation_bench.h"
#include "tests/support/eventually.h"

namespace seaway::server {
namespace {

class AtOnce : public ::testing::Test {
  protected:
    Bench bench;
    const std::vector<sea::QueryPoint> point = {{12.0, -7.0, second_us}};

    void SetUp() override { (void)bench.answer(point, false); } // keyframes and splines are there

    /// Answered by this thread before the call returns.
    bool here(const std::vector<sea::QueryPoint>& points, bool exact = false) {
        auto by = std::make_shared<std::atomic<std::thread::id>>();
        ++asked_;
        bench.simulation->answer(
            points, exact,
            [this, by](const auto& answers) {
                EXPECT_TRUE(answers);
                *by = std::this_thread::get_id();
                ++answered_;
            },
            someone);
        return *by == std::this_thread::get_id();
    }
    void expect_all_answered() {
        EXPECT_TRUE(tests::eventually([&] { return answered_ == asked_; }));
    }

  private:
    std::atomic<int> asked_ = 0, answered_ = 0;
};

TEST_F(AtOnce, a_point_of_what_is_held_is_answered_while_all_threads_are_at_something_else) {
    const Gate gate(bench);
    const std::uint64_t before = bench.simulation->counters().questions;
    EXPECT_TRUE(here(point));
    EXPECT_EQ(bench.simulation->counters().questions, before + 1) << "counted as any other";
}

TEST_F(AtOnce, what_takes_long_is_left_to_the_threads) {
    {
        const Gate gate(bench);
        EXPECT_FALSE(here(point, true)) << "an exact sum";
        EXPECT_FALSE(here({{12.0, -7.0, 900 * second_us}})) << "keyframes are to be made";
        EXPECT_FALSE(here(std::vector(100, point[0]))) << "many points";
    }
    expect_all_answered();
}

TEST_F(AtOnce, a_keyframe_without_its_spline_is_left_to_the_threads) {
    ASSERT_TRUE(bench.fetch({40 * second_us}, {3u, sea::surface_fields}));
    {
        const Gate gate(bench);
        EXPECT_FALSE(here({{12.0, -7.0, 40 * second_us}}));
    }
    expect_all_answered();
}

TEST_F(AtOnce, who_asks_without_end_gives_a_share_of_its_time_and_is_answered_all_the_same) {
    {
        const Gate gate(bench);
        int asked = 0;
        constexpr int forever = 1'000'000; // of some microseconds each: 2 ms and a fifth are less
        while (asked < forever && here(point))
            ++asked;
        EXPECT_GT(asked, 0);
        EXPECT_LT(asked, forever);
    }
    expect_all_answered();
}

Question to_answer(const Asker& asker) {
    Question question{[] { return true; }, [](const Error&) {}, asker};
    question.hand = [] { return Hand::answers; };
    question.prompt = true;
    question.price_us = 10;
    return question;
}

TEST(AtOnceInTurn, who_asks_is_given_its_question_where_nobody_comes_before) {
    Questions questions;
    const auto one = std::make_shared<char>(), other = std::make_shared<char>();
    std::optional<Question> mine = questions.ask_or_take(to_answer(Asker(one)));
    ASSERT_TRUE(mine);
    questions.spent(*mine, 1e6);
    questions.over(*mine);
    questions.ask(to_answer(Asker(other)));
    EXPECT_FALSE(questions.ask_or_take(to_answer(Asker(one)))) << "the other had less";
    EXPECT_TRUE(questions.ask_or_take(to_answer(Asker(std::make_shared<char>()))) == std::nullopt)
        << "and came first";
    for (int i = 0; i < 3; ++i) // they wait, and are given to others
        EXPECT_TRUE(questions.take_to_answer()) << i;
    Question device = to_answer(Asker(one));
    device.hand = [] { return Hand::simulation; };
    EXPECT_FALSE(questions.ask_or_take(std::move(device)));
}

TEST(AtOnceInTurn, what_who_asked_puts_back_wakes_a_thread_that_waits) {
    Questions questions;
    const auto one = std::make_shared<char>();
    std::optional<Question> mine = questions.ask_or_take(to_answer(Asker(one)));
    ASSERT_TRUE(mine);
    std::promise<void> taken;
    std::thread answers([&] {
        if (questions.take_to_answer())
            taken.set_value();
    });
    std::this_thread::sleep_for(std::chrono::milliseconds(20)); // it waits, most likely
    questions.put_back(*std::move(mine));
    EXPECT_EQ(taken.get_future().wait_for(std::chrono::seconds(60)), std::future_status::ready);
    questions.close(Error{"over"});
    answers.join();
}

} // namespace
} // namespace seaway::server
