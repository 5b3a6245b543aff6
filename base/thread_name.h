// SPDX-License-Identifier: Apache-2.0
// Names of threads, for `top -H`, perf and gdb.
#pragma once

#include <pthread.h>

namespace seaway {

/// This thread's name: 15 letters at most, "sea-" first, for a host's threads have names of their own.
inline void name_thread(const char* name) noexcept {
    (void)pthread_setname_np(pthread_self(), name); // a thread without a name works as well
}

} // namespace seaway
