// SPDX-License-Identifier: Apache-2.0
// Journal: the log that a sea is a function of. It holds the instant at which sea time is 0, and every change of
// the sea in order. Whoever has the same log has the same sea at the same time: a server that was restarted, and
// any number of servers that follow one log.
//
// A change is durable before it is announced: append() returns when it would outlive a loss of power. Thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "sea/basics/pace.h"

namespace seaway::server {

/// From which moment on which sea runs, or how fast.
struct SeaChange {
    std::uint32_t epoch = 1; ///< its number: 1, 2, 3 ... without a gap
    sea::TimeUs start_us =
        0; ///< sea time at which the sea before begins to go; takes over from what was to come
    sea::TimeUs end_us = 0; ///< and at which this one is there; not before start_us
    std::string scene;      ///< effective scene (sea::to_toml)
    /// How fast the sea runs from a moment on; then there is no scene, and no start and end.
    std::optional<sea::Pace> pace = {};

    bool operator==(const SeaChange&) const = default;
};

class Journal {
  public:
    virtual ~Journal() = default;

    /// The instant of sea time 0, microseconds since 1970-01-01T00:00:00Z.
    virtual std::int64_t epoch_utc_us() const = 0;

    /// The changes after that of `epoch`, oldest first; of 0: all. There is always a first one. To follow a log is
    /// to ask again.
    virtual Result<std::vector<SeaChange>> since(std::uint32_t epoch) const = 0;

    /// Takes the next change. Errors: its number is not the next one, it ends before it begins, or it could not be written durably; then it has not been taken.
    virtual Result<void> append(const SeaChange& change) = 0;
};

} // namespace seaway::server
