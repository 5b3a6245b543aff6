// SPDX-License-Identifier: Apache-2.0
// SharedLog: what a messaging engine does for a journal that several servers follow: messages in order, numbered 1, 2, 3 ...,
// each kept durably once it was acknowledged. One engine is behind it (nats_log.h); in a test a network of lots.
//
// Each call asks the engine and waits for a bounded time. For one thread at a time, but for connect_no_more().
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"

namespace seaway::server {

/// Kinds of errors; without one: the engine has said no for good, the message says why.
enum class LogFailure {
    unreachable, ///< nothing has come to the engine
    unanswered,  ///< something may have
    /// The log does not end where it was expected to. Said of a repeat, too, where the first attempt came meanwhile: read() has
    /// the id of what stands there.
    outrun,
};

class SharedLog {
  public:
    virtual ~SharedLog() = default;

    struct Tail {
        std::uint64_t last = 0; ///< number of the last message; 0: there is none
        /// Of this log and no other: one that was removed and made anew has another.
        std::string identity;
        /// When the last message was given its number: of two logs of one length, as after a loss, it is another.
        std::int64_t last_at_utc_us = 0;
        /// For how long whoever says this has not been sure that nobody else orders the log by now.
        std::int64_t unsure_us = 0;
    };
    /// Where it ends, by who orders it.
    virtual Result<Tail> tail() = 0;

    struct Stored {
        std::string message;
        std::int64_t at_utc_us = 0; ///< when it was given its number, by the engine's clock
        std::string id;             ///< that it was written under
    };
    /// The messages `first` to `last`, which are there, in one go.
    virtual Result<std::vector<Stored>> read(std::uint64_t first, std::uint64_t last) = 0;

    /// Appends if the log ends at `expected_last`, once for each `id` however often it is asked. The number it has.
    virtual Result<std::uint64_t> write(const std::string& message, const std::string& id,
                                        std::uint64_t expected_last) = 0;

    /// From now on only over the connection that there is: a call ends within some 2 s, also one under way. Any thread.
    virtual void connect_no_more() = 0;
};

} // namespace seaway::server
