// SPDX-License-Identifier: Apache-2.0
// Options of the net: where to listen, who may come in, how long to wait. A plain value.
#pragma once

#include <chrono>
#include <string>

namespace seaway::server {

struct NetOptions {
    /// ADDR:PORT, IPv6 as [ADDR]:PORT; port 0 takes a free one. Numbers only, no host names.
    std::string listen = "127.0.0.1:9430";

    /// PEM files, both or neither; with them the port speaks TLS (1.2 and later) only.
    std::string tls_cert_file;
    std::string tls_key_file;

    /// Files whose first line a client has to bring, as Hello.token or, for pages and maps, as
    /// "Authorization: Bearer". No file: everybody may come in. The admin token also opens the door,
    /// and marks the session as an administrator's.
    std::string client_token_file;
    std::string admin_token_file;

    int sessions_max = 1024; ///< WebSocket sessions at a time; one more is told 503
    /// With those that speak HTTP. For one more the connection is closed that has waited longest
    /// without a whole request; where there is none, the new one.
    int connections_max = 1280;

    std::chrono::milliseconds hello_deadline{2000};  ///< from the upgrade to the first message
    std::chrono::milliseconds http_deadline{10'000}; ///< for a whole request, and between requests
    /// A session that sends nothing, not even pongs, is dead. Pings go out at half of it.
    std::chrono::milliseconds idle_timeout{20'000};
    std::chrono::milliseconds write_timeout{10'000}; ///< one message, at most 512 KB
    /// Who reads a map more slowly than this, write_timeout all in all aside, is cut off: maps_at_once_max
    /// others wait for its place.
    double map_bytes_per_s_min = 256 * 1024;
    std::chrono::milliseconds stop_deadline{1500}; ///< for GoAway and closing handshakes
};

} // namespace seaway::server
