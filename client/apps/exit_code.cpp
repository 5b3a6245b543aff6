// SPDX-License-Identifier: Apache-2.0
#include "client/apps/exit_code.h"

#include <string_view>

#include <fmt/format.h>

#include "base/messages.h"
#include "base/text_file.h"
#include "client/link/failure.h"
#include "protocol/token_file.h"

namespace seaway::client {

int exit_code(const char* program, const Error& error) {
    complain(program, 0, error.message);
    if (error.is(OutputError::lost))
        return exit_output;
    switch (failure_of(error)) {
    case Failure::bad_argument:
        return exit_usage;
    case Failure::refused:
    case Failure::not_held:
    case Failure::not_understood:
    case Failure::too_large:
    case Failure::for_good: // turned away: to come again changes nothing
        return exit_refused;
    case Failure::none: // not of this room
    case Failure::cannot_connect:
    case Failure::lost:
    case Failure::deadline:
        break;
    }
    return exit_lost;
}

Error not_connected(const std::string& url, Error why) {
    constexpr std::string_view plain = "ws://";
    const bool spoke_otherwise = why.message.find("no WebSocket server") != std::string::npos;
    if (failure_of(why) == Failure::cannot_connect && url.starts_with(plain) && spoke_otherwise)
        why.message += "; if it speaks TLS it is wss://" + url.substr(plain.size());
    return why;
}

Result<void> check_ca_file(const std::string& url, const std::string& ca_file) {
    if (ca_file.empty() || !url.starts_with("ws://"))
        return {};
    return Error{fmt::format("--ca-file: {} is no wss, no certificate is looked at", url)};
}

Result<std::string> read_token(const std::string& path) {
    Result<std::string> token = path.empty() ? std::string() : protocol::read_token_file(path);
    return token ? token : failed(Failure::bad_argument, token.error().message);
}

} // namespace seaway::client
