// SPDX-License-Identifier: Apache-2.0
// Endpoint: an address to listen at, as a command line says it. A value.
#pragma once

#include <string>

#include "base/result.h"

namespace seaway::server {

struct Endpoint {
    std::string ip;
    int port = 0;
    bool is_v6 = false;

    /// "127.0.0.1:9430", "[::1]:9430".
    std::string text() const;
};

/// ADDR:PORT, IPv6 as [ADDR]:PORT; numbers only. `flag` is named by the error.
Result<Endpoint> read_endpoint(const std::string& flag, const std::string& text);

/// An error where this machine has no such address; whether the port is free is not asked.
Result<void> check_address(const std::string& flag, const Endpoint& endpoint);

/// Would one be in the other's way?
bool meet(const Endpoint& a, const Endpoint& b);

/// Why nothing can be listened for there, and what to do.
Error cannot_listen(const std::string& flag, const Endpoint& endpoint, int error,
                    const std::string& message);

} // namespace seaway::server
