// SPDX-License-Identifier: Apache-2.0
#include "base/stop_wanted.h"

#include <chrono>
#include <csignal>
#include <cstdlib>

namespace seaway {

namespace {

// Looked at in a signal handler: no locks.
std::atomic<bool> wanted = false;
std::atomic<int> came = 0;
std::atomic<std::int64_t> came_at_ms = 0;
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free &&
              std::atomic<std::int64_t>::is_always_lock_free);

constexpr std::int64_t same_ms = 1000;

/// clock_gettime, which handlers may call.
std::int64_t now_ms() {
    return std::chrono::duration_cast<std::chrono::milliseconds>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

void note(int number) {
    if (!wanted.exchange(true)) {
        came_at_ms = now_ms();
        came = number;
        return;
    }
    if (came == 0 || now_ms() - came_at_ms < same_ms)
        return;
    std::signal(number, SIG_DFL);
    std::raise(number);
}

} // namespace

void note_stop_signals() {
    for (const int number : {SIGINT, SIGTERM})
        std::signal(number, note);
}

const std::atomic<bool>& stop_wanted() {
    return wanted;
}

void end_by_stop_signal() {
    const int number = came != 0 ? came.load() : SIGTERM;
    std::signal(number, SIG_DFL);
    std::raise(number);
    std::abort(); // it is blocked
}

} // namespace seaway
