// SPDX-License-Identifier: Apache-2.0
#include <random>
#include <thread>

#include <gtest/gtest.h>

#include "server/journal/sea_clock.h"

namespace seaway::server {
namespace {

using sea::TimeUs;

constexpr std::int64_t second_us = 1'000'000;
constexpr std::int64_t epoch_us = 1'700'000'000 * second_us;

/// A machine whose two clocks are moved by hand.
struct Machine {
    std::int64_t utc_us = epoch_us + 100 * second_us;
    std::int64_t steady_us = 77;

    SeaClock clock() {
        return SeaClock(
            epoch_us, [this] { return utc_us; }, [this] { return steady_us; });
    }
    void pass(std::int64_t us) {
        utc_us += us;
        steady_us += us;
    }
};

TEST(SeaClock, says_how_long_ago_the_epoch_was_by_utc) {
    Machine machine;
    SeaClock clock = machine.clock();
    EXPECT_EQ(clock.now_us(), 100 * second_us);
    machine.pass(1'234'567);
    EXPECT_EQ(clock.now_us(), 101'234'567);
    EXPECT_EQ(clock.moment().behind_us, 0);
    EXPECT_EQ(clock.moment().epoch_utc_us, epoch_us);
    // A process that starts later, on a machine that was started meanwhile, goes on where the first one is.
    machine.steady_us = 3;
    SeaClock restarted = machine.clock();
    EXPECT_EQ(restarted.now_us(), 101'234'567);
}

TEST(SeaClock, counts_backwards_before_its_epoch) {
    Machine machine;
    machine.utc_us = epoch_us - 5 * second_us;
    SeaClock clock = machine.clock();
    EXPECT_EQ(clock.now_us(), -5 * second_us);
    machine.pass(2 * second_us);
    EXPECT_EQ(clock.now_us(), -3 * second_us);
}

// UTC set back or forward by up to ten seconds: no step, at most one part in 2500 besides the time that passes, and
// in the end the sea is where UTC says.
TEST(SeaClock, is_pulled_and_never_steps_where_utc_is_set_by_a_little) {
    for (const std::int64_t set_us : {-9 * second_us, -1'000L, 1'000L, 9 * second_us}) {
        Machine machine;
        SeaClock clock = machine.clock();
        machine.utc_us += set_us;
        EXPECT_EQ(clock.moment().behind_us, set_us);
        TimeUs before_us = clock.now_us();
        std::mt19937 random(12);
        std::int64_t passed_us = 0;
        while (passed_us < 25'000 * second_us) {
            const std::int64_t step_us = random() % 2 ? 1 + random() % 50 : random() % second_us;
            machine.pass(step_us);
            passed_us += step_us;
            const TimeUs now_us = clock.now_us();
            ASSERT_GE(now_us, before_us) << "backwards";
            // One microsecond is what is left of the last pull.
            ASSERT_LE(std::abs(now_us - before_us - step_us), 1 + step_us / 2500);
            before_us = now_us;
        }
        EXPECT_EQ(clock.moment().behind_us, 0) << set_us;
        EXPECT_EQ(clock.now_us(), machine.utc_us - epoch_us);
    }
}

// Naive: a process that is stopped between the looks at its two clocks catches up twice.
TEST(SeaClock, is_right_where_it_was_stopped_between_its_looks_at_two_clocks) {
    Machine machine;
    std::int64_t stop_us = 0;
    const auto stopped = [&] { machine.pass(std::exchange(stop_us, 0)); };
    SeaClock clock(
        epoch_us,
        [&] {
            const std::int64_t utc_us = machine.utc_us;
            stopped();
            return utc_us;
        },
        [&] {
            const std::int64_t steady_us = machine.steady_us;
            stopped();
            return steady_us;
        });
    stop_us = 15 * second_us; // behind the first of them, whichever that is
    (void)clock.now_us();
    machine.pass(second_us);
    EXPECT_NEAR(static_cast<double>(clock.now_us()), static_cast<double>(machine.utc_us - epoch_us),
                10'000);
}

TEST(SeaClock, is_pulled_as_fast_however_often_it_is_read) {
    Machine seldom, often;
    SeaClock one = seldom.clock(), other = often.clock();
    seldom.utc_us += second_us;
    often.utc_us += second_us;
    for (int i = 0; i < 100'000; ++i) {
        often.pass(100);
        other.now_us();
    }
    seldom.pass(100 * 100'000);
    EXPECT_EQ(other.moment().behind_us, one.moment().behind_us);
    EXPECT_EQ(one.moment().behind_us, second_us - 4'000);
}

TEST(SeaClock, follows_at_once_where_utc_is_far_ahead_and_never_goes_back) {
    Machine machine;
    SeaClock clock = machine.clock();
    machine.utc_us += 3600 * second_us; // the machine slept
    EXPECT_EQ(clock.now_us(), 3700 * second_us);
    EXPECT_EQ(clock.moment().behind_us, 0);
    machine.utc_us -= 3600 * second_us; // its clock was wrong
    EXPECT_EQ(clock.now_us(), 3700 * second_us);
    EXPECT_EQ(clock.moment().behind_us, -3600 * second_us);
    machine.steady_us -= 5; // no steady clock does that; the sea's still does not go back
    EXPECT_EQ(clock.now_us(), 3700 * second_us);
}

TEST(SeaClock, follows_its_paces_and_goes_on_with_them_after_a_restart) {
    Machine machine;
    SeaClock clock = machine.clock();
    EXPECT_EQ(clock.wait_us(101 * second_us), second_us);
    const sea::Pace half = clock.next_pace(101 * second_us, 500);
    clock.follow(half);
    EXPECT_EQ(clock.wait_us(102 * second_us), 3 * second_us) << "a second, then two";
    EXPECT_EQ(clock.hurried(7), 7);
    machine.pass(3 * second_us);
    EXPECT_EQ(clock.now_us(), 102 * second_us);
    EXPECT_EQ(clock.moment().elapsed_us, 103 * second_us);
    EXPECT_EQ(clock.moment().pace_permille, 500);
    const sea::Pace none = clock.next_pace(104 * second_us, 0);
    const sea::Pace fast = {200 * second_us, none.sea_us, 4000};
    clock.follow(none);
    machine.pass(60 * second_us);
    EXPECT_EQ(clock.now_us(), none.sea_us);
    EXPECT_EQ(clock.wait_us(none.sea_us + 1), std::nullopt);
    clock.follow(fast);
    EXPECT_EQ(clock.hurried(7), 28) << "before it holds: what is to be there by then";
    sea::Paces paces;
    for (const sea::Pace& pace : {half, none, fast})
        paces.add(pace);
    SeaClock restarted(
        epoch_us, [&] { return machine.utc_us; }, [&] { return machine.steady_us; }, paces);
    for (int i = 0; i < 100; ++i, machine.pass(777'777))
        ASSERT_EQ(restarted.now_us(), clock.now_us());
    EXPECT_GT(clock.now_us(), none.sea_us + 100 * second_us);
}

// Naive: a pause that was late to be written sets the sea back to when it was to begin.
TEST(SeaClock, stands_until_a_pace_that_began_in_the_past_has_come_to_where_it_is) {
    Machine machine;
    SeaClock clock = machine.clock();
    machine.pass(2 * second_us);
    EXPECT_EQ(clock.now_us(), 102 * second_us);
    clock.follow({101 * second_us, 101 * second_us, 500});
    EXPECT_EQ(clock.now_us(), 102 * second_us);
    machine.pass(second_us);
    EXPECT_EQ(clock.now_us(), 102 * second_us);
    machine.pass(2 * second_us);
    EXPECT_EQ(clock.now_us(), 103 * second_us);
}

TEST(SeaClock, never_goes_backwards_for_many_readers_of_the_machines_own_clocks) {
    SeaClock clock(SeaClock::utc_now_us());
    std::atomic<int> backwards = 0;
    std::vector<std::thread> readers;
    for (int r = 0; r < 4; ++r)
        readers.emplace_back([&] {
            TimeUs before_us = clock.now_us();
            for (int i = 0; i < 20'000; ++i) {
                const TimeUs now_us = clock.now_us();
                backwards += now_us < before_us;
                before_us = now_us;
            }
        });
    for (std::thread& reader : readers)
        reader.join();
    EXPECT_EQ(backwards, 0);
}

TEST(UtcText, is_iso_8601_to_the_microsecond) {
    EXPECT_EQ(utc_text(0), "1970-01-01T00:00:00.000000Z");
    EXPECT_EQ(utc_text(-1), "1969-12-31T23:59:59.999999Z");
    // date -u -d @1700000000 says Tue Nov 14 22:13:20 UTC 2023; 951782400 is 29 February 2000.
    EXPECT_EQ(utc_text(1'700'000'000'000'250), "2023-11-14T22:13:20.000250Z");
    EXPECT_EQ(utc_text(951'782'400'000'000), "2000-02-29T00:00:00.000000Z");
    // date -u -d @253402300799 says Fri Dec 31 23:59:59 UTC 9999.
    EXPECT_EQ(utc_text(253'402'300'799'999'999), "9999-12-31T23:59:59.999999Z");
    EXPECT_EQ(utc_text(253'402'300'800'000'000), "253402300800000000 us since 1970");
    EXPECT_EQ(utc_text(-62'167'219'200'000'000), "0000-01-01T00:00:00.000000Z");
    EXPECT_EQ(utc_text(-62'167'219'200'000'001), "-62167219200000001 us since 1970");
    EXPECT_EQ(utc_text(std::numeric_limits<std::int64_t>::max()),
              "9223372036854775807 us since 1970");
    EXPECT_EQ(utc_text(std::numeric_limits<std::int64_t>::min()),
              "-9223372036854775808 us since 1970");
}

} // namespace
} // namespace seaway::server
