// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <boost/asio/write.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <fmt/format.h>

#include "server/net/connection.h"
#include "server/net/pages.h"
#include "server/net/refusals.h"
#include "server/net/tokens.h"
#include "sockets/socket.h"
#include "sockets/upgrade.h"

namespace seaway::server {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using beast::error_code;

/// Of a request: an ordinary browser sends 1 KB. No page takes a body.
constexpr std::uint32_t header_bytes_max = 8 * 1024;
constexpr std::uint64_t body_bytes_max = 1024;

std::string_view text(beast::string_view view) {
    return {view.data(), view.size()};
}

/// Name=value pairs behind the '?'. Values are numbers and words: nothing needs decoding.
std::map<std::string, std::string> query_parameters(std::string_view target) {
    std::map<std::string, std::string> parameters;
    std::size_t begin = target.find('?');
    while (begin != std::string_view::npos) {
        const std::size_t end = target.find('&', ++begin);
        const std::string_view pair = target.substr(begin, end - begin);
        const std::size_t equals = std::min(pair.find('='), pair.size());
        parameters[std::string(pair.substr(0, equals))] =
            std::string(pair.substr(std::min(equals + 1, pair.size())));
        begin = end;
    }
    return parameters;
}

class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
  public:
    HttpConnection(ConnectionSlot slot, sockets::Socket socket, std::string peer)
        : slot_(std::move(slot)), socket_(std::move(socket)), peer_(std::move(peer)) {}

    void run() {
        if (!socket_.has_tls())
            return read_request();
        socket_.expires_after(core().options.http_deadline);
        socket_.accept_tls([self = shared_from_this()](error_code error) {
            if (error)
                return self->failed("tls", error);
            self->read_request();
        });
    }

  private:
    using Parser = http::request_parser<http::string_body>;

    Core& core() { return *slot_.core(); }

    void read_request() {
        parser_.emplace();
        parser_->header_limit(header_bytes_max);
        parser_->body_limit(body_bytes_max);
        socket_.expires_after(core().options.http_deadline);
        http::async_read(socket_, buffer_, *parser_,
                         [self = shared_from_this()](error_code error, std::size_t) {
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
        const bool reads =
            request.method() == http::verb::get || request.method() == http::verb::head;
        if (reads && target.substr(0, target.find('?')) == map_path)
            return start_map(target);
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
        if (!core().takes_a_session()) {
            ++core().counters.sessions_closed[std::string(
                protocol::name(wire::ErrorCode::server_full))];
            core().log(fmt::format("event=session_refused peer={} reason=server_full", peer_));
            return respond({.status = 503, .body = "too many sessions, try again later\n"}, false,
                           false);
        }
        socket_.expires_never();
        serve_stream(std::move(slot_), std::move(socket_), {parser_->release()}, std::move(peer_));
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
        socket_.expires_after(core().options.http_deadline);
        const auto on_written = [self = shared_from_this(), response, keep_alive](error_code error,
                                                                                  std::size_t) {
            if (error)
                return self->failed("http", error);
            keep_alive ? self->read_request() : self->close();
        };
        if (head_only) { // the serializer would wait for the body that the length announces
            auto header = std::make_shared<http::response<http::empty_body>>(
                http::response_header<>(response->base()));
            http::async_write(socket_, *header,
                              [on_written, header](error_code error, std::size_t bytes) {
                                  on_written(error, bytes);
                              });
        } else {
            http::async_write(socket_, *response, on_written);
        }
    }

    // ---- bulk maps: a length, then chunks as they are made and taken ----

    void start_map(std::string_view target) {
        socket_.expires_never(); // the host answers; what it takes is bounded there
        const std::weak_ptr<HttpConnection> weak = weak_from_this();
        const auto core_ptr = slot_.core();
        const auto on_io = [weak, core_ptr](auto work) {
            core_ptr->post([weak, work]() mutable {
                if (const auto self = weak.lock())
                    work(*self);
            });
        };
        core().waiting_for_maps.insert(shared_from_this());
        core().host.map({query_parameters(target), Asker(here_),
                         [on_io] { on_io([](HttpConnection& self) { self.write_map(); }); }},
                        [on_io](Result<std::unique_ptr<ByteSource>> made) {
                            auto shared = std::make_shared<decltype(made)>(std::move(made));
                            on_io([shared](HttpConnection& self) { self.begin_map(*shared); });
                        });
    }

    void begin_map(Result<std::unique_ptr<ByteSource>>& made) {
        const bool head_only = parser_->get().method() == http::verb::head;
        if (!made) {
            const auto self = shared_from_this();
            core().waiting_for_maps.erase(self);
            return respond(
                {.status = http_status(made.error()), .body = made.error().message + "\n"},
                head_only, parser_->get().keep_alive());
        }
        map_ = *std::move(made);
        auto header = std::make_shared<http::response<http::empty_body>>();
        header->result(200);
        header->version(11);
        header->set(http::field::server, "seaway/" SEAWAY_VERSION);
        header->set(http::field::content_type, "application/vnd.seaway.map");
        header->set(http::field::cache_control, "no-store");
        header->keep_alive(false);
        header->content_length(map_->size());
        ++core().counters.http_responses[200];
        socket_.expires_after(core().options.write_timeout);
        map_writing_ = true;
        auto serializer = std::make_shared<http::response_serializer<http::empty_body>>(*header);
        http::async_write_header(socket_, *serializer,
                                 [self = shared_from_this(), header, serializer,
                                  head_only](error_code error, std::size_t) {
                                     if (head_only && !error)
                                         return self->end_map(); // before a row of it is made
                                     self->on_map_written(error);
                                 });
    }

    void write_map() {
        if (!map_ || map_writing_)
            return;
        map_chunk_ = map_->next();
        if (map_chunk_.empty()) {
            if (map_sent_ == map_->size())
                return end_map();
            return socket_.expires_never(); // waits for the next chunk, not for the peer
        }
        map_sent_ += map_chunk_.size();
        map_writing_ = true;
        socket_.expires_after(core().options.write_timeout);
        asio::async_write(socket_, asio::buffer(map_chunk_),
                          [self = shared_from_this()](error_code error, std::size_t) {
                              self->on_map_written(error);
                          });
    }

    void on_map_written(error_code error) {
        map_writing_ = false;
        if (error) {
            end_map();
            return failed("http", error);
        }
        write_map();
    }

    void end_map() {
        const auto self = shared_from_this();
        core().waiting_for_maps.erase(self);
        map_.reset();
        close();
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
        socket_.close();
    }

    void note(std::string_view what, error_code error) {
        ++core().counters.handshakes_failed;
        core().log(fmt::format("event=connection_refused peer={} reason=bad_{} why=\"{}\"", peer_,
                               what, printable(error.message())));
    }

    void close() {
        socket_.shutdown_send();
        socket_.close();
    }

    ConnectionSlot slot_;
    sockets::Socket socket_;
    std::string peer_;
    beast::flat_buffer buffer_{header_bytes_max + body_bytes_max};
    std::optional<Parser> parser_;

    std::shared_ptr<const void> here_ = std::make_shared<char>(); ///< for who makes the map
    std::unique_ptr<ByteSource> map_;
    std::vector<std::uint8_t> map_chunk_; ///< being written
    std::uint64_t map_sent_ = 0;
    bool map_writing_ = false;
};

} // namespace

void serve_http(ConnectionSlot slot, sockets::Socket socket, std::string peer) {
    std::make_shared<HttpConnection>(std::move(slot), std::move(socket), std::move(peer))->run();
}

} // namespace seaway::server
