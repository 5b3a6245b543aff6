// SPDX-License-Identifier: Apache-2.0
// Heartbeat: tells from outside whether a thread that works in turns comes on. A turn that does not end shows, sleep
// does not. Thread-safe.
#pragma once

#include <atomic>
#include <chrono>

namespace seaway::server {

class Heartbeat {
  public:
    using Clock = std::chrono::steady_clock;

    /// A new turn begins.
    void works() { since_ = Clock::now().time_since_epoch().count(); }
    /// It waits, for as long as it likes.
    void rests() { since_ = resting; }

    /// For how long the turn that is under way has lasted; nothing while it rests.
    Clock::duration turn() const {
        const Clock::rep since = since_;
        return since == resting ? Clock::duration(0)
                                : Clock::now().time_since_epoch() - Clock::duration(since);
    }

  private:
    static constexpr Clock::rep resting = -1;
    std::atomic<Clock::rep> since_ = resting;
};

} // namespace seaway::server
