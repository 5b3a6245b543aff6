// SPDX-License-Identifier: Apache-2.0
// A change as text, and the chain of sums that ties each to all before it: what every journal writes. Pure; thread-safe.
//
// A message of a shared log is one change with its sum:
//     seaway-journal 1
//     epoch 2 start_us 1000000 end_us 61000000 by_utc_us 1700000000000000 sum 0123456789abcdef
//     ... the scene, or the pace, to the end
// The first one also says `epoch_utc_us` behind the sum.
#pragma once

#include <cstdint>
#include <string>

#include "base/result.h"
#include "server/journal/journal.h"

namespace seaway::server {

/// What was changed: a scene, or "pace FROM_US SEA_US PERMILLE", which no scene begins with.
std::string text_of(const SeaChange& change);
Result<SeaChange> with_text(SeaChange change, std::string text);

/// Of a change and of the sum of all before it.
std::uint64_t sum_of(std::uint64_t before, const SeaChange& change);
/// What the next change's sum is made of: also of whether the last one has lapsed. So who took another verdict on that cannot read on,
/// instead of making another sea.
std::uint64_t sum_with_verdict(std::uint64_t sum, bool lapsed);

/// An error where what has passed since that instant, sea time 0, is no time of a sea.
Result<void> check_epoch(std::int64_t epoch_utc_us);

/// Of the log before its first change.
std::uint64_t first_sum(std::int64_t epoch_utc_us);

/// An error where `next` cannot follow `last`, or holds what is no time of a sea: a sum tells damage, not who wrote it.
Result<void> check_next(const SeaChange& last, const SeaChange& next);

struct LoggedChange {
    SeaChange change;
    std::int64_t by_utc_us = 0; ///< stored later it has lapsed; of no meaning for the first change
    std::uint64_t sum = 0;
    std::int64_t epoch_utc_us = 0; ///< of the first change
};

std::string message_of(const LoggedChange& logged);
/// Errors: it is no change, is cut off, or was written by another version.
Result<LoggedChange> read_message(const std::string& message);

} // namespace seaway::server
