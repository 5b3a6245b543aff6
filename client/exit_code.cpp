// SPDX-License-Identifier: Apache-2.0
#include "client/exit_code.h"

#include "base/messages.h"
#include "base/text_file.h"
#include "client/link/failure.h"

namespace seaway::client {

ExitCode exit_code(const Error& error, ExitCode otherwise) {
    if (error.is(OutputError::lost))
        return exit_output;
    switch (failure_of(error)) {
    case Failure::none:
        return otherwise;
    case Failure::bad_argument:
        return exit_usage;
    case Failure::refused:
    case Failure::not_held:
    case Failure::not_understood:
    case Failure::too_large:
    case Failure::for_good: // turned away: to come again changes nothing
        return exit_refused;
    case Failure::cannot_connect:
    case Failure::lost:
    case Failure::deadline:
        break;
    }
    return exit_lost;
}

int give_up(const char* program, const Error& error, ExitCode otherwise) {
    return complain(program, exit_code(error, otherwise), error.message);
}

} // namespace seaway::client
