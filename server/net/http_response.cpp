// SPDX-License-Identifier: Apache-2.0
#include "server/net/http_response.h"
#include "server/net/status_page.h"

#include <memory>
#include <string>
#include <utility>

#include <boost/asio/error.hpp>
#include <boost/beast/core/error.hpp>
#include <boost/beast/http.hpp>
#include <fmt/format.h>

#include "base/messages.h"
#include "server/net/tokens.h"

namespace seaway::server {

namespace http = boost::beast::http;
using sockets::error_code;

namespace {

template <class Body>
void begin(http::response<Body>& response, unsigned status, const std::string& type,
           bool keep_alive) {
    response.result(status);
    response.version(11);
    response.set(http::field::server, "seaway/" SEAWAY_VERSION);
    response.set(http::field::content_type, type);
    response.set(http::field::cache_control, "no-store");
    response.set("X-Content-Type-Options", "nosniff");
    response.set("Content-Security-Policy", std::string(status_policy));
    response.keep_alive(keep_alive);
}

/// The serializer of a whole message would wait for the body that the length announces. The header is moved: a copy of Beast's for
/// which there is no memory halfway loses what it has.
void write_header(sockets::Socket& socket, http::response_header<>&& fields, Written done) {
    const auto header = std::make_shared<http::response<http::empty_body>>(std::move(fields));
    const auto serializer = std::make_shared<http::response_serializer<http::empty_body>>(*header);
    http::async_write_header(socket, *serializer,
                             [header, serializer, done = std::move(done)](
                                 error_code error, std::size_t) { done(error); });
}

} // namespace

void write_page(Core& core, sockets::Socket& socket, const Page& page, bool head_only,
                bool keep_alive, Written done) {
    const auto response = std::make_shared<http::response<http::string_body>>();
    begin(*response, page.status, page.content_type, keep_alive);
    if (!page.allow.empty())
        response->set(http::field::allow, page.allow);
    if (page.retry_after_s > 0)
        response->set(http::field::retry_after, std::to_string(page.retry_after_s));
    if (page.status == 401)
        response->set(http::field::www_authenticate, "Bearer");
    if (page.status == 426)
        response->set(http::field::upgrade, "websocket");
    ++core.counters.http_responses[page.status];
    socket.expires_after(core.options.http_deadline);
    response->content_length(page.announced_bytes.value_or(page.body.size()));
    if (head_only)
        return write_header(socket, std::move(response->base()), std::move(done));
    response->body() = page.body;
    http::async_write(
        socket, *response,
        [response, done = std::move(done)](error_code error, std::size_t) { done(error); });
}

void write_map_header(Core& core, sockets::Socket& socket, std::uint64_t bytes, Written done) {
    http::response<http::empty_body> response;
    begin(response, 200, std::string(map_content_type), false);
    response.content_length(bytes);
    ++core.counters.http_responses[200];
    write_header(socket, std::move(response.base()), std::move(done));
}

bool is_usual_end(error_code error) {
    return error == boost::beast::error::timeout || error == boost::asio::error::eof ||
           error == boost::asio::error::connection_reset ||
           error == boost::asio::error::operation_aborted;
}

void note_bad_peer(Core& core, const Peer& peer, std::string_view what, std::string_view why) {
    ++core.counters.handshakes_failed;
    if (const std::uint64_t count =
            peer.address->turn_away(Crowding::not_understood, Bucket::Clock::now()))
        core.log(fmt::format("event=connection_refused peer={} reason=bad_{} count={} why={}",
                             peer.name, what, count, in_quotes(printable(why))));
}

} // namespace seaway::server
