// SPDX-License-Identifier: Apache-2.0
#include <optional>

#include <boost/asio/ssl/stream.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/ssl.hpp>
#include <boost/beast/websocket.hpp>
#include <fmt/format.h>

#include "server/net/connection.h"
#include "server/net/pages.h"
#include "server/net/tokens.h"

namespace seaway::server {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using beast::error_code;

using PlainStream = beast::tcp_stream;
using TlsStream = beast::ssl_stream<beast::tcp_stream>;

/// Of a request: an ordinary browser sends 1 KB. No page takes a body.
constexpr std::uint32_t header_bytes_max = 8 * 1024;
constexpr std::uint64_t body_bytes_max = 1024;

std::string_view text(beast::string_view view) {
    return {view.data(), view.size()};
}

template <class Stream>
class HttpConnection : public std::enable_shared_from_this<HttpConnection<Stream>> {
  public:
    HttpConnection(ConnectionSlot slot, Stream stream, std::string peer)
        : slot_(std::move(slot)), stream_(std::move(stream)), peer_(std::move(peer)) {}

    void run() {
        if constexpr (std::is_same_v<Stream, TlsStream>) {
            lowest().expires_after(core().options.http_deadline);
            stream_.async_handshake(asio::ssl::stream_base::server,
                                    [self = this->shared_from_this()](error_code error) {
                                        if (error)
                                            return self->failed("tls", error);
                                        self->read_request();
                                    });
        } else {
            read_request();
        }
    }

  private:
    using Parser = http::request_parser<http::string_body>;

    Core& core() { return *slot_.core(); }
    beast::tcp_stream& lowest() { return beast::get_lowest_layer(stream_); }

    void read_request() {
        parser_.emplace();
        parser_->header_limit(header_bytes_max);
        parser_->body_limit(body_bytes_max);
        lowest().expires_after(core().options.http_deadline);
        http::async_read(stream_, buffer_, *parser_,
                         [self = this->shared_from_this()](error_code error, std::size_t) {
                             self->on_request(error);
                         });
    }

    void on_request(error_code error) {
        if (error == http::error::end_of_stream)
            return close();
        if (error == http::error::header_limit)
            return respond_and_close({.status = 431, .body = "header too large\n"}, error);
        if (error == http::error::body_limit)
            return respond_and_close({.status = 413, .body = "body too large\n"}, error);
        if (error.category() == http::make_error_code(http::error::bad_method).category() &&
            error != http::error::partial_message)
            return respond_and_close({.status = 400, .body = "this is not HTTP\n"}, error);
        if (error)
            return failed("http", error);
        const auto& request = parser_->get();
        const std::string_view target = text(request.target());
        if (beast::websocket::is_upgrade(request) &&
            target.substr(0, target.find('?')) == protocol::stream_path)
            return upgrade();
        respond(page_for(core(), text(request.method_string()), target),
                request.method() == http::verb::head, request.keep_alive());
    }

    void upgrade() {
        const auto& request = parser_->get();
        http::token_list offered{request[http::field::sec_websocket_protocol]};
        const beast::string_view ours(protocol::websocket_subprotocol.data(),
                                      protocol::websocket_subprotocol.size());
        if (!offered.exists(ours))
            return respond({.status = 400,
                            .body = fmt::format("offer the subprotocol {}\n",
                                                protocol::websocket_subprotocol)},
                           false, false);
        if (buffer_.size() > 0)
            return respond({.status = 400, .body = "bytes before the upgrade was answered\n"},
                           false, false);
        if (core().sessions.size() >= static_cast<std::size_t>(core().options.sessions_max)) {
            ++core().counters.sessions_closed[std::string(
                protocol::name(wire::ErrorCode::server_full))];
            core().log(fmt::format("event=session_refused peer={} reason=server_full", peer_));
            return respond({.status = 503, .body = "too many sessions, try again later\n"}, false,
                           false);
        }
        lowest().expires_never();
        serve_stream(std::move(slot_), std::move(stream_), request, std::move(peer_));
    }

    void respond(const Page& page, bool head_only, bool keep_alive) {
        auto response = std::make_shared<http::response<http::string_body>>();
        response->result(page.status);
        response->version(11);
        response->set(http::field::server, "seaway/" SEAWAY_VERSION);
        response->set(http::field::content_type, page.content_type);
        response->set(http::field::cache_control, "no-store");
        response->set("X-Content-Type-Options", "nosniff");
        if (!page.allow.empty())
            response->set(http::field::allow, page.allow);
        if (page.status == 426)
            response->set(http::field::upgrade, "websocket");
        response->keep_alive(keep_alive);
        if (!head_only)
            response->body() = page.body;
        response->prepare_payload();
        if (head_only)
            response->content_length(page.body.size());
        ++core().counters.http_responses[page.status];
        lowest().expires_after(core().options.http_deadline);
        const auto on_written = [self = this->shared_from_this(), response,
                                 keep_alive](error_code error, std::size_t) {
            if (error)
                return self->failed("http", error);
            keep_alive ? self->read_request() : self->close();
        };
        if (head_only) { // the serializer would wait for the body that the length announces
            auto header = std::make_shared<http::response<http::empty_body>>(
                http::response_header<>(response->base()));
            http::async_write(stream_, *header,
                              [on_written, header](error_code error, std::size_t bytes) {
                                  on_written(error, bytes);
                              });
        } else {
            http::async_write(stream_, *response, on_written);
        }
    }

    void respond_and_close(const Page& page, error_code error) {
        note("http", error);
        respond(page, false, false);
    }

    void failed(std::string_view what, error_code error) {
        // A peer that goes away, or says nothing, between requests is none of our business.
        if (error != beast::error::timeout && error != asio::error::eof &&
            error != asio::error::connection_reset && error != asio::error::operation_aborted)
            note(what, error);
        lowest().close();
    }

    void note(std::string_view what, error_code error) {
        ++core().counters.handshakes_failed;
        core().log(fmt::format("event=connection_refused peer={} reason=bad_{} why=\"{}\"", peer_,
                               what, printable(error.message())));
    }

    void close() {
        error_code ignored;
        lowest().socket().shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
        lowest().close();
    }

    ConnectionSlot slot_;
    Stream stream_;
    std::string peer_;
    beast::flat_buffer buffer_{header_bytes_max + body_bytes_max};
    std::optional<Parser> parser_;
};

} // namespace

template <class Stream>
void serve_http(ConnectionSlot slot, Stream stream, std::string peer) {
    std::make_shared<HttpConnection<Stream>>(std::move(slot), std::move(stream), std::move(peer))
        ->run();
}

template void serve_http(ConnectionSlot, PlainStream, std::string);
template void serve_http(ConnectionSlot, TlsStream, std::string);

} // namespace seaway::server
