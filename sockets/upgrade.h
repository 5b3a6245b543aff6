// SPDX-License-Identifier: Apache-2.0
// Upgrade: the HTTP request that asks for a WebSocket, as Beast has parsed it.
#pragma once

#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>

namespace seaway::sockets {

struct Upgrade {
    boost::beast::http::request<boost::beast::http::string_body> request;
};

} // namespace seaway::sockets
