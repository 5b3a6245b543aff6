// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <thread>

namespace seaway::server {

/// A busy machine takes as long as it takes: a minute at most.
inline bool comes(const std::atomic<bool>& condition) {
    for (int i = 0; i < 12'000 && !condition; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return condition;
}

} // namespace seaway::server
