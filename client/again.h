// SPDX-License-Identifier: Apache-2.0
// Again: what a client is subscribed to, on its way to be so on a connection that has come back. Tiles and waves each for itself:
// neither waits for the other, and what is granted is not fetched anew because the other is not.
//
// For one thread at a time.
#pragma once

#include <algorithm>
#include <chrono>
#include <optional>

#include "client/link/kept.h"
#include "client/link/reconnect.h"
#include "client/link/waiter.h"
#include "client/subscriptions.h"

namespace seaway::client {

/// How a rung stands on this connection.
enum class RungState {
    unanswered, ///< since it was asked for first
    missed,     ///< refused or not answered in time, when it was asked for last
    granted,
    unwanted, ///< nothing is subscribed to
};

template <class Kind>
struct RungAgain {
    using Clock = std::chrono::steady_clock;

    RungState state = RungState::unanswered;
    std::optional<Error> why_missed; ///< last
    typename Kept<Kind>::One asked;
    int connection = 0;                                ///< its number
    std::optional<Waiter> answer;                      ///< while it is asked for
    Clock::time_point next = Clock::time_point::min(); ///< it is asked for then
    ReconnectPauses pauses{0};

    bool is_done() const { return state == RungState::granted || state == RungState::unwanted; }
    /// When there is something to do, if nothing comes before that.
    Clock::time_point due() const {
        if (answer)
            return answer->ready() ? Clock::time_point::min() : Clock::time_point::max();
        return is_done() ? Clock::time_point::max() : next;
    }
};

struct Again {
    RungAgain<Subscription> tiles;
    RungAgain<SpectrumSubscription> waves;

    /// `lots`: of this client, since others draw from theirs.
    explicit Again(ReconnectPauses lots) {
        lots.connected();
        tiles.pauses = lots;
        waves.pauses = lots;
    }

    bool is_done() const { return tiles.is_done() && waves.is_done(); }
    /// Of what is missed now, tiles first.
    const Error* why_missed() const {
        if (tiles.state == RungState::missed)
            return &*tiles.why_missed;
        return waves.state == RungState::missed ? &*waves.why_missed : nullptr;
    }
    /// Has anything been, and been told?
    bool has_missed() const { return tiles.why_missed || waves.why_missed; }
    std::chrono::steady_clock::time_point due() const { return std::min(tiles.due(), waves.due()); }
    /// What is missed keeps nobody from what is granted; but where nothing is, there is nothing to go on with.
    bool is_connected() const {
        const auto any = [this](RungState state) {
            return tiles.state == state || waves.state == state;
        };
        return !any(RungState::unanswered) && (is_done() || any(RungState::granted));
    }
};

} // namespace seaway::client
