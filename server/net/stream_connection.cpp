// SPDX-License-Identifier: Apache-2.0
#include <optional>

#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/ssl.hpp>
#include <boost/beast/websocket.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <fmt/format.h>

#include "protocol/limits.h"
#include "server/net/connection.h"
#include "server/net/session.h"

namespace seaway::server {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using beast::error_code;
using protocol::SharedBytes;

using PlainStream = beast::tcp_stream;
using TlsStream = beast::ssl_stream<beast::tcp_stream>;
using Request = http::request<http::string_body>;

/// A read buffer above this is given back after each message: a thousand idle sessions that once
/// sent a large query hold nothing.
constexpr std::size_t idle_buffer_bytes = 16 * 1024;
/// For GoAway and the closing handshake, after which the socket is closed hard.
constexpr std::chrono::milliseconds close_deadline{1000};

template <class Stream>
class StreamConnection final : public Link,
                               public std::enable_shared_from_this<StreamConnection<Stream>> {
  public:
    StreamConnection(ConnectionSlot slot, Stream stream, std::string peer)
        : slot_(std::move(slot)), ws_(std::move(stream)), peer_(std::move(peer)),
          hello_timer_(ws_.get_executor()), write_timer_(ws_.get_executor()),
          close_timer_(ws_.get_executor()) {}

    void run(const Request& request) {
        ws_.set_option(websocket::stream_base::timeout{core().options.http_deadline,
                                                       core().options.idle_timeout, true});
        ws_.set_option(websocket::stream_base::decorator([](websocket::response_type& response) {
            response.set(http::field::server, "seaway/" SEAWAY_VERSION);
            response.set(http::field::sec_websocket_protocol,
                         std::string(protocol::websocket_subprotocol));
        }));
        ws_.read_message_max(protocol::limits::client_message_bytes_max);
        ws_.auto_fragment(false);
        ws_.binary(true);
        ws_.async_accept(request, [self = this->shared_from_this()](error_code error) {
            self->on_accepted(error);
        });
    }

    // ---- Link ------------------------------------------------------------------------------

    void send_more() override {
        if (writing_ != nullptr || lost_)
            return;
        writing_ =
            go_away_ != nullptr ? std::exchange(go_away_, nullptr) : session_->next_message();
        if (writing_ == nullptr) {
            if (closing_)
                shake_hands();
            return;
        }
        write_timer_.expires_after(core().options.write_timeout);
        write_timer_.async_wait([self = this->shared_from_this()](error_code error) {
            if (!error)
                self->write_overdue();
        });
        ws_.async_write(asio::buffer(*writing_),
                        [self = this->shared_from_this()](error_code error, std::size_t) {
                            self->on_written(error);
                        });
    }

    void close(SharedBytes go_away, wire::ErrorCode code, const std::string& why) override {
        closing_ = true;
        go_away_ = std::move(go_away);
        close_reason_.code = protocol::close_code(code);
        close_reason_.reason.assign(why.substr(0, close_reason_.reason.max_size()));
        close_timer_.expires_after(close_deadline);
        close_timer_.async_wait([self = this->shared_from_this()](error_code error) {
            if (!error)
                self->drop();
        });
        send_more();
    }

  private:
    Core& core() { return *slot_.core(); }

    void on_accepted(error_code error) {
        if (error) {
            ++core().counters.handshakes_failed;
            core().log(fmt::format("event=connection_refused peer={} reason=bad_upgrade why=\"{}\"",
                                   peer_, error.message()));
            return drop();
        }
        session_.emplace(core(), *this, peer_);
        if (core().stopping)
            return session_->close(wire::ErrorCode::shutting_down, "the server stops");
        hello_timer_.expires_after(core().options.hello_deadline);
        hello_timer_.async_wait([self = this->shared_from_this()](error_code waited) {
            if (!waited)
                self->session_->hello_overdue();
        });
        read();
    }

    void read() {
        if (reading_ || closing_ || lost_ || !session_->wants_requests())
            return;
        reading_ = true;
        ws_.async_read(buffer_, [self = this->shared_from_this()](error_code error, std::size_t) {
            self->on_read(error);
        });
    }

    void on_read(error_code error) {
        reading_ = false;
        if (error)
            return on_lost(error);
        const auto data = buffer_.cdata();
        if (ws_.got_binary())
            session_->receive({static_cast<const std::uint8_t*>(data.data()), data.size()});
        else
            session_->close(wire::ErrorCode::bad_message, "a text message; only binary is spoken");
        buffer_.consume(data.size());
        if (buffer_.capacity() > idle_buffer_bytes)
            buffer_.shrink_to_fit();
        read();
    }

    void on_written(error_code error) {
        writing_ = nullptr;
        write_timer_.cancel();
        if (error)
            return on_lost(error);
        read(); // may have been held back by replies that waited
        send_more();
    }

    void write_overdue() {
        if (writing_ == nullptr || lost_)
            return;
        session_->end(protocol::name(wire::ErrorCode::too_slow),
                      fmt::format("{} bytes could not be sent within {} ms", writing_->size(),
                                  core().options.write_timeout.count()));
        drop();
    }

    /// Read or write has failed: the connection is over. Says why, unless that is known already.
    void on_lost(error_code error) {
        if (error == websocket::error::closed) {
            session_->end(closed_by_client,
                          fmt::format("code {} {}", static_cast<unsigned>(ws_.reason().code),
                                      std::string(ws_.reason().reason.c_str())));
        } else if (error == beast::error::timeout) {
            const bool stuck = writing_ != nullptr;
            session_->end(
                protocol::name(stuck ? wire::ErrorCode::too_slow : wire::ErrorCode::idle),
                fmt::format("nothing received for {} ms", core().options.idle_timeout.count()));
        } else if (error == websocket::condition::protocol_violation ||
                   error == websocket::error::message_too_big ||
                   error == websocket::error::buffer_overflow) {
            session_->end(protocol::name(wire::ErrorCode::bad_message), error.message());
        } else {
            session_->end(disconnected, error.message());
        }
        drop();
    }

    void shake_hands() {
        if (std::exchange(shaking_, true))
            return;
        ws_.async_close(close_reason_,
                        [self = this->shared_from_this()](error_code) { self->drop(); });
    }

    /// Closes the socket; whatever is under way ends with an error, and the last handler that goes
    /// takes this object with it.
    void drop() {
        lost_ = true;
        hello_timer_.cancel();
        write_timer_.cancel();
        close_timer_.cancel();
        beast::get_lowest_layer(ws_).close();
    }

    ConnectionSlot slot_;
    websocket::stream<Stream> ws_;
    std::string peer_;
    asio::steady_timer hello_timer_;
    asio::steady_timer write_timer_;
    asio::steady_timer close_timer_;
    beast::flat_buffer buffer_;
    std::optional<Session> session_;
    SharedBytes writing_;
    SharedBytes go_away_;
    websocket::close_reason close_reason_;
    bool reading_ = false;
    bool closing_ = false;
    bool shaking_ = false;
    bool lost_ = false;
};

} // namespace

template <class Stream, class AnyRequest>
void serve_stream(ConnectionSlot slot, Stream stream, const AnyRequest& request, std::string peer) {
    std::make_shared<StreamConnection<Stream>>(std::move(slot), std::move(stream), std::move(peer))
        ->run(request);
}

template void serve_stream(ConnectionSlot, PlainStream, const Request&, std::string);
template void serve_stream(ConnectionSlot, TlsStream, const Request&, std::string);

} // namespace seaway::server
