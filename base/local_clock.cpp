// SPDX-License-Identifier: Apache-2.0
#include "base/local_clock.h"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <limits>

namespace seaway {
namespace {

std::int64_t steady_ns() {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

template <clockid_t clock>
std::int64_t system_ns() {
    timespec now{};
    clock_gettime(clock, &now);
    return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

/// A sandbox may know fewer clocks than its system's headers.
LocalClock::Clocks clocks_of_system() {
#if defined(CLOCK_MONOTONIC_RAW) && defined(CLOCK_BOOTTIME)
    timespec unused{};
    if (clock_gettime(CLOCK_MONOTONIC_RAW, &unused) == 0 &&
        clock_gettime(CLOCK_BOOTTIME, &unused) == 0)
        return {system_ns<CLOCK_MONOTONIC_RAW>, system_ns<CLOCK_MONOTONIC>,
                system_ns<CLOCK_BOOTTIME>};
#endif
    return {steady_ns, steady_ns, steady_ns};
}

/// Between the looks at two clocks less passes, but where the system takes this thread's processor.
constexpr std::int64_t sleep_ns_min = 10'000'000;

} // namespace

LocalClock::LocalClock(const Clocks& clocks) : clocks_(clocks), slept_(measured_sleep()) {}

std::int64_t LocalClock::measured_sleep() const {
    std::int64_t least = std::numeric_limits<std::int64_t>::max();
    for (int i = 0; i < 5; ++i) { // who loses its processor in the middle finds too much
        const std::int64_t before = clocks_.bent();
        least = std::min(least, clocks_.bent_with_sleep() - before);
    }
    return std::max<std::int64_t>(least, 0);
}

std::int64_t LocalClock::now_us() {
    const std::int64_t oscillator = clocks_.oscillator(), before = clocks_.bent();
    std::int64_t slept = slept_.load();
    if (clocks_.bent_with_sleep() - before > slept + sleep_ns_min) {
        const std::int64_t now = measured_sleep();
        while (now > slept + sleep_ns_min && !slept_.compare_exchange_weak(slept, now)) {
        }
        slept = std::max(slept, slept_.load());
    }
    return (oscillator + slept) / 1000;
}

std::int64_t local_now_us() {
    static LocalClock clock(clocks_of_system());
    return clock.now_us();
}

} // namespace seaway
