// SPDX-License-Identifier: Apache-2.0
// SIGINT and SIGTERM as a wish to stop: the first one is noted, for who looks between two pieces of work; a later one
// ends the program at once. One that comes in the same second is the same: `timeout` and others send it to a process and
// to its group, so that it comes twice.
//
// Of the process; thread-safe.
#pragma once

#include <atomic>

namespace seaway {

/// From now on. Whoever is killed at once is so as if nothing had been noted.
void note_stop_signals();

/// Has one come?
const std::atomic<bool>& stop_wanted();
/// Ends the process as the one that came would have: who called is told that it was one.
[[noreturn]] void end_by_stop_signal();

} // namespace seaway
