// SPDX-License-Identifier: Apache-2.0
// What an asker may have worked for it, and whose turn it is: on numbers that are given, without a clock.
#include "tests/server/simulation/simulation_bench.h"

namespace seaway::server {
namespace {

TEST(Accounts, who_waits_for_answers_at_a_rate_of_one_is_never_refused) {
    Account account({.rate = 1, .burst_s = 2}, 0);
    double now_s = 0;
    for (int i = 0; i < 1000; ++i) {
        ASSERT_TRUE(account.may_ask(now_s));
        account.take(1.5e6);
        now_s += 1.5; // it took as long as it was priced
    }
}

TEST(Accounts, what_is_saved_up_may_be_spent_at_once_and_a_debt_is_waited_for) {
    Account account({.rate = 0.5, .burst_s = 10}, 100);
    account.take(9e6);
    ASSERT_TRUE(account.may_ask(100)) << "a second is left";
    account.take(4e6);
    EXPECT_FALSE(account.may_ask(100));
    EXPECT_NEAR(account.wait_s(), 6, 1e-3) << "3 s of work at half a second a second";
    EXPECT_FALSE(account.may_ask(105.9));
    EXPECT_TRUE(account.may_ask(106.1));
    account.take(1e6);
    account.give_back(0.9e6); // it took less
    EXPECT_TRUE(account.may_ask(106.1 + 0.2));
    EXPECT_TRUE(account.may_ask(1e6));
    account.give_back(1e9);
    account.take(10.5e6);
    EXPECT_FALSE(account.may_ask(1e6)) << "no more is saved up than the burst";
}

/// Questions whose slices take what they are said to take, on a clock that stands.
struct Desk {
    double now_s = 0;
    Questions questions;
    std::vector<std::shared_ptr<const void>> here;
    std::vector<std::string> order; ///< one name a slice
    std::vector<Error> refusals;

    explicit Desk(WorkBudget budget = {.rate = 1, .burst_s = 1e6})
        : questions(budget, Memory().room(MemoryUse::points), [this] { return now_s; }) {}

    Asker newcomer() { return Asker(here.emplace_back(std::make_shared<char>())); }

    void ask(const Asker& asker, const std::string& name, double price_us, bool prompt = false,
             double slice_us = 1000) {
        const auto left_us = std::make_shared<double>(price_us);
        questions.ask({.slice =
                           [this, left_us, name, slice_us] {
                               order.push_back(name);
                               *left_us -= slice_us;
                               return *left_us <= 0;
                           },
                       .refuse = [this](const Error& why) { refusals.push_back(why); },
                       .asker = asker,
                       .price_us = price_us,
                       .prompt = prompt});
    }

