// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <fmt/format.h>

#include "server/net/connection.h"
#include "server/net/http_head.h"
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

using Request = http::request<http::string_body>;

HttpHead head_of(const Request& request) {
    const auto all = [&](http::field name) {
        std::vector<std::string_view> values;
        const auto [first, last] = request.equal_range(name);
        for (auto at = first; at != last; ++at)
            values.push_back(text(at->value()));
        return values;
    };
    return {.version = request.version(),
            .method = text(request.method_string()),
            .target = text(request.target()),
            .hosts = all(http::field::host),
            .origins = all(http::field::origin),
            .transfer_encodings = all(http::field::transfer_encoding),
            .authorizations = all(http::field::authorization),
            .fetch_site = text(request["Sec-Fetch-Site"]),
            .fetch_mode = text(request["Sec-Fetch-Mode"])};
}

class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
  public:
    HttpConnection(ConnectionSlot slot, sockets::Socket socket, Peer peer)
        : slot_(std::move(slot)), socket_(std::move(socket)), peer_(std::move(peer)),
          delay_timer_(socket_.get_executor()) {}

    void run() {
        if (!socket_.has_tls())
            return read_request();
        await_request();
        socket_.expires_after(core().options.http_deadline);
        socket_.accept_tls([self = shared_from_this()](error_code error) {
            if (error)
                return self->failed("tls", error);
            self->read_request();
        });
    }

  private:
    using Parser = http::request_parser<http::string_body>;
    using Clock = std::chrono::steady_clock;

    Core& core() { return *slot_.core(); }

    /// Until its place is left this connection makes room for a newcomer where there is none.
    void await_request() {
        awaits_.take(slot_.door().awaiting_requests, peer_.address, [weak = weak_from_this()] {
            if (const auto self = weak.lock()) {
                self->awaits_.leave();
                self->delay_timer_.cancel();
                self->socket_.close();
            }
        });
    }

    void read_request() {
        await_request();
        const auto wait = peer_.address->request_bytes.wait_for(0, Clock::now());
        if (wait.count() == 0)
            return read_now();
        ++core().counters.reads_delayed;
        delay_timer_.expires_after(wait);
        delay_timer_.async_wait([self = shared_from_this()](error_code error) {
            if (!error)
                self->read_now();
        });
    }

    void read_now() {
        parser_.emplace();
        parser_->header_limit(header_bytes_max);
        parser_->body_limit(body_bytes_max);
        socket_.expires_after(core().options.http_deadline);
        http::async_read(socket_, buffer_, *parser_,
                         [self = shared_from_this()](error_code error, std::size_t bytes) {
                             self->peer_.address->request_bytes.take(static_cast<double>(bytes),
                                                                     Clock::now());
                             self->on_request(error);
                         });
    }

    void on_request(error_code error) {
        awaits_.leave();
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
        const Request& request = parser_->get();
        auto read = read_head(head_of(request), core().origins, peer_.loopback, socket_.has_tls());
        if (const auto* refused = std::get_if<Refused>(&read))
            return refuse(*refused);
        serve(std::get<Asked>(read));
    }

    bool head_only() const { return parser_->get().method() == http::verb::head; }

    void refuse(const Refused& refused) {
        if (beast::websocket::is_upgrade(parser_->get()))
            return refuse_session(refused.reason, refused.page);
        respond(refused.page, head_only(), false);
    }

    void serve(Asked& asked) {
        const Request& request = parser_->get();
        const bool health_only = slot_.door().health_only;
        const bool is_stream = beast::websocket::is_upgrade(request) &&
                               asked.path == protocol::stream_path && !health_only;
        Judgement judged;
        if (!health_only) {
            judged = judge_token(core(), peer_, asked.token);
            if (const std::optional<Page> page = keep_out(core(), asked.path, judged))
                return is_stream ? refuse_session("unauthorised", *page)
                                 : respond(*page, head_only(), false);
        }
        if (is_stream)
            return upgrade(judged.standing);
        const bool reads = request.method() == http::verb::get || head_only();
        if (reads && asked.path == map_path && !health_only)
            return start_map(std::move(asked.parameters));
        respond(page_for(core(), text(request.method_string()), asked.path, health_only),
                head_only(), request.keep_alive());
    }

    // ---- from here to a stream ----

    /// An upgrade ends as a page: counted by reason, and no session.
    void refuse_session(std::string_view reason, const Page& page) {
        ++core().counters.sessions_refused[std::string(reason)];
        if (const auto count = peer_.address->turn_away(Crowding::sessions, Clock::now()))
            core().log(fmt::format("event=session_refused peer={} reason={} count={}", peer_.name,
                                   reason, count));
        respond(page, false, false);
    }

    void upgrade(Standing standing) {
        const Request& request = parser_->get();
        if (!offers(text(request[http::field::sec_websocket_protocol]),
                    protocol::websocket_subprotocol))
            return refuse_session("subprotocol",
                                  {.status = 400,
                                   .body = fmt::format("offer the subprotocol {}\n",
                                                       protocol::websocket_subprotocol)});
        if (buffer_.size() > 0)
            return refuse_session(
                "bad_request", {.status = 400, .body = "bytes before the upgrade was answered\n"});
        const int silent_max = core().options.sessions_without_hello_per_address;
        if (standing == Standing::stranger && silent_max > 0 &&
            peer_.address->without_hello >= silent_max) {
            return refuse_session(
                "address_full",
                {.status = 429,
                 .body = fmt::format("{} sessions of your address have not said Hello yet\n",
                                     peer_.address->without_hello),
                 .retry_after_s = 1});
        }
        if (!core().takes_a_session()) {
            // A token goes before those without; among these, addresses with fewer go before others.
            const int fewer = standing == Standing::stranger ? peer_.address->without_hello + 1 : 0;
            core().awaiting_hello.give_up_of_most(&Address::without_hello, fewer);
        }
        if (!core().takes_a_session())
            return refuse_session(protocol::name(wire::ErrorCode::server_full),
                                  {.status = 503,
                                   .body = "too many sessions, try again later\n",
                                   .retry_after_s = 1});
        socket_.expires_never();
        serve_stream(std::move(slot_), std::move(socket_), {parser_->release()}, std::move(peer_),
                     standing);
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
        if (page.retry_after_s > 0)
            response->set(http::field::retry_after, std::to_string(page.retry_after_s));
        if (page.status == 401)
            response->set(http::field::www_authenticate, "Bearer");
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

    void start_map(std::map<std::string, std::string> parameters) {
        socket_.expires_never(); // the host answers; what it takes is bounded there
        watch_peer();
        const std::weak_ptr<HttpConnection> weak = weak_from_this();
        const auto core_ptr = slot_.core();
        const auto more_rows = [weak, core_ptr] {
            core_ptr->post([weak] {
                if (const auto self = weak.lock())
                    self->write_map();
            });
        };
        core().waiting_for_maps.insert(shared_from_this());
        core().host.map({std::move(parameters), Asker(here_), more_rows},
                        [weak, core_ptr](Result<std::unique_ptr<ByteSource>> made) {
                            auto shared = std::make_shared<decltype(made)>(std::move(made));
                            core_ptr->post([weak, core_ptr, shared] {
                                if (const auto self = weak.lock())
                                    self->begin_map(*shared);
                                else
                                    core_ptr->disposal.take(shared);
                            });
                        });
    }

    /// A pending read notices that the peer has left, also while nothing is written to it. What it
    /// says meanwhile is not looked at: a map ends its connection.
    void watch_peer() {
        socket_.async_read_some(asio::buffer(unasked_),
                                [self = shared_from_this()](error_code error, std::size_t) {
                                    if (self->here_ == nullptr)
                                        return;
                                    if (!error)
                                        return self->watch_peer();
                                    self->end_map();
                                });
    }

    void begin_map(Result<std::unique_ptr<ByteSource>>& made) {
        if (!made) {
            if (here_ == nullptr)
                return end_map();
            const auto self = shared_from_this();
            core().waiting_for_maps.erase(self);
            here_ = nullptr;
            return respond({.status = http_status(made.error()),
                            .body = made.error().message + "\n",
                            .retry_after_s = retry_after_s(made.error())},
                           head_only(), false);
        }
        map_ = *std::move(made);
        if (here_ == nullptr)
            return end_map();
        auto header = std::make_shared<http::response<http::empty_body>>();
        header->result(200);
        header->version(11);
        header->set(http::field::server, "seaway/" SEAWAY_VERSION);
        header->set(http::field::content_type, "application/vnd.seaway.map");
        header->set(http::field::cache_control, "no-store");
        header->keep_alive(false);
        header->content_length(map_->size());
        ++core().counters.http_responses[200];
        begin_map_write();
        auto serializer = std::make_shared<http::response_serializer<http::empty_body>>(*header);
        http::async_write_header(
            socket_, *serializer,
            [self = shared_from_this(), header, serializer](error_code error, std::size_t) {
                if (self->head_only() && !error)
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
        begin_map_write();
        asio::async_write(socket_, asio::buffer(map_chunk_),
                          [self = shared_from_this()](error_code error, std::size_t) {
                              self->on_map_written(error);
                          });
    }

    /// The peer has write_timeout for each piece, and for all that it is behind the least rate.
    void begin_map_write() {
        map_writing_ = true;
        map_write_begun_ = Clock::now();
        const std::chrono::duration<double> earned(static_cast<double>(map_sent_) /
                                                   core().options.map_bytes_per_s_min);
        const auto left = core().options.write_timeout - map_waited_ + earned;
        socket_.expires_after(
            std::clamp(std::chrono::duration_cast<std::chrono::milliseconds>(left),
                       std::chrono::milliseconds(1), core().options.write_timeout));
    }

    void on_map_written(error_code error) {
        map_writing_ = false;
        map_waited_ += Clock::now() - map_write_begun_;
        if (error) {
            end_map();
            return failed("http", error);
        }
        write_map();
    }

    void end_map() {
        const auto self = shared_from_this();
        core().waiting_for_maps.erase(self);
        here_ = nullptr;
        if (map_)
            core().disposal.take(std::move(map_)); // its threads end in their own time
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
        core().log(fmt::format("event=connection_refused peer={} reason=bad_{} why=\"{}\"",
                               peer_.name, what, printable(error.message())));
    }

    void close() {
        socket_.shutdown_send();
        socket_.close();
    }

    ConnectionSlot slot_;
    sockets::Socket socket_;
    Peer peer_;
    asio::steady_timer delay_timer_;
    beast::flat_buffer buffer_{header_bytes_max + body_bytes_max};
    std::optional<Parser> parser_;
    WaitingLine::Place awaits_;

    std::shared_ptr<const void> here_ =
        std::make_shared<char>(); ///< until no map is wanted any more
    std::array<std::uint8_t, 512> unasked_{};
    std::unique_ptr<ByteSource> map_;
    std::vector<std::uint8_t> map_chunk_; ///< being written
    std::uint64_t map_sent_ = 0;
    bool map_writing_ = false;
    Clock::time_point map_write_begun_;
    Clock::duration map_waited_{0}; ///< for the peer, all in all
};

} // namespace

void serve_http(ConnectionSlot slot, sockets::Socket socket, Peer peer) {
    std::make_shared<HttpConnection>(std::move(slot), std::move(socket), std::move(peer))->run();
}

} // namespace seaway::server
