// SPDX-License-Identifier: Apache-2.0
// The local clock where a machine has slept: a time namespace (Linux) whose clock of that has been moved on.
#include <chrono>
#include <cstdio>
#include <fstream>

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/local_clock.h"

namespace seaway {
namespace {

std::int64_t beyond_steady_us() {
    const std::int64_t local_us = local_now_us();
    return local_us - std::chrono::duration_cast<std::chrono::microseconds>(
                          std::chrono::steady_clock::now().time_since_epoch())
                          .count();
}

enum Seen { counts_not = 1, no_such_place = 2, counts = 3 };

Seen seen_by(pid_t child) {
    int status = 0;
    return child > 0 && waitpid(child, &status, 0) == child && WIFEXITED(status)
               ? static_cast<Seen>(WEXITSTATUS(status))
               : counts_not;
}

/// In a child of a process that has moved on the clock of its children.
Seen in_a_machine_that_slept_for(int seconds) {
    const std::int64_t before_us = beyond_steady_us();
    const pid_t outer = fork();
    if (outer == 0) {
        if (unshare(CLONE_NEWTIME) != 0 && unshare(CLONE_NEWUSER | CLONE_NEWTIME) != 0)
            _exit(no_such_place);
        std::ofstream offsets("/proc/self/timens_offsets");
        offsets << "boottime " << seconds << " 0" << std::flush;
        if (!offsets)
            _exit(no_such_place);
        const pid_t inner = fork();
        if (inner == 0) {
            const std::int64_t slept_us = beyond_steady_us() - before_us;
            _exit(std::abs(slept_us - std::int64_t{seconds} * 1'000'000) < 30'000'000 ? counts
                                                                                      : counts_not);
        }
        _exit(seen_by(inner));
    }
    return seen_by(outer);
}

TEST(LocalClock, counts_what_the_machine_slept) {
    const Seen seen = in_a_machine_that_slept_for(300);
    if (seen == no_such_place) // this machine gives nobody a clock of his own
        EXPECT_GE(beyond_steady_us(), -1'000'000);
    else
        EXPECT_EQ(seen, counts);
}

} // namespace
} // namespace seaway
