// SPDX-License-Identifier: Apache-2.0
// How the programs that talk to a server end.
#pragma once

#include "base/result.h"

namespace seaway::client {

/// Exit codes of all of them: the public contract.
enum ExitCode : int {
    exit_done = 0,
    exit_output = 1,    ///< what was asked for cannot be written, or no memory
    exit_usage = 2,     ///< command line or points that make no sense
    exit_no_device = 3, ///< `seaway-view`: no device or window can be had, or the device failed
    exit_lost = 5,      ///< cannot connect, connection lost, or no answer in time
    exit_refused = 6,   ///< the server refused, or does not offer what is needed
    exit_unsure = 7,    ///< `seaway-ctl status`: a server does not answer, or is stale
};

/// The code that says the same; `otherwise` of errors that are not of talking to a server.
ExitCode exit_code(const Error& error, ExitCode otherwise = exit_lost);

/// Says why, in one line, and returns that code.
int give_up(const char* program, const Error& error, ExitCode otherwise = exit_lost);

} // namespace seaway::client
