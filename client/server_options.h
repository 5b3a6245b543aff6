// SPDX-License-Identifier: Apache-2.0
// Which server a program talks to, and how: options that all of them have.
#pragma once

#include <string>

#include "base/command_line.h"
#include "base/result.h"
#include "client/client.h"

namespace seaway::client {

struct ServerOptions {
    std::string url;
    std::string token_file; ///< empty: no token
    std::string ca_file;    ///< PEM, to be trusted besides the system's; empty: none
    double timeout_s = 0;   ///< patience with each request; a program has its own default

    /// --timeout, --token-file and --ca-file; the URL stands by place, as each program has it. `token`: whose it is.
    void describe(CommandLine& line, const std::string& token);
    /// URL and patience; and certificates are looked at with wss alone: who names some for ws is told so.
    Result<void> check() const;
    /// With the token read. `program`: what it tells the server of itself.
    Result<ConnectOptions> connect_options(const std::string& program) const;
};

/// Client::connect(), and Connection::open() of who needs no more, whose errors say so where a URL without TLS may be the reason.
Result<std::unique_ptr<Client>> connect_to(const ConnectOptions& options, ClientEvents events = {});
Result<std::unique_ptr<Connection>> connection_to(const ConnectOptions& options);

} // namespace seaway::client
