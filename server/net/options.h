// SPDX-License-Identifier: Apache-2.0
// Options of the net: where to listen, who may come in, how long to wait. A plain value.
#pragma once

#include <chrono>
#include <string>
#include <vector>

namespace seaway::server {

struct NetOptions {
    /// ADDR:PORT, IPv6 as [ADDR]:PORT; port 0 takes a free one. Numbers only, no host names.
    std::string listen = "127.0.0.1:9430";

    /// ADDR:PORT of a listener of its own for /healthz, /readyz and /metrics, which the crowd at `listen` cannot
    /// fill: plain HTTP, no token asked for, so it belongs where only the operator gets. Empty: none.
    std::string health_listen;

    /// PEM files, both or neither; with them the port speaks TLS (1.2 and later) only.
    std::string tls_cert_file;
    std::string tls_key_file;
    bool has_tls() const { return !tls_cert_file.empty(); }

    /// Files whose first line a client has to bring, as Hello.token or, for pages and maps, as
    /// "Authorization: Bearer". No file: everybody may come in. The admin token also opens the door,
    /// and marks the session as an administrator's.
    std::string client_token_file;
    std::string admin_token_file;

    /// SCHEME://HOST[:PORT] of pages that may use the server beside its own (origins.h); their hosts
    /// are names under which it may be asked for on this machine.
    std::vector<std::string> allowed_origins;

    /// WebSocket sessions at a time. One more is told 503, unless one that has not said Hello, without
    /// a token, of an address that has more of them, can make room.
    int sessions_max = 1024;
    /// With those that speak HTTP. For one more that connection without a whole request is closed
    /// that has waited longest of those of the address with the most connections; where there is
    /// none, the new one.
    int connections_max = 1280;
    int health_connections_max = 32; ///< at `health_listen`

    // What one address may take (addresses.h). 0 is no limit, for a proxy in front, which is one address
    // for all who come through it. This machine's own addresses are as any other.

    /// For one more the longest silent one of the same address is closed, or else the new one.
    int connections_per_address = 320;
    /// Sessions that have not said Hello; the next upgrade without a token is told 429.
    int sessions_without_hello_per_address = 32;
    /// Tokens that were wrong, and after how long as many may be wrong again. Beyond that no token of
    /// this address is looked at.
    int wrong_tokens_per_address = 10;
    std::chrono::milliseconds wrong_tokens_refill{60'000};
    /// Of messages and requests; beyond it, two seconds' worth aside, they are read later. Five million points asked about
    /// are as many bytes.
    double request_bytes_per_s_per_address = 128.0 * 1024 * 1024;

    /// That send keyframes, the io thread among them (senders.h): more than one where many clients share a large machine.
    int io_threads = 1;

    std::chrono::milliseconds hello_deadline{2000};  ///< from the upgrade to the first message
    std::chrono::milliseconds http_deadline{10'000}; ///< for a whole request, and between requests
    /// A session that sends nothing, not even pongs, is dead. Pings go out at half of it.
    std::chrono::milliseconds idle_timeout{20'000};
    std::chrono::milliseconds write_timeout{10'000}; ///< one message, at most 512 KB
    /// Who reads a map more slowly than this, write_timeout all in all aside, is cut off.
    double map_bytes_per_s_min = 256 * 1024;
    /// Where no place is free for one more map, the reader who is furthest behind this rate, by more than
    /// `map_patience`, is cut off.
    double map_bytes_per_s_wanted = 4.0 * 1024 * 1024;
    std::chrono::milliseconds map_patience{1000};

    /// From stop() on: what has been asked for is still answered, at most so long.
    double drain_s = 0.5;
    std::chrono::milliseconds stop_deadline{1200}; ///< then, for GoAway and closing handshakes
    /// How long those whom it sends away then should stay away (GoAway.retry_after_ms); 0: as long as it takes
    /// that all of them do not come in one instant (core.h). At most limits::retry_after_ms_max.
    double retry_after_s = 0;
};

} // namespace seaway::server
