// SPDX-License-Identifier: Apache-2.0
// What the calling thread has worked, whoever else had its processor meanwhile.
#pragma once

#include <ctime>

namespace seaway {

inline double thread_time_us() {
    timespec worked{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &worked);
    return 1e6 * static_cast<double>(worked.tv_sec) + 1e-3 * static_cast<double>(worked.tv_nsec);
}

} // namespace seaway
