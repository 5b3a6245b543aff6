// SPDX-License-Identifier: Apache-2.0
// Work that can wait, on threads that others share a processor with.
#pragma once

#include <thread>

namespace seaway {

/// Whoever else waits for this thread's processor goes first. Said between pieces of work of some tenths of a millisecond, where
/// no lock is held: who is woken then waits for a piece instead of for a slice of the system's, which is some milliseconds.
/// 0.2 us where nobody waits.
inline void stand_back() noexcept {
    std::this_thread::yield();
}

} // namespace seaway
