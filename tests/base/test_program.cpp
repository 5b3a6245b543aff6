// SPDX-License-Identifier: Apache-2.0
// What a program is told by signals, and begins with.
#include "base/standard_files.h"
#include "base/stop_wanted.h"

#include <cerrno>
#include <chrono>
#include <csignal>
#include <string>
#include <thread>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include "tests/support/folder.h"

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
            _exit(!before && stop_wanted() ? 7 : 8);
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
            _exit(8);
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

// Naive: the next file that is opened is the log.
TEST(StandardFiles, that_are_closed_are_not_those_that_are_opened_next) {
    EXPECT_EXIT(
        {
            close(STDIN_FILENO);
            close(STDERR_FILENO);
            hold_standard_files();
            const int next = open("/dev/null", O_RDWR);
            char byte = 0;
            const bool fails =
                ::write(STDERR_FILENO, "x", 1) < 0 && ::read(STDIN_FILENO, &byte, 1) < 0;
            _exit(next > STDERR_FILENO && fails ? 7 : 8);
        },
        ::testing::ExitedWithCode(7), "");
}

// Naive: the system ends a program whose file grows beyond `ulimit -f`, sessions and all.
TEST(StandardFiles, a_limit_on_the_size_of_files_is_an_error_of_who_writes) {
    const std::string path = tests::folder().file("limited");
    EXPECT_EXIT(
        {
            hold_standard_files();
            rlimit limit{};
            limit.rlim_cur = limit.rlim_max = 10;
            setrlimit(RLIMIT_FSIZE, &limit);
            const int file = open(path.c_str(), O_RDWR | O_CREAT, 0600);
            const bool part = ::write(file, "0123456789abc", 13) == 10;
            const bool none = ::write(file, "abc", 3) < 0 && errno == EFBIG;
            _exit(part && none ? 7 : 8);
        },
        ::testing::ExitedWithCode(7), "");
}

} // namespace
} // namespace seaway
