// SPDX-License-Identifier: Apache-2.0
// How a connection ends: the server's last word, and the stream's.
#include <new>

#include <fmt/format.h>

#include "client/link/connection.h"
#include "client/link/failure.h"

namespace seaway::client {

namespace {

/// Who comes again meets the same. After other codes a line that flipped a bit may be all that was wrong.
bool stays_so(wire::ErrorCode code) {
    return code == wire::ErrorCode::unsupported_version || code == wire::ErrorCode::unauthorised ||
           code == wire::ErrorCode::dropped;
}

} // namespace

Result<void> Connection::take(const wire::GoAway& go_away) {
    SEAWAY_TRY(protocol::check(go_away));
    const auto* why = go_away.message();
    going_away_ =
        failed(stays_so(go_away.code()) ? Failure::for_good : Failure::lost,
               fmt::format("the server ends the session ({}): {}", protocol::name(go_away.code()),
                           why ? why->string_view() : ""));
    going_away_->retry_after_ms = go_away.retry_after_ms();
    return {};
}

void Connection::on_closed(const std::string& reason) {
    bool was_open = false;
    try {
        end_with(going_away_.value_or(failed(Failure::lost, reason)), was_open);
    } catch (const std::bad_alloc&) { // maybe why it ends
        // In so few words that they need no memory; what was told of it is not told again.
        Error why = failed(going_away_ ? failure_of(*going_away_) : Failure::lost, "no memory");
        if (going_away_)
            why.retry_after_ms = going_away_->retry_after_ms;
        end_with(why, was_open);
    }
}

void Connection::end_with(const Error& why, bool& was_open) {
    {
        const std::scoped_lock lock(opening_mutex_);
        was_open = open_.exchange(false) || was_open;
        end_ = why;
        opening_.notify_all();
    }
    if (was_open && events_.on_closed)
        events_.on_closed(why);
    was_open = false;
    requests_.fail_all(told(why, Failure::lost)); // who waits for one finds the reason known
}

} // namespace seaway::client
