// SPDX-License-Identifier: Apache-2.0
// A Page as the bytes of an HTTP/1.1 response, written to a socket. Beast's templates for that are compiled in
// http_response.cpp alone.
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>

#include "server/net/core.h"
#include "server/net/pages.h"
#include "sockets/socket.h"

namespace seaway::server {

using Written = std::function<void(sockets::error_code)>;

/// Counts the response and writes it. `head_only`: the header alone, with the length that the body has.
void write_page(Core& core, sockets::Socket& socket, const Page& page, bool head_only,
                bool keep_alive, Written done);

/// The header of a 200 whose body of so many bytes follows; the connection ends with it.
void write_map_header(Core& core, sockets::Socket& socket, std::uint64_t bytes, Written done);

/// A peer that goes away, or says nothing, between requests: none of our business.
bool is_usual_end(sockets::error_code error);

/// A peer whose handshake, request or response came to nothing: counted, and of each address a line of the log in ten seconds.
void note_bad_peer(Core& core, const Peer& peer, std::string_view what, std::string_view why);

} // namespace seaway::server
