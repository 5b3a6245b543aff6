// SPDX-License-Identifier: Apache-2.0
// Address of a server: ws://host[:port][/path] or wss://... Pure; thread-safe.
#pragma once

#include <string>
#include <string_view>

#include "base/result.h"

namespace seaway::client {

struct Url {
    bool tls = false;
    std::string host;                ///< name or address; an IPv6 address without its brackets
    std::string port;                ///< decimal, 1 .. 65535
    std::string path = "/v1/stream"; ///< with the query, if any

    /// host[:port] as the HTTP Host header wants it.
    std::string authority() const;
};

/// Defaults: port 80 (ws) or 443 (wss), path /v1/stream. An error says what to write instead. A
/// user name, a password or a fragment is an error: a token does not belong into an address.
Result<Url> parse_url(std::string_view text);

} // namespace seaway::client
