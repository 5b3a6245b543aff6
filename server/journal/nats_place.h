// SPDX-License-Identifier: Apache-2.0
// Where a world's log stands in NATS, and what is needed to be let in. Secrets are in files, never in the URL, and no message
// of ours holds one.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace seaway::server {

struct NatsPlace {
    std::vector<std::string> servers; ///< "nats://HOST:PORT"; of a cluster more than one
    std::string world;                ///< letters, digits, - and _

    std::string ca_file;             ///< TLS, and who signs the servers' certificates
    std::string cert_file, key_file; ///< this server's own, for TLS
    /// NATS credentials (.creds), or one line: "USER:PASSWORD", or a token.
    std::string credentials_file;
    int replicas = 1; ///< of a stream that is made, in a cluster

    /// "nats://HOST:PORT,HOST:PORT/WORLD".
    std::string name() const;
};

/// Longest name of a world.
inline constexpr std::size_t world_name_max = 64;
/// Servers of a cluster that can be named; it tells of the others itself.
inline constexpr std::size_t nats_servers_max = 16;

/// It is an address and no folder.
bool is_nats_url(std::string_view text);

/// nats://HOST[:PORT][,HOST[:PORT]...]/WORLD. An error says what is wrong, and that credentials do not belong there.
Result<NatsPlace> read_nats_url(const std::string& url);

} // namespace seaway::server
