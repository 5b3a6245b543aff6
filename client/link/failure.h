// SPDX-License-Identifier: Apache-2.0
// Kinds of failure of the client: `Error::kind` of every error that this room returns, so that a
// program can act on it; the message is for people.
#pragma once

#include <string>
#include <utility>

#include "base/result.h"

namespace seaway::client {

enum class Failure : int {
    none = 0,
    bad_argument = 1,   ///< what the caller gave: an URL, a count, a value
    cannot_connect = 2, ///< no server there, or not one of ours, or it turned us away
    lost = 3,           ///< the connection ended
    refused = 4,        ///< the server refused this one request
    deadline = 5,       ///< no reply in time; the connection goes on
    not_held = 6,       ///< no keyframes around this time
    not_understood =
        9,           ///< the server is older than what was asked, and has answered something else
    too_large = 100, ///< the answer would be too large: within this room alone, which asks again
    for_good =
        101, ///< lost or not to be had, and coming again would meet the same: of Connection alone
};

inline Error failed(Failure failure, std::string message) {
    return {failure, std::move(message)};
}

inline Failure failure_of(const Error& error) {
    return error.kind.as<Failure>().value_or(Failure::none);
}

/// Of an error of a Connection the kind that programs are told.
inline Error told(Error error, Failure for_good) {
    if (error.is(Failure::for_good))
        error.kind = for_good;
    return error;
}

} // namespace seaway::client
