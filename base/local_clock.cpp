// SPDX-License-Identifier: Apache-2.0
#include "base/local_clock.h"

#include <chrono>
#include <ctime>

namespace seaway {

std::int64_t local_now_us() {
#ifdef CLOCK_BOOTTIME
    timespec now{};
    // A sandbox may know fewer clocks than its system's headers.
    if (clock_gettime(CLOCK_BOOTTIME, &now) == 0)
        return std::int64_t{now.tv_sec} * 1'000'000 + now.tv_nsec / 1000;
#endif
    return std::chrono::duration_cast<std::chrono::microseconds>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

} // namespace seaway
