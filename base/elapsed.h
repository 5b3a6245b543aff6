// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <ctime>

namespace seaway {

/// By the clock that is never set.
inline double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

namespace detail {
inline double seconds_of(clockid_t clock) {
    std::timespec now{};
    clock_gettime(clock, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}
} // namespace detail

/// That this thread has worked, by the processor's count: while others hold its processor it stands still.
inline double thread_cpu_seconds() {
    return detail::seconds_of(CLOCK_THREAD_CPUTIME_ID);
}

/// That all threads of this process have worked.
inline double process_cpu_seconds() {
    return detail::seconds_of(CLOCK_PROCESS_CPUTIME_ID);
}

} // namespace seaway