    /// One slice, as the simulation works; false: nothing waits.
    bool work(double slice_us = 1000) {
        std::optional<Question> question = questions.take(0);
        if (!question)
            return false;
        const bool done = question->slice();
        questions.spent(*question, slice_us);
        if (!done) {
            questions.put_back(*std::move(question));
            return true;
        }
        questions.over(*question);
        return true;
    }
};

// Naive: a slice for each asker in turn: a single point waits for a slice of each of eight floods, and for
// as many again for each slice that it takes itself.
TEST(FairTurns, a_single_point_goes_next_however_many_flood) {
    Desk desk;
    for (int i = 0; i < 8; ++i) {
        const Asker flood = desk.newcomer();
        for (int k = 0; k < 16; ++k)
            desk.ask(flood, "flood", 1e6);
    }
    for (int i = 0; i < 500; ++i)
        desk.work();
    const Asker healthy = desk.newcomer();
    for (int round = 0; round < 20; ++round) {
        desk.order.clear();
        desk.ask(healthy, "point", 3000, true); // three slices
        for (int i = 0; i < 10; ++i)
            desk.work();
        ASSERT_EQ(std::ranges::count(desk.order, "point"), 3);
        EXPECT_EQ(desk.order[2], "point") << "nobody in between, round " << round;
    }
}

TEST(FairTurns, two_floods_of_batches_large_and_small_have_equal_shares) {
    Desk desk;
    const Asker large = desk.newcomer(), small = desk.newcomer();
    for (int i = 0; i < 60; ++i)
        desk.ask(large, "large", 100'000);
    for (int i = 0; i < 60; ++i)
        desk.ask(small, "small", 10'000);
    for (int i = 0; i < 1000; ++i)
        desk.work();
    const auto of_large = std::ranges::count(desk.order, "large");
    // Equal but for one batch of the large ones.
    EXPECT_NEAR(static_cast<double>(of_large), 500, 100);
}

TEST(FairTurns, of_two_who_come_together_the_one_who_asks_for_little_is_done_first) {
    Desk desk;
    desk.ask(desk.newcomer(), "much", 100'000);
    desk.ask(desk.newcomer(), "little", 3000);
    for (int i = 0; i < 4; ++i)
        desk.work();
    EXPECT_EQ(desk.order, (std::vector<std::string>{"little", "little", "little", "much"}));
}

// It has its head start, 50 ms, and then its share: not what the others were served before it came.
TEST(FairTurns, a_newcomer_has_a_head_start_and_no_more) {
    Desk desk;
    const Asker floods[] = {desk.newcomer(), desk.newcomer()};
    const auto ask_on = [&] {
        for (const Asker& flood : floods)
            desk.ask(flood, "flood", 5000);
    };
    for (int i = 0; i < 1000; ++i) {
        if (i % 8 == 0) // both always have something waiting
            ask_on();
        desk.work();
    }
    for (int i = 0; i < 20; ++i)
        ask_on();
    const Asker newcomer = desk.newcomer();
    for (int i = 0; i < 30; ++i)
        desk.ask(newcomer, "newcomer", 5000);
    desk.order.clear();
    for (int i = 0; i < 110; ++i)
        desk.work();
    // 50 slices of 1 ms at once, then a third of 60; batches are of 5.
    EXPECT_EQ(std::count(desk.order.begin(), desk.order.begin() + 45, "newcomer"), 45);
    EXPECT_NEAR(static_cast<double>(std::ranges::count(desk.order, "newcomer")), 70, 10);
}

TEST(FairTurns, a_batch_is_worked_on_though_single_points_never_end) {
    Desk desk;
    const Asker batch = desk.newcomer(), points = desk.newcomer();
    desk.ask(batch, "batch", 50'000);
    for (int i = 0; i < 400; ++i) {
        desk.ask(points, "point", 1000, true);
        desk.work();
    }
    // 50 ms are owed after 200 points of 1 ms; from then on every fifth slice is the batch's.
    EXPECT_EQ(std::ranges::count(desk.order, "batch"), 40);
}

TEST(FairTurns, of_one_asker_points_do_not_wait_for_batches_and_batches_come_one_by_one) {
    Desk desk;
    const Asker asker = desk.newcomer();
    for (const char* name : {"first", "second"})
        desk.ask(asker, name, 5000);
    desk.work();
    desk.ask(asker, "point", 1000, true);
    desk.work();
    desk.work();
    EXPECT_EQ(std::ranges::count(desk.order, "point"), 1) << "at most one slice before it";
    while (desk.work())
        ;
    const auto second = std::ranges::find(desk.order, "second");
    EXPECT_EQ(std::count(desk.order.begin(), second, "first"), 5);
}

TEST(Budgets, who_asks_for_more_than_its_budget_is_told_when_to_ask_again_and_others_are_not) {
    Desk desk({.rate = 0.5, .burst_s = 1});
    const Asker flood = desk.newcomer(), other = desk.newcomer();
    desk.ask(flood, "flood", 0.9e6);
    desk.ask(flood, "flood", 2e6);
    EXPECT_TRUE(desk.refusals.empty()) << "one request may leave a debt";
    desk.ask(flood, "flood", 1);
    ASSERT_EQ(desk.refusals.size(), 1u);
    EXPECT_TRUE(desk.refusals[0].is(Refusal::busy));
    EXPECT_NEAR(desk.refusals[0].retry_after_ms, 3800, 2)
        << "1.9 s of work at half a second a second";
    EXPECT_NE(desk.refusals[0].message.find("3.8 s"), std::string::npos);
    desk.ask(other, "other", 1);
    EXPECT_EQ(desk.refusals.size(), 1u);
    EXPECT_EQ(desk.questions.over_budget(), 1u);
    // What takes long to price is not priced for that.
    ASSERT_TRUE(desk.questions.why_not(flood, 0));
    EXPECT_EQ(desk.questions.why_not(flood, 0)->message, desk.refusals[0].message);
    EXPECT_FALSE(desk.questions.why_not(other, 0));
    desk.now_s = 3.7;
    desk.ask(flood, "flood", 1);
    EXPECT_EQ(desk.refusals.size(), 2u);
    desk.now_s = 3.9;
    desk.ask(flood, "flood", 1);
    EXPECT_EQ(desk.refusals.size(), 2u);
}

TEST(Budgets, what_takes_less_than_it_was_priced_at_is_given_back) {
    Desk desk({.rate = 1, .burst_s = 1});
    const Asker asker = desk.newcomer();
    for (int i = 0; i < 50; ++i) {
        desk.ask(asker, "cheap", 1.5e6, false, 2e6); // done in one slice of 1 ms: it was held
        ASSERT_TRUE(desk.work());
        desk.now_s += 0.001;
    }
    EXPECT_TRUE(desk.refusals.empty());
}

// Naive: what was worked beyond the price is taken at the end, when a bucket that was full all the while has what has flowed in
// for one of them only: whoever had waited half a minute on a busy machine was refused the second question of the next four.
TEST(Budgets, who_has_waited_for_what_took_far_longer_than_its_price_is_not_refused) {
    Desk desk({.rate = 1, .burst_s = 10});
    const Asker asker = desk.newcomer();
    bool asks_again = false;
    for (int round = 0; round < 3; ++round) {
        int slices = 350;
        desk.questions.ask({.slice =
                                [&] {
                                    asks_again = --slices == 0;
                                    return asks_again;
                                },
                            .refuse = [&](const Error& why) { desk.refusals.push_back(why); },
                            .asker = asker,
                            .price_us = 0.7e6});
        while (std::optional<Question> question = desk.questions.take(0)) {
            desk.now_s += 0.1;
            const bool done = question->slice();
            if (asks_again) // its answer is there before anybody has counted the last slice
                desk.ask(asker, "next", 1000);
            desk.questions.spent(*question, 0.1e6);
            if (!done) {
                desk.questions.put_back(*std::move(question));
                continue;
            }
            desk.questions.over(*question);
            desk.ask(asker, "and one more", 1000);
            break;
        }
        while (desk.work())
            ;
        ASSERT_TRUE(desk.refusals.empty()) << desk.refusals[0].message;
    }
}

TEST(Budgets, what_takes_longer_than_it_was_priced_at_is_paid) {
    Desk desk({.rate = 1, .burst_s = 1});
    const Asker asker = desk.newcomer();
    desk.ask(asker, "dear", 2000, false, 1000); // two slices
    ASSERT_TRUE(desk.work(0.8e6) && desk.work(1.2e6));
    EXPECT_TRUE(desk.refusals.empty());
    desk.ask(asker, "next", 1);
    ASSERT_EQ(desk.refusals.size(), 1u);
    EXPECT_NEAR(desk.refusals[0].retry_after_ms, 1000, 2) << "a second beyond the one saved up";
}

// 100 MB of legal queries, and their sender leaves: what it had waiting is gone before anything else is
// worked on, and shuts nobody out.
TEST(Budgets, what_waits_of_who_has_left_is_dropped_before_anything_is_worked_on) {
    Desk desk;
    auto here = std::make_shared<char>();
    const Asker healthy = desk.newcomer();
    for (int i = 0; i < 60; ++i)
        desk.ask(Asker(here), "left", 1e9);
    desk.ask(healthy, "point", 1000, true);
    here = nullptr;
    std::size_t dropped = 0;
    for (int i = 0; i < 60; ++i) {
        const std::optional<Question> question = desk.questions.take(0);
        ASSERT_TRUE(question);
        dropped += question->asker.gone();
        desk.questions.over(*question);
    }
    EXPECT_EQ(dropped, 60u);
    EXPECT_TRUE(desk.work());
    EXPECT_EQ(desk.order, std::vector<std::string>{"point"});
}

TEST(Budgets, points_that_wait_fill_their_memory_and_who_has_a_few_finds_room) {
    Desk desk;
    const std::size_t batch = PointQuestion::bytes_of(4096);
    std::size_t asked = 0;
    const auto ask = [&](const Asker& asker, std::size_t bytes) {
        desk.questions.ask({.slice = [] { return true; },
                            .refuse = [&](const Error& why) { desk.refusals.push_back(why); },
                            .asker = asker,
                            .bytes = bytes});
        ++asked;
    };
    while (desk.refusals.empty()) {
        const Asker flood = desk.newcomer();
        for (int i = 0; i < 16 && desk.refusals.empty(); ++i)
            ask(flood, batch);
        ASSERT_LT(asked, 1000u);
    }
    EXPECT_TRUE(desk.refusals[0].is(Refusal::busy));
    EXPECT_GT(desk.refusals[0].retry_after_ms, 0u);
    EXPECT_LE(desk.questions.bytes(), Memory().share(MemoryUse::points) / 2 + 16 * batch);
    const Asker healthy = desk.newcomer();
    for (int i = 0; i < 16; ++i)
        ask(healthy, PointQuestion::bytes_of(1));
    EXPECT_EQ(desk.refusals.size(), 1u);
    while (const std::optional<Question> question = desk.questions.take(0))
        desk.questions.over(*question);
    EXPECT_EQ(desk.questions.bytes(), 0u);
}

// Of many sessions that come, ask and go nothing is left; who owes something is remembered.
TEST(Budgets, a_debt_is_remembered_while_its_session_lasts) {
    Desk desk({.rate = 1, .burst_s = 1});
    const Asker flood = desk.newcomer();
    desk.ask(flood, "flood", 5e6, false, 5e6);
    ASSERT_TRUE(desk.work(5e6));
    for (int i = 0; i < 1000; ++i) {
        const auto here = std::make_shared<char>();
        desk.ask(Asker(here), "passing", 1000, true);
        ASSERT_TRUE(desk.work());
    }
    EXPECT_TRUE(desk.refusals.empty());
    desk.ask(flood, "flood", 1);
    EXPECT_EQ(desk.refusals.size(), 1u);
}

} // namespace
} // namespace seaway::server
