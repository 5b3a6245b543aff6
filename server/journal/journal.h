// SPDX-License-Identifier: Apache-2.0
// Journal: the log that a sea is a function of. It holds the instant at which sea time is 0, and every change of
// the sea in order. Whoever has the same log has the same sea at the same time: a server that was restarted, and
// any number of servers that follow one log.
//
// Others may append to it, too: of two that take the same number one is told so. Behind it stands a file of this machine
// (sqlite_journal.h) or a log that several servers follow (shared_journal.h); open_journal() tells them apart, and nobody
// else.
//
// A change is durable before it is announced: append() returns when it would outlive a loss of power. Thread-safe.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "sea/basics/pace.h"
#include "server/journal/peer_clocks.h"

namespace seaway::server {

/// From which moment on which sea runs, or how fast.
struct SeaChange {
    std::uint32_t epoch = 1; ///< its number: 1, 2, 3 ... without a gap
    sea::TimeUs start_us =
        0; ///< sea time at which the sea before begins to go; takes over from what was to come
    sea::TimeUs end_us = 0; ///< and at which this one is there; behind start_us, but for the first
    std::string scene;      ///< effective scene (sea::to_toml)
    /// How fast the sea runs from a moment on; then there is no scene, and no start and end.
    std::optional<sea::Pace> pace = {};
    /// It came to the log too late for all to hear of it in time: it keeps its number and changes nothing.
    bool lapsed = false;

    bool operator==(const SeaChange&) const = default;
};

/// What a log begins with.
struct Beginning {
    std::int64_t epoch_utc_us; ///< instant of sea time 0
    std::string scene;
};

/// Kinds of append()'s errors.
enum class JournalError {
    lapsed, ///< it was written, but so late that it changes nothing: to be asked for again
    /// This server's clock is behind: the log's, so that what was written at once has lapsed as well, or what it was when the last
    /// change was made, so that nothing is written.
    clock_behind,
    outrun, ///< another change has this number: nothing of this one is kept; since() has the other one
    unreachable, ///< the log cannot be asked: nothing of it is kept
    unknown,     ///< it was asked and has not said: since() has the change later, or never
};

/// How sure it is that it holds all that has happened.
struct JournalStanding {
    std::uint32_t last_epoch = 0; ///< that it holds
    /// For how long it has not been known that the log ends there; 0 where nobody else can write it.
    std::int64_t unheard_us = 0;
    /// It holds whatever was made longer ago than spread_us().
    bool current = true;
    bool settles = false; ///< not current yet, and about to be: who answers is sure again
    bool compares =
        false;       ///< it has just begun to compare clocks, and not two others have answered yet
    PeersSeen peers; ///< how far this server's clock is from those of others with the same log
    /// When the last change was made, or a sea begun (note_begun()), by the clock that compare_clocks() gave; 0: it does not say, or
    /// others append.
    std::int64_t made_utc_us = 0;
    std::string trouble; ///< what is wrong, one line; empty: nothing
};

class Journal {
  public:
    virtual ~Journal() = default;

    /// For messages: a file, or an address. Holds no secret.
    virtual const std::string& name() const = 0;

    /// The instant of sea time 0, microseconds since 1970-01-01T00:00:00Z.
    virtual std::int64_t epoch_utc_us() const = 0;

    /// The changes after that of `epoch`, oldest first, `most` of them; of 0: from the first one on, which there always is. To follow a
    /// log is to ask again. It does not wait for append().
    virtual Result<std::vector<SeaChange>> since(std::uint32_t epoch, std::size_t most) const = 0;
    Result<std::vector<SeaChange>> since(std::uint32_t epoch) const {
        return since(epoch, std::numeric_limits<std::uint32_t>::max());
    }

    /// Takes the next change. Errors: its number is not the next one, it ends before it begins, or it could not be written
    /// durably; then it has no effect, but where JournalError::unknown says that it may have.
    virtual Result<void> append(const SeaChange& change) = 0;

    /// Waits for nothing: neither for a disk nor for a network.
    virtual JournalStanding standing() const = 0;
    /// A server that is current has whatever was made longer ago than this: so no change may begin earlier. 0 where
    /// nobody else follows the log.
    virtual std::int64_t spread_us() const = 0;
    /// From now on this clock, the time since the sea's epoch, is compared with those of others who follow the log, standing().peers, and
    /// is what changes are told to be stored by; where nobody else appends it is what each change was made at, and none is taken
    /// before the last one was made, or the last sea begun.
    /// Empty: no more.
    virtual void compare_clocks(std::function<std::int64_t()> elapsed_us) = 0;
    /// A sea began so long after the epoch: where nobody else appends, no change is taken before that either, of a clock
    /// that is behind after a start. Durable, as append(). Else it says nothing.
    virtual Result<void> note_begun(std::int64_t elapsed_us) {
        (void)elapsed_us;
        return {};
    }
    /// The server stops: what waits for the log, and what is asked of it from now on, ends within some 2 s, with an error where nobody is
    /// connected to it. What is held stays.
    virtual void connect_no_more() = 0;
    /// Called from now on when others have appended, on a thread of its own that must not be held; empty: nobody.
    virtual void call_on_change(std::function<void()> call) = 0;
};

} // namespace seaway::server
