// SPDX-License-Identifier: Apache-2.0
// What must not be lost because there was no memory for it at that instant: somebody waits to be told. Not under a lock, nor on
// the thread of the network. Thread-safe.
#pragma once

#include <chrono>
#include <new>
#include <thread>

namespace seaway {

/// Calls `act` until it does not end with std::bad_alloc, every 10 ms, for a second. False: it never did otherwise.
template <class Act>
bool tried_for_a_second(const Act& act) {
    constexpr std::chrono::milliseconds pause(10);
    constexpr int tries = 100;
    for (int i = 0; i < tries; ++i) {
        try {
            act();
            return true;
        } catch (const std::bad_alloc&) {
            std::this_thread::sleep_for(pause);
        }
    }
    return false;
}

} // namespace seaway
