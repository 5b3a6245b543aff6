// SPDX-License-Identifier: Apache-2.0
// Staleness: what the answers of a client are worth about times of which its server may know more.
//
// A server tells of a change before it begins: by the longest interval of its keyframes and change_told_ahead_us
// (docs/protocol.md, "Changes of the sea"). Whoever has heard nothing for longer knows of no change, and cannot know that there
// is none. What is added to error_m is derived for one assumption, which is all of it: that the sea changes at the first moment
// at which it may have, in the shortest time that a change takes, to waves of as much energy that have nothing to do with
// its own, which of a sea that fades are those of when it was heard of. Their difference has the variance 2 m0 s^2, s the share
// of the glide (sea/basics/glide.h); bound_sigmas standard deviations of that, and as much on the slopes for displacements.
// Displacements themselves stay within their reach in both seas: sqrt(2) s of it. Of a change to a higher sea neither is a bound.
//
// Pure; thread-safe.
#pragma once

#include <limits>

#include "client/link/connection.h"

namespace seaway::client {

inline constexpr sea::TimeUs change_told_ahead_us = 1'000'000;

/// A span of sea time of which a client may not have been told all: from what it heard last on.
struct Unheard {
    sea::TimeUs from_us = std::numeric_limits<sea::TimeUs>::max();
    sea::TimeUs until_us = std::numeric_limits<sea::TimeUs>::max();
    bool missed = false; ///< in the past, so that the server can still be asked what ran

    bool contains(sea::TimeUs time_us) const { return time_us > from_us && time_us < until_us; }
};

/// Up to when whoever heard that a server was sure of its sea at `heard_us` has been told of every change.
sea::TimeUs told_until_us(const SeaState& state, sea::TimeUs heard_us);

/// Where a client knows that the sea that it takes to run then does: where a server tells of each that comes, and of one before
/// up to where it was seen, since a sea that runs at a time has run ever since it began. Keyframes prove less: they reach beyond the
/// end of their sea.
struct KnownSea {
    sea::TimeUs told_from_us; ///< of all seas
    sea::TimeUs start_us;     ///< of this one
    sea::TimeUs seen_until_us = std::numeric_limits<sea::TimeUs>::min();

    bool was_seen(sea::TimeUs time_us) const {
        return time_us >= start_us && time_us <= seen_until_us;
    }
    bool has(sea::TimeUs time_us) const { return time_us >= told_from_us || was_seen(time_us); }
};

/// What is added to the error of a height about this time; never less at a later one. 0 up to the first moment at which
/// a change may have begun.
double stale_error_m(const SeaState& state, sea::TimeUs heard_us, sea::TimeUs time_us);
/// And to that of each component of a displacement, choppiness included.
double stale_displacement_error_m(const SeaState& state, sea::TimeUs heard_us, sea::TimeUs time_us);

} // namespace seaway::client
