// SPDX-License-Identifier: Apache-2.0
// Timer: time stamps by the device's own clock, around whatever is recorded between them.
#pragma once

#include <cstdint>
#include <vector>

#include "base/result.h"
#include "gpu/commands.h"
#include "gpu/device.h"

namespace seaway::gpu {

/// From one stamp to a later one, of a clock that has so many bits, 1 .. 64, and goes round.
constexpr std::uint64_t ticks_between(std::uint64_t from, std::uint64_t to, std::uint32_t bits) {
    return (to - from) & (~std::uint64_t{0} >> (64 - bits));
}

class Timer {
  public:
    Timer() = default;
    /// Room for `stamps` time stamps. On a device without time stamps all times read 0.
    static Result<Timer> create(Device& device, std::uint32_t stamps);

    /// First thing in a recording that stamps.
    void reset(Commands& commands);
    /// The moment when all recorded before has finished; at most `stamps` of them a recording.
    void stamp(Commands& commands);
    /// Seconds between neighbouring stamps: one fewer than there were. The recording must have
    /// finished.
    Result<std::vector<double>> read(Device& device) const;

  private:
    OwnedQueryPool pool_;
    std::uint32_t capacity_ = 0;
    std::uint32_t used_ = 0;
    std::uint32_t bits_ = 64;
    double tick_s_ = 0;
};

} // namespace seaway::gpu
