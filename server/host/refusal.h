// SPDX-License-Identifier: Apache-2.0
// Why the server does not do what was asked: kinds of the errors that Simulation and Host hand over.
// server/net alone makes wire codes and HTTP status of them; the message says which value, limit or
// device it was.
#pragma once

#include <string>
#include <utility>

#include "base/result.h"

namespace seaway::server {

enum class Refusal {
    bad_value,   ///< out of range; the message names field, value and range
    not_offered, ///< this sea has none of what was asked for
    busy,        ///< too much waits already: to be asked again later
    gone,        ///< the device has failed for good, or the server stops
};

/// To be asked again in a second.
inline Error busy(std::string why) {
    Error error{Refusal::busy, std::move(why)};
    error.retry_after_ms = 1000;
    return error;
}
inline Error no_memory() {
    return busy("there is no memory for this now, try again later");
}

} // namespace seaway::server
