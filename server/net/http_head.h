// SPDX-License-Identifier: Apache-2.0
// What the head of an HTTP request says, read strictly (RFC 9110, RFC 9112): a request that another program
// on the way could understand otherwise, or that a foreign web page has sent, is refused with its
// reason. Values, no sockets; thread-safe.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "server/net/origins.h"
#include "server/net/pages.h"

namespace seaway::server {

/// As it came; of fields that may stand once every line.
struct HttpHead {
    unsigned version = 11;
    std::string_view method;
    std::string_view target;
    std::vector<std::string_view> hosts = {};
    std::vector<std::string_view> origins = {};
    std::vector<std::string_view> transfer_encodings = {};
    std::vector<std::string_view> authorizations = {};
    std::string_view fetch_site = {}; ///< Sec-Fetch-Site, -Mode and -Dest (W3C Fetch Metadata)
    std::string_view fetch_mode = {};
    std::string_view fetch_dest = {};
};

/// What is asked for.
struct Asked {
    std::string path; ///< percent-decoded
    std::map<std::string, std::string> parameters;
    std::string token; ///< of "Authorization: Bearer"; empty: none
};

/// A refusal with its name in the log and in seaway_net_sessions_refused_total.
struct Refused {
    std::string reason;
    Page page;
};

/// `loopback`: from this machine, where the name in Host gives DNS rebinding away.
std::variant<Asked, Refused> read_head(const HttpHead& head, const Origins& origins, bool loopback,
                                       bool tls);

/// The list of a Sec-WebSocket-Protocol field holds this name, in this case (RFC 7936, section 2).
bool offers(std::string_view list, std::string_view subprotocol);

/// 16 bytes in base64, as Sec-WebSocket-Key has to be (RFC 6455, 4.1).
bool is_websocket_key(std::string_view value);

} // namespace seaway::server
