// SPDX-License-Identifier: Apache-2.0
// LocalClock: how much time passes on this machine, for clocks that follow another one's (base/clock_filter.h) or UTC.
//
// It runs as the machine's oscillator does: nobody sets it, and what keeps the machine's date (chrony slews by percents) does not bend
// it, where the system has such a clock. It goes on while the machine sleeps, where the system says for how long. Elsewhere
// it is std::chrono::steady_clock.
//
// Thread-safe. Some tens of nanoseconds a look.
#pragma once

#include <atomic>
#include <cstdint>

namespace seaway {

class LocalClock {
  public:
    /// Nanoseconds of the system's clocks. `bent` stands while the machine sleeps; `bent_with_sleep` is the same and goes on.
    struct Clocks {
        std::int64_t (*oscillator)();
        std::int64_t (*bent)();
        std::int64_t (*bent_with_sleep)();
    };

    /// An oscillator is off by less, as a part of one.
    static constexpr double rate_off_max = 1e-4;

    explicit LocalClock(const Clocks& clocks);

    /// Microseconds since some moment, never less than before.
    std::int64_t now_us();

  private:
    std::int64_t measured_sleep() const;

    const Clocks clocks_;
    std::atomic<std::int64_t> slept_; ///< ns
};

/// That of this machine.
std::int64_t local_now_us();

} // namespace seaway
