// SPDX-License-Identifier: Apache-2.0
#include <csignal>
#include <cstdio>
#include <thread>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "server/stop_deadline.h"

namespace seaway::server {
namespace {

using namespace std::chrono_literals;

std::string say_so() {
    return "it hangs";
}

void block_signals() {
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGTERM);
    sigaddset(&set, SIGINT);
    pthread_sigmask(SIG_BLOCK, &set, nullptr);
}

[[noreturn]] void hang() {
    for (;;)
        std::this_thread::sleep_for(1h);
}

class StopDeadlineDeathTest : public testing::Test {
  protected:
    StopDeadlineDeathTest() { GTEST_FLAG_SET(death_test_style, "threadsafe"); }
};

TEST_F(StopDeadlineDeathTest, a_stop_that_hangs_ends_with_its_last_words) {
    EXPECT_EXIT(
        {
            StopDeadline deadline(300ms, 3, say_so);
            deadline.begins();
            hang();
        },
        testing::ExitedWithCode(3), "it hangs");
}

TEST_F(StopDeadlineDeathTest, a_start_that_hangs_hears_a_signal_that_nobody_takes) {
    for (const int signal : {SIGTERM, SIGINT})
        EXPECT_EXIT(
            {
                block_signals();
                StopDeadline deadline(300ms, 3, say_so);
                kill(getpid(), signal);
                hang();
            },
            testing::ExitedWithCode(3), "it hangs");
}

// A pipe that nobody reads, full: whoever writes to it waits for ever.
TEST_F(StopDeadlineDeathTest, it_ends_though_nobody_reads_what_it_says) {
    EXPECT_EXIT(
        {
            int ends[2];
            if (pipe(ends) == 0 && dup2(ends[1], STDERR_FILENO) >= 0) {
                fcntl(STDERR_FILENO, F_SETFL, O_NONBLOCK);
                while (write(STDERR_FILENO, "x", 1) == 1)
                    ;
                fcntl(STDERR_FILENO, F_SETFL, 0);
                StopDeadline deadline(300ms, 3, say_so);
                deadline.begins();
                hang();
            }
        },
        testing::ExitedWithCode(3), "");
}

TEST(StopDeadline, leaves_a_process_alone_that_is_not_stopped_or_stops_in_time) {
    {
        StopDeadline deadline(1ms, 3, say_so);
        std::this_thread::sleep_for(700ms); // some looks at the clock
    }
    StopDeadline deadline(1h, 3, say_so);
    deadline.begins();
}

} // namespace
} // namespace seaway::server
