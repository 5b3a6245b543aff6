// SPDX-License-Identifier: Apache-2.0
// A crowd of sessions lived through by hand: joins, leaves, slow readers, cuts, bytes that are no message,
// subscriptions, fetches, questions, acknowledgements withheld, leaps of the clock and of the sea - all by
// lot from one seed, the same on every run. Sessions, outboxes, encoder and core are the server's; clock,
// connections, clients and sea are made here, so that a minute of a crowd takes some ten milliseconds.
//
//     const Outcome outcome = live_through(seed);
//     if (!outcome.broken.empty()) ...    // which promise, with what came before it
#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace seaway::tests::simulated {

struct Outcome {
    std::string broken;                        ///< empty: every promise was kept
    std::map<std::string, std::uint64_t> seen; ///< how often what happened
    std::uint64_t digest = 0;                  ///< of every byte that was sent, in order
};

/// After each step: what waits for a session, and for all, is bounded; credit is not exceeded; no
/// keyframe of a cascade comes after a newer one, and one that has begun is finished; sea states come
/// all and in order, or the session is closed; each request is answered once; nobody is ended by what
/// another one says; the counters say what has happened. At the end whoever is still there is told all
/// that it asked for and the newest keyframes, and everything is freed. Ended by itself; uses one more
/// thread, the encoder's. Turns off the log of the process.
Outcome live_through(std::uint64_t seed);

} // namespace seaway::tests::simulated
