// SPDX-License-Identifier: Apache-2.0
// ReconnectPauses: how long whoever owns a connection waits before it opens another one. A server that stops says how
// long to stay away: its clients come back after once to twice as long, by lot, so that a thousand of them do not come
// in one instant. Without such a word waits grow from half a second to sixteen, each up to half as long again. Not
// thread-safe.
#pragma once

#include <chrono>
#include <cstdint>
#include <random>

#include "base/result.h"

namespace seaway::client {

class ReconnectPauses {
  public:
    using seconds = std::chrono::duration<double>;

    static constexpr seconds wait_min{0.5}, wait_max{16};
    static constexpr double jitter = 0.5; ///< of a wait that nobody asked for
    static constexpr double hint_jitter = 1;

    explicit ReconnectPauses(std::uint64_t seed = std::random_device{}()) : random_(seed) {}

    /// Before the next attempt; `why` the connection ended or the attempt failed (Error::retry_after_ms). Never
    /// less than what was asked for.
    seconds next(const Error& why);

    /// A connection stood: waits begin anew.
    void connected() { wait_ = wait_min; }

  private:
    std::mt19937_64 random_;
    seconds wait_ = wait_min;
};

} // namespace seaway::client
