// SPDX-License-Identifier: Apache-2.0
#include "sockets/web_socket.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <string_view>
#include <system_error>
#include <utility>

#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket.hpp>
#include <fmt/format.h>

namespace seaway::sockets {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;

namespace {

WebSocketEnd kind_of(error_code error) {
    if (error == websocket::error::closed)
        return WebSocketEnd::closed;
    if (error == beast::error::timeout)
        return WebSocketEnd::silent;
    if (error == websocket::condition::protocol_violation ||
        error == websocket::error::message_too_big || error == websocket::error::buffer_overflow)
        return WebSocketEnd::not_understood;
    return WebSocketEnd::broken;
}

constexpr std::chrono::seconds farewell_patience{1};

/// The first line of what a stranger says, for a terminal.
std::string first_line(const std::string& text) {
    constexpr std::size_t bytes_max = 200;
    std::string line = text.substr(0, std::min(text.find_first_of("\r\n"), bytes_max));
    std::replace_if(
        line.begin(), line.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
    return line;
}

Result<void> result(error_code error) {
    if (error)
        return Error{kind_of(error), error.message()};
    return {};
}

/// Bad request, unauthorised, forbidden, upgrade required: the same request meets the same answer.
bool stays_declined(unsigned http_status) {
    return http_status == 400 || http_status == 401 || http_status == 403 || http_status == 426;
}

/// "Retry-After: 3" in seconds. 0: it does not say so, or names a date, which takes a clock that is right.
std::uint32_t retry_after_ms(std::string_view field) {
    std::uint32_t seconds = 0;
    const auto [end, problem] = std::from_chars(field.data(), field.data() + field.size(), seconds);
    if (end != field.data() + field.size() || problem == std::errc::invalid_argument)
        return 0;
    constexpr std::uint32_t most_s = std::numeric_limits<std::uint32_t>::max() / 1000;
    return 1000 * (problem == std::errc() ? std::min(seconds, most_s) : most_s);
}

} // namespace

struct WebSocket::Impl {
    Impl(Socket socket, const WebSocketOptions& wanted)
        : options(wanted), stream(std::move(socket)), farewell(stream.get_executor()) {}

    /// Nothing follows the peer's closing frame but the end of TCP, which may be lost on its way.
    void ends_soon() {
        farewell.expires_after(farewell_patience);
        farewell.async_wait([this, there = std::weak_ptr(this_is_there)](error_code gone) {
            if (!gone && !there.expired())
                stream.next_layer().close();
        });
    }

    const WebSocketOptions options;
    websocket::stream<Socket> stream;
    beast::flat_buffer buffer;
    websocket::response_type response; ///< of a server
    asio::steady_timer farewell;
    const std::shared_ptr<int> this_is_there =
        std::make_shared<int>(); ///< a timer that is due outlives it
};

WebSocket::WebSocket(Socket socket, const WebSocketOptions& options)
    : impl_(std::make_unique<Impl>(std::move(socket), options)) {
    auto& stream = impl_->stream;
    stream.set_option(
        websocket::stream_base::timeout{options.handshake_patience, options.idle_patience, true});
    stream.read_message_max(options.message_bytes_max);
    stream.auto_fragment(false);
    stream.binary(true);
    stream.control_callback([impl = impl_.get()](websocket::frame_type kind, std::string_view) {
        if (kind == websocket::frame_type::close)
            impl->ends_soon();
    });
}

WebSocket::~WebSocket() = default;
WebSocket::WebSocket(WebSocket&&) noexcept = default;

void WebSocket::shake_hands(const std::string& host, const std::string& path, Done done) {
    impl_->stream.set_option(websocket::stream_base::decorator(
        [&options = impl_->options](websocket::request_type& request) {
            request.set(http::field::user_agent, options.program);
            request.set(http::field::sec_websocket_protocol, options.subprotocol);
        }));
    const auto answered = [impl = impl_.get(), path](error_code error) -> Result<void> {
        if (error == websocket::error::upgrade_declined) {
            const std::string why = first_line(impl->response.body());
            const unsigned status = impl->response.result_int();
            Error declined{fmt::format("the server answers HTTP {} at {}{}{}", status, path,
                                       why.empty() ? "" : ": ", why)};
            if (stays_declined(status))
                declined.kind = WebSocketEnd::declined;
            declined.retry_after_ms = retry_after_ms(impl->response[http::field::retry_after]);
            return declined;
        }
        if (error == beast::error::timeout)
            return Error{"it does not answer"};
        if (error)
            return Error{fmt::format("this is no WebSocket server ({})", error.message())};
        if (impl->response[http::field::sec_websocket_protocol] != impl->options.subprotocol)
            return Error{WebSocketEnd::declined,
                         fmt::format("the server does not speak {}", impl->options.subprotocol)};
        return {};
    };
    impl_->stream.async_handshake(
        impl_->response, host, path,
        [answered, done = std::move(done)](error_code error) { done(answered(error)); });
}

void WebSocket::read(std::function<void(Result<Message>)> done) {
    Impl& impl = *impl_;
    impl.buffer.clear();
    if (impl.buffer.capacity() > impl.options.kept_buffer_bytes)
        impl.buffer.shrink_to_fit();
    impl.stream.async_read(
        impl.buffer, [&impl, done = std::move(done)](error_code error, std::size_t) {
            if (error) {
                impl.farewell.cancel();
                return done(Error{kind_of(error), error.message()});
            }
            const auto data = impl.buffer.cdata();
            done(Message{{static_cast<const std::uint8_t*>(data.data()), data.size()},
                         impl.stream.got_binary()});
        });
}

void WebSocket::write(std::span<const std::uint8_t> bytes, Done done) {
    impl_->stream.async_write(
        asio::buffer(bytes.data(), bytes.size()),
        [done = std::move(done)](error_code error, std::size_t) { done(result(error)); });
}

void WebSocket::close(const Close& why, std::function<void()> done) {
    websocket::close_reason reason(static_cast<websocket::close_code>(why.code));
    reason.reason.assign(why.reason.substr(0, reason.reason.max_size()));
    impl_->stream.async_close(reason, [done = std::move(done)](error_code) { done(); });
}

WebSocket::Close WebSocket::peer_close() const {
    const websocket::close_reason& reason = impl_->stream.reason();
    return {static_cast<unsigned>(reason.code), reason.reason.c_str()};
}

Socket& WebSocket::socket() {
    return impl_->stream.next_layer();
}

} // namespace seaway::sockets
