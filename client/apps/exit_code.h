// SPDX-License-Identifier: Apache-2.0
// What seaway-query and seaway-ctl have in common: their token file and how they end.
#pragma once

#include <string>

#include "base/result.h"

namespace seaway::client {

/// Exit codes of both: the public contract.
enum ExitCode : int {
    exit_done = 0,
    exit_output = 1,  ///< standard output cannot be written, or no memory
    exit_usage = 2,   ///< command line or points that make no sense
    exit_lost = 5,    ///< cannot connect, connection lost, or no answer in time
    exit_refused = 6, ///< the server refused the request
    exit_unsure = 7,  ///< `seaway-ctl status`: a server does not answer, or is stale
};

/// Says why, in one line; the exit code that says the same.
int exit_code(const char* program, const Error& error);

/// An error of connecting, which a URL without TLS may be the reason of: then it says so.
Error not_connected(const std::string& url, Error why);

/// Certificates are looked at with wss alone: who names some for ws is told so.
Result<void> check_ca_file(const std::string& url, const std::string& ca_file);

/// Empty path: no token. An error is Failure::bad_argument.
Result<std::string> read_token(const std::string& path);

} // namespace seaway::client
