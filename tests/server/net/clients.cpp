// SPDX-License-Identifier: Apache-2.0
#include "tests/server/net/clients.h"

#include <algorithm>
#include <array>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <gtest/gtest.h>

namespace seaway::tests {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;

namespace {

tcp::endpoint loopback(int port) {
    return {asio::ip::address_v4::loopback(), static_cast<unsigned short>(port)};
}

std::string text(beast::string_view view) {
    return {view.data(), view.size()};
}

} // namespace

struct Client::Impl {
    explicit Impl(int to) : ws(io), port(to) {}

    beast::tcp_stream& socket() { return beast::get_lowest_layer(ws); }
    void limit(std::chrono::milliseconds wait = std::chrono::seconds(5)) {
        socket().expires_after(wait);
    }
    void run() {
        io.restart();
        io.run();
    }

    asio::io_context io;
    websocket::stream<beast::tcp_stream> ws;
    int port;
    websocket::response_type response;
    beast::flat_buffer buffer;
    beast::error_code error;
    protocol::MessageReader reader{protocol::Sender::server};
};

Client::Client(int port) : impl_(std::make_unique<Impl>(port)) {}
Client::~Client() = default;

std::error_code Client::connect(const std::string& subprotocol) {
    Impl& c = *impl_;
    beast::error_code result;
    c.limit();
    c.socket().async_connect(loopback(c.port), [&](beast::error_code error) { result = error; });
    c.run();
    if (result)
        return result;
    c.ws.set_option(websocket::stream_base::decorator([=](websocket::request_type& request) {
        request.set(http::field::sec_websocket_protocol, subprotocol);
    }));
    c.ws.read_message_max(1u << 20);
    c.limit();
    c.ws.async_handshake(c.response, "127.0.0.1", "/v1/stream",
                         [&](beast::error_code error) { result = error; });
    c.run();
    c.ws.binary(true);
    return result;
}

std::error_code Client::send(const protocol::Bytes& bytes) {
    beast::error_code result;
    impl_->limit();
    impl_->ws.async_write(asio::buffer(bytes),
                          [&](beast::error_code error, std::size_t) { result = error; });
    impl_->run();
    return result;
}

const wire::Message* Client::receive(std::chrono::milliseconds wait) {
    Impl& c = *impl_;
    c.buffer.consume(c.buffer.size());
    c.limit(wait);
    c.ws.async_read(c.buffer, [&](beast::error_code error, std::size_t) { c.error = error; });
    c.run();
    if (c.error)
        return nullptr;
    const auto data = c.buffer.cdata();
    auto message = c.reader.read({static_cast<const std::uint8_t*>(data.data()), data.size()});
    EXPECT_TRUE(message.has_value()) << (message ? "" : message.error().message);
    return message ? *message : nullptr;
}

const wire::Message* Client::receive(wire::Body kind) {
    for (int i = 0; i < 10'000; ++i) {
        const wire::Message* message = receive();
        if (message == nullptr || message->body_type() == kind)
            return message;
    }
    return nullptr;
}

bool Client::greet(std::string_view token) {
    return !send(protocol::hello("test", token)) && receive(wire::Body::SeaState) != nullptr;
}

bool Client::stays_quiet_for(std::chrono::milliseconds wait) {
    const auto quiet = std::make_shared<bool>(true);
    impl_->socket().expires_never();
    impl_->ws.async_read(impl_->buffer,
                         [quiet](beast::error_code, std::size_t) { *quiet = false; });
    impl_->io.restart();
    impl_->io.run_for(wait);
    return *quiet;
}

unsigned Client::close_code() {
    while (!impl_->error && receive() != nullptr) {
    }
    return impl_->error == websocket::error::closed ? impl_->ws.reason().code : 0;
}

std::error_code Client::error() const {
    return impl_->error;
}
int Client::status() const {
    return static_cast<int>(impl_->response.result_int());
}
std::string Client::subprotocol() const {
    return text(impl_->response[http::field::sec_websocket_protocol]);
}

// ---- RawPeer -----------------------------------------------------------------------------------

struct RawPeer::Impl {
    asio::io_context io;
    tcp::socket socket{io};
    beast::error_code end;
};

RawPeer::RawPeer(int port, int receive_buffer_bytes) : impl_(std::make_unique<Impl>()) {
    impl_->socket.open(tcp::v4());
    if (receive_buffer_bytes > 0)
        impl_->socket.set_option(asio::socket_base::receive_buffer_size(receive_buffer_bytes));
    impl_->socket.connect(loopback(port));
}
RawPeer::~RawPeer() = default;

void RawPeer::say(std::span<const std::uint8_t> bytes) {
    beast::error_code ignored; // the server may have closed already
    asio::write(impl_->socket, asio::buffer(bytes.data(), bytes.size()), ignored);
}

void RawPeer::say(std::string_view text) {
    say({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

void RawPeer::upgrade() {
    say("GET /v1/stream HTTP/1.1\r\nHost: x\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
        "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
        "Sec-WebSocket-Protocol: seaway.v1\r\n\r\n");
    const std::string answer = header();
    EXPECT_NE(answer.find("101"), std::string::npos) << answer;
}

void RawPeer::frame(const protocol::Bytes& payload, std::size_t bytes_sent) {
    protocol::Bytes bytes{0x82};
    const int length_bytes = payload.size() < 126 ? 0 : payload.size() < 65536 ? 2 : 8;
    const std::size_t first = length_bytes == 0 ? payload.size() : length_bytes == 2 ? 126 : 127;
    bytes.push_back(static_cast<std::uint8_t>(0x80 | first));
    for (int shift = 8 * (length_bytes - 1); shift >= 0; shift -= 8)
        bytes.push_back(static_cast<std::uint8_t>(payload.size() >> shift));
    bytes.insert(bytes.end(), 4, 0);
    bytes.insert(bytes.end(), payload.begin(), payload.end());
    say(std::span(bytes).first(std::min(bytes_sent, bytes.size())));
}

void RawPeer::reset() {
    impl_->socket.set_option(asio::socket_base::linger(true, 0));
    impl_->socket.close();
}

std::string RawPeer::header() {
    std::string answer;
    asio::read_until(impl_->socket, asio::dynamic_buffer(answer), "\r\n\r\n");
    return answer;
}

std::string RawPeer::rest() {
    std::string all;
    for (std::array<char, 4096> some{}; !impl_->end;)
        all.append(some.data(), impl_->socket.read_some(asio::buffer(some), impl_->end));
    return all;
}

bool RawPeer::closed_by_server() {
    rest();
    return true;
}

bool RawPeer::ended_in_order() const {
    return impl_->end == asio::error::eof;
}

// ---- HTTP --------------------------------------------------------------------------------------

HttpAnswer ask_http(int port, const std::string& target, const std::string& method) {
    asio::io_context io;
    tcp::socket socket(io);
    socket.connect(loopback(port));
    http::request<http::string_body> request(http::string_to_verb(method), target, 11);
    request.set(http::field::host, "127.0.0.1");
    request.set(http::field::connection, "close");
    http::write(socket, request);
    beast::flat_buffer buffer;
    http::response_parser<http::string_body> parser;
    parser.skip(method == "HEAD");
    beast::error_code error;
    http::read(socket, buffer, parser, error);
    EXPECT_FALSE(error) << error.message();
    HttpAnswer answer{static_cast<int>(parser.get().result_int()), parser.get().body(), {}};
    for (const auto& field : parser.get())
        answer.fields[text(field.name_string())] = text(field.value());
    return answer;
}

} // namespace seaway::tests
