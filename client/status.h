// SPDX-License-Identifier: Apache-2.0
// ClientStatus: how a client stands with its server, and what it can answer meanwhile.
#pragma once

#include <string>

#include "sea/basics/time.h"

namespace seaway::client {

enum class LinkState {
    /// And all that was subscribed to is, again; or some of it, and the reason says why the rest was refused or not answered in
    /// time, which is asked for again after waits.
    connected = 0,
    waiting = 1, ///< lost: for the time of the next attempt
    /// An attempt is under way, or what was subscribed to is not answered yet, or none of it is granted.
    connecting = 2,
    stopped = 3, ///< lost for good: the reason says why
};

struct ClientStatus {
    LinkState state = LinkState::connected;
    /// Why the last connection ended, the last attempt failed, what was held was dropped or a subscription was not had
    /// again, whichever was last; empty: none has.
    std::string reason;
    int attempts = 0;    ///< since the connection ended
    int connections = 0; ///< so far
    /// Different ones so far behind the address: from 1 on. With another one its time, epochs and waves are others. One whose time
    /// has gone back counts, too: a pause, or a slower pace, was not heard of while the line was away.
    int seas = 0;
    double next_attempt_s = 0; ///< waiting: until then; 0 also before it is known
    /// Since the server was heard last, or was sure of its sea; 0 while that is known to go on. Answers about later times are flagged
    /// answer_stale.
    double stale_s = 0;
    /// Sampling answers about now, and about every time, from waves.
    bool holds_waves = false;
    /// Keyframes of the sea of now, of all cascades that are subscribed to or else of all, are held that it can be sampled from: at
    /// every time between these, which are around now or else before it, if there are such.
    bool holds_tiles = false;
    sea::TimeUs held_from_us = 0;
    sea::TimeUs held_until_us = 0;
};

} // namespace seaway::client
