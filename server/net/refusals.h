// SPDX-License-Identifier: Apache-2.0
// What an error is called outside: the one place where kinds become wire codes and HTTP status.
// Pure functions; thread-safe.
#pragma once

#include <cstdint>

#include "base/result.h"
#include "protocol/messages.h"

namespace seaway::server {

/// Of a Refusal or of the protocol's own errors, which are wire codes already; all else is internal.
wire::ErrorCode wire_code(const Error& error);

/// 400, 404; 503 for what is busy and may be asked again, 500 for what is broken.
unsigned http_status(const Error& error);
/// When the same may be asked again; 0: never, or when another request of who asks is done. Of what the server as a whole is short of
/// that is not known: some of it is there after a second.
std::uint32_t retry_after_ms(const Error& error);
/// The same in whole seconds, never too few.
int retry_after_s(const Error& error);

} // namespace seaway::server
