// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <map>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <fmt/format.h>

#include "server/net/connection.h"
#include "server/net/http_head.h"
#include "server/net/http_response.h"
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
/// Of who was told that this was all, until it goes.
constexpr std::chrono::seconds parting_patience{2};

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
            .fetch_mode = text(request["Sec-Fetch-Mode"]),
            .fetch_dest = text(request["Sec-Fetch-Dest"])};
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
        socket_.expires_after(core().options.http_deadline); // for the first request as well
        deadline_runs_ = true;
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

    /// What has come counts; where there is no memory for it the connection ends.
    auto then(void (HttpConnection::*next)(error_code)) {
        return [self = shared_from_this(), next](error_code error, std::size_t bytes) {
            self->peer_.address->request_bytes.take(static_cast<double>(bytes), Clock::now());
            try {
                ((*self).*next)(error);
            } catch (const std::bad_alloc&) {
                self->socket_.close();
                throw;
            }
        };
    }

    void read_now() {
        parser_.emplace();
        parser_->header_limit(header_bytes_max);
        parser_->body_limit(body_bytes_max);
        if (!std::exchange(deadline_runs_, false))
            socket_.expires_after(core().options.http_deadline);
        http::async_read_header(socket_, buffer_, *parser_, then(&HttpConnection::on_header));
    }

    void on_header(error_code error) {
        if (error || parser_->is_done())
            return on_request(error);
        // Who waits to be told to go on with a body would wait for ever (RFC 9110, 10.1.1).
        if (parser_->get().count(http::field::expect) > 0 && parser_->get().version() >= 11) {
            awaits_.leave();
            return respond({.status = 417, .body = "no page takes a body\n"}, head_only(), false);
        }
        http::async_read(socket_, buffer_, *parser_, then(&HttpConnection::on_request));
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
    /// A client of HTTP/1.0 would have to be told so in a field of its own (RFC 9112, C.2.2): its connection ends instead.
    bool goes_on() const { return parser_->get().version() >= 11 && parser_->get().keep_alive(); }

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
        if (!health_only && !is_for_probers(asked.path)) {
            judged = judge_token(core(), peer_, asked.token);
            if (const std::optional<Page> page = keep_out(core(), asked.path, judged))
                return is_stream ? refuse_session("unauthorised", *page)
                                 : respond(*page, head_only(), false);
        }
        if (is_stream)
            return upgrade(judged.standing);
        if (core().stopping && asked.path == map_path)
            return respond(stopping_page(core()), head_only(), false);
        const bool reads = request.method() == http::verb::get || head_only();
        if (reads && asked.path == map_path && !health_only) {
            if (head_only())
                return announce_map(asked.parameters);
            peer_.address->request_bytes.take(answer_price_bytes, Clock::now()); // a refusal, too
            return serve_map(std::move(slot_), std::move(socket_), std::move(peer_),
                             std::move(asked.parameters));
        }
        respond(page_for(core(), text(request.method_string()), asked.path, health_only),
                head_only(), goes_on());
    }

    /// HEAD: nothing of the map is made.
    void announce_map(const std::map<std::string, std::string>& parameters) {
        const Result<std::uint64_t> bytes = core().host.map_bytes(parameters);
        if (!bytes)
            return respond({.status = http_status(bytes.error()),
                            .body = bytes.error().message + "\n",
                            .retry_after_s = retry_after_s(bytes.error())},
                           true, goes_on());
        respond({.content_type = std::string(map_content_type), .announced_bytes = *bytes}, true,
                goes_on());
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
        if (core().stopping)
            return refuse_session(protocol::name(wire::ErrorCode::shutting_down),
                                  stopping_page(core()));
        const auto [first, last] = request.equal_range(http::field::sec_websocket_protocol);
        if (std::none_of(first, last, [](const auto& field) {
                return offers(text(field.value()), protocol::websocket_subprotocol);
            }))
            return refuse_session("subprotocol",
                                  {.status = 400,
                                   .body = fmt::format("offer the subprotocol {}\n",
                                                       protocol::websocket_subprotocol)});
        if (!is_websocket_key(text(request[http::field::sec_websocket_key])))
            return refuse_session(
                "bad_request",
                {.status = 400, .body = "Sec-WebSocket-Key is not 16 bytes in base64\n"});
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
        const double says_bytes = head_only ? 0 : static_cast<double>(page.body.size());
        if (!slot_.door()
                 .health_only) // who watches a server at its own address is not to miss anything
            peer_.address->request_bytes.take(page.price_bytes + says_bytes, Clock::now());
        await_request(); // who does not read makes room, too
        answered_.emplace(slot_.door());
        write_page(core(), socket_, page, head_only, keep_alive,
                   [self = shared_from_this(), keep_alive](error_code error) {
                       self->answered_.reset();
                       if (error)
                           return self->failed("http", error);
                       keep_alive ? self->read_request() : self->close();
                   });
    }

    void respond_and_close(const Page& page, error_code error) {
        note("http", error);
        respond(page, false, false);
    }

    void failed(std::string_view what, error_code error) {
        // A peer that goes away, or says nothing, between requests is none of our business.
        if (!is_usual_end(error))
            note(what, error);
        socket_.close();
    }

    void note(std::string_view what, error_code error) {
        note_bad_peer(core(), peer_, what, error.message());
    }

    /// What was asked may not have been read to its end. Who stays makes room for a newcomer.
    void close() {
        await_request();
        socket_.part(parting_patience, [self = shared_from_this()] { self->awaits_.leave(); });
    }

    ConnectionSlot slot_;
    sockets::Socket socket_;
    Peer peer_;
    asio::steady_timer delay_timer_;
    bool deadline_runs_ = false; ///< since before the handshake
    beast::flat_buffer buffer_{header_bytes_max + body_bytes_max};
    std::optional<Parser> parser_;
    WaitingLine::Place awaits_;
    std::optional<AnsweredSlot> answered_; ///< while a page is sent
};

} // namespace

void serve_http(ConnectionSlot slot, sockets::Socket socket, Peer peer) {
    std::make_shared<HttpConnection>(std::move(slot), std::move(socket), std::move(peer))->run();
}

} // namespace seaway::server
