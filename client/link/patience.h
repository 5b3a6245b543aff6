// SPDX-License-Identifier: Apache-2.0
// Patience: for how long a call that waits goes on asking. A server that has no time or room for a request now says for how long
// (Refused.retry_after_ms, docs/protocol.md), and whoever has more patience than that rests and asks again. A value.
#pragma once

#include <chrono>
#include <optional>

#include "client/link/failure.h"
#include "client/link/reconnect.h"

namespace seaway::client {

class Patience {
  public:
    using Clock = std::chrono::steady_clock;

    explicit Patience(double timeout_s) : until_(Clock::now() + ticks(timeout_s)) {}

    /// For the next request.
    double left_s() const { return std::chrono::duration<double>(until_ - Clock::now()).count(); }
    /// When to ask again after this: up to twice as late as was said, by lot, as others were told the same. Nothing: there
    /// would be no time for an answer, or it will not be granted then either.
    std::optional<Clock::time_point> again(const Error& why) const {
        if (!why.is(Failure::refused) || why.retry_after_ms == 0)
            return std::nullopt;
        const Clock::time_point now = Clock::now();
        const Clock::time_point least = now + std::chrono::milliseconds(why.retry_after_ms);
        if (!lasts_beyond(least))
            return std::nullopt;
        const Clock::time_point by_lot = now + ticks(ReconnectPauses().next(why).count());
        return lasts_beyond(by_lot) ? by_lot : least;
    }
    /// Is there time for an answer after that?
    bool lasts_beyond(Clock::time_point at) const { return at + answer_takes < until_; }

  private:
    static constexpr std::chrono::milliseconds answer_takes{200};
    static Clock::duration ticks(double s) {
        return std::chrono::ceil<Clock::duration>(std::chrono::duration<double>(s));
    }
    Clock::time_point until_;
};

} // namespace seaway::client
