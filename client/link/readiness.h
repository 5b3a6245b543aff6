// SPDX-License-Identifier: Apache-2.0
// Readiness: one descriptor that is readable when there is something to do for who has no thread: what has come, what is due, what
// is to be sent. What is due is so every 50 ms, as often as a stream ticks.
//
// Thread-safe.
#pragma once

#include <memory>

#include "base/result.h"

namespace seaway::client {

class Readiness {
  public:
    /// An error: the system gives no more descriptors.
    static Result<std::unique_ptr<Readiness>> create();
    ~Readiness();
    Readiness(const Readiness&) = delete;
    Readiness& operator=(const Readiness&) = delete;

    int descriptor() const { return both_; }
    /// Also while this one is readable; until it is closed. One that is there already stays.
    Result<void> add(int descriptor);
    /// There is something to do now.
    void wake();
    /// It is being done: until it is due again.
    void clear();

  private:
    Readiness(int both, int due) : both_(both), due_(due) {}

    const int both_; ///< epoll
    const int due_;  ///< timer
};

} // namespace seaway::client
