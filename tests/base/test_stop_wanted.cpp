// SPDX-License-Identifier: Apache-2.0
#include "base/stop_wanted.h"

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <thread>

#include <gtest/gtest.h>

namespace seaway {
namespace {

// Each in a process of its own.
TEST(StopWanted, is_noted_and_the_same_one_that_comes_twice_is_one) {
    EXPECT_EXIT(
        {
            note_stop_signals();
            const bool before = stop_wanted();
            std::raise(SIGTERM);
            std::raise(SIGTERM); // as `timeout` sends it
            std::exit(!before && stop_wanted() ? 7 : 8);
        },
        ::testing::ExitedWithCode(7), "");
}

TEST(StopWanted, of_somebody_who_will_not_wait_ends_the_program_at_once) {
    EXPECT_EXIT(
        {
            note_stop_signals();
            std::raise(SIGTERM);
            std::this_thread::sleep_for(std::chrono::milliseconds(1100));
            std::raise(SIGINT);
            std::exit(8);
        },
        ::testing::KilledBySignal(SIGINT), "");
}

TEST(StopWanted, ends_the_process_as_it_would_have) {
    EXPECT_EXIT(
        {
            note_stop_signals();
            std::raise(SIGINT);
            end_by_stop_signal();
        },
        ::testing::KilledBySignal(SIGINT), "");
}

} // namespace
} // namespace seaway
