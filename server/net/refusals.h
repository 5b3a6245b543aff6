// SPDX-License-Identifier: Apache-2.0
// What an error is called outside: the one place where kinds become wire codes and HTTP status.
// Pure functions; thread-safe.
#pragma once

#include "base/result.h"
#include "protocol/messages.h"

namespace seaway::server {

/// Of a Refusal or of the protocol's own errors, which are wire codes already; all else is internal.
wire::ErrorCode wire_code(const Error& error);

/// 400, 404; 503 for what is busy and may be asked again, 500 for what is broken.
unsigned http_status(const Error& error);
/// Seconds until the same may be asked again; 0: never, or nobody knows.
int retry_after_s(const Error& error);

} // namespace seaway::server
