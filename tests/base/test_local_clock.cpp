// SPDX-License-Identifier: Apache-2.0
// LocalClock over clocks that a test turns.
#include <chrono>

#include <gtest/gtest.h>

#include "base/local_clock.h"

namespace seaway {
namespace {

std::int64_t oscillator_ns = 0, bent_ns = 0, sleep_ns = 0, preempted_ns = 0;

LocalClock clock_of_test() {
    oscillator_ns = bent_ns = 7'000'000'000;
    sleep_ns = 40'000'000'000; // before this program began
    preempted_ns = 0;
    return LocalClock({[] { return oscillator_ns; }, [] { return bent_ns; },
                       [] {
                           const std::int64_t late_ns = preempted_ns;
                           preempted_ns = 0;
                           oscillator_ns += late_ns;
                           bent_ns += late_ns;
                           return bent_ns + sleep_ns;
                       }});
}

TEST(LocalClock, goes_on_while_the_machine_sleeps) {
    LocalClock clock = clock_of_test();
    const std::int64_t before_us = clock.now_us();
    sleep_ns += 300'000'000'000;
    oscillator_ns += 1'000'000;
    bent_ns += 1'000'000;
    EXPECT_EQ(clock.now_us() - before_us, 300'001'000);
    EXPECT_EQ(clock.now_us() - before_us, 300'001'000) << "once";
}

// As by a daemon that takes out an error of the date.
TEST(LocalClock, is_not_bent_with_the_systems_clock) {
    LocalClock clock = clock_of_test();
    const std::int64_t before_us = clock.now_us();
    for (int i = 0; i < 100; ++i) {
        oscillator_ns += 10'000'000;
        bent_ns += 10'800'000;
        EXPECT_EQ(clock.now_us() - before_us, (i + 1) * 10'000);
    }
}

// Naive: what passes between the looks at two clocks is taken for sleep.
TEST(LocalClock, who_loses_its_processor_between_two_looks_has_not_slept) {
    LocalClock clock = clock_of_test();
    const std::int64_t before_us = clock.now_us();
    preempted_ns = 50'000'000;
    EXPECT_EQ(clock.now_us(), before_us) << "as of when it was asked";
    EXPECT_EQ(clock.now_us() - before_us, 50'000);
}

TEST(LocalClock, of_this_machine_runs_as_fast_as_others) {
    const auto steady_us = [] {
        return std::chrono::duration_cast<std::chrono::microseconds>(
                   std::chrono::steady_clock::now().time_since_epoch())
            .count();
    };
    const std::int64_t first_us = steady_us(), before_us = local_now_us(), second_us = steady_us();
    while (steady_us() < second_us + 200'000) {
    }
    const std::int64_t passed_us = local_now_us() - before_us;
    const std::int64_t most_us = steady_us() - first_us;
    // A system slews by a tenth at most.
    EXPECT_GT(passed_us, 175'000);
    EXPECT_LT(passed_us, most_us + most_us / 8);
}

} // namespace
} // namespace seaway
