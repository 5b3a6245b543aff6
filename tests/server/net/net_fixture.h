// SPDX-License-Identifier: Apache-2.0
// A NetServer in front of a small explicit sea, and a WebSocket client that talks to it over a real
// loopback socket.
#pragma once

#include <atomic>
#include <chrono>
#include <cmath>
#include <fstream>
#include <map>
#include <mutex>
#include <set>
#include <sstream>
#include <thread>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include "protocol/messages.h"
#include "protocol/tile_codec.h"
#include "server/net/server.h"
#include "tests/server/simulation/small_sea.h"

namespace seaway::tests {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;

/// spdlog's lines while it lives.
class LogCapture {
  public:
    LogCapture() : before_(spdlog::default_logger()) {
        auto sink = std::make_shared<spdlog::sinks::ostream_sink_mt>(text_);
        spdlog::set_default_logger(std::make_shared<spdlog::logger>("test", std::move(sink)));
    }
    ~LogCapture() { spdlog::set_default_logger(before_); }
    LogCapture(const LogCapture&) = delete;
    LogCapture& operator=(const LogCapture&) = delete;

    /// Lines that contain both; only after the server has stopped.
    std::vector<std::string> lines_with(std::string_view a, std::string_view b = "") const {
        std::vector<std::string> found;
        std::istringstream in(text_.str());
        for (std::string line; std::getline(in, line);)
            if (line.find(a) != std::string::npos && line.find(b) != std::string::npos)
                found.push_back(line);
        return found;
    }
    std::string text() const { return text_.str(); }

  private:
    std::ostringstream text_;
    std::shared_ptr<spdlog::logger> before_;
};

/// Waits for a condition of another thread; true if it came within 5 s.
template <class Condition>
bool eventually(Condition condition) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(5);
    while (!condition()) {
        if (std::chrono::steady_clock::now() > deadline)
            return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return true;
}

/// A WebSocket client whose every operation ends after 5 s at the latest.
class Client {
  public:
    explicit Client(int port) : ws_(io_), port_(port) {}

    beast::error_code connect(std::string subprotocol = "seaway.v1") {
        beast::error_code result;
        const tcp::endpoint server(asio::ip::address_v4::loopback(),
                                   static_cast<unsigned short>(port_));
        limit();
        socket().async_connect(server, [&](beast::error_code error) { result = error; });
        run();
        if (result)
            return result;
        ws_.set_option(websocket::stream_base::decorator([=](websocket::request_type& request) {
            request.set(http::field::sec_websocket_protocol, subprotocol);
        }));
        ws_.read_message_max(1u << 20);
        limit();
        ws_.async_handshake(response_, "127.0.0.1", "/v1/stream",
                            [&](beast::error_code error) { result = error; });
        run();
        ws_.binary(true);
        return result;
    }

    beast::error_code send(const protocol::Bytes& bytes) {
        beast::error_code result;
        limit();
        ws_.async_write(asio::buffer(bytes),
                        [&](beast::error_code error, std::size_t) { result = error; });
        run();
        return result;
    }

    /// The next message, valid until the next call; null with error() set.
    const wire::Message* receive(std::chrono::milliseconds wait = std::chrono::seconds(5)) {
        buffer_.consume(buffer_.size());
        limit(wait);
        ws_.async_read(buffer_, [&](beast::error_code error, std::size_t) { error_ = error; });
        run();
        if (error_)
            return nullptr;
        const auto data = buffer_.cdata();
        auto message = reader_.read({static_cast<const std::uint8_t*>(data.data()), data.size()});
        EXPECT_TRUE(message.has_value()) << (message ? "" : message.error().message);
        return message ? *message : nullptr;
    }

    /// Skips what is not wanted, for at most 10 000 messages.
    const wire::Message* receive(wire::Body kind) {
        for (int i = 0; i < 10'000; ++i) {
            const wire::Message* message = receive();
            if (message == nullptr || message->body_type() == kind)
                return message;
        }
        return nullptr;
    }

    bool greet(std::string_view token = "") {
        return send(protocol::hello("test", token)) == beast::error_code() &&
               receive(wire::Body::SeaState) != nullptr;
    }

    /// Reads, answering pings underneath; false if a message or an end comes. The last call.
    bool stays_quiet_for(std::chrono::milliseconds wait) {
        const auto quiet = std::make_shared<bool>(true);
        socket().expires_never();
        ws_.async_read(buffer_, [quiet](beast::error_code, std::size_t) { *quiet = false; });
        io_.restart();
        io_.run_for(wait);
        return *quiet;
    }

    /// Reads to the end and returns the close code, 0 if there was none.
    unsigned close_code() {
        while (!error_ && receive() != nullptr) {
        }
        return error_ == websocket::error::closed ? ws_.reason().code : 0;
    }

    beast::error_code error() const { return error_; }
    beast::tcp_stream& socket() { return beast::get_lowest_layer(ws_); }
    const websocket::response_type& response() const { return response_; }
    asio::io_context& io() { return io_; }

  private:
    void limit(std::chrono::milliseconds wait = std::chrono::seconds(5)) {
        socket().expires_after(wait);
    }
    void run() {
        io_.restart();
        io_.run();
    }

    asio::io_context io_;
    websocket::stream<beast::tcp_stream> ws_;
    int port_;
    websocket::response_type response_;
    beast::flat_buffer buffer_;
    beast::error_code error_;
    protocol::MessageReader reader_{protocol::Sender::server};
};

/// The server under test; options that make waiting short.
class NetTest : public ::testing::Test {
  protected:
    NetTest() {
        options.listen = "127.0.0.1:0";
        options.hello_deadline = std::chrono::milliseconds(2000);
    }
    void start() {
        auto started = server::NetServer::start(options, host);
        ASSERT_TRUE(started.has_value()) << (started ? "" : started.error().message);
        net = std::move(*started);
    }
    int port() const { return net->port(); }

    /// Publishes keyframe n of both cascades.
    void publish(std::int64_t n, sea::FieldSet fields = {sea::Field::height}) {
        host.newest = n;
        for (int cascade = 0; cascade < 2; ++cascade)
            net->publish(host.keyframe(cascade, n, fields));
    }

    http::response<http::string_body> get(const std::string& target,
                                          http::verb verb = http::verb::get) {
        asio::io_context io;
        tcp::socket socket(io);
        socket.connect({asio::ip::address_v4::loopback(), static_cast<unsigned short>(port())});
        http::request<http::string_body> request(verb, target, 11);
        request.set(http::field::host, "127.0.0.1");
        request.set(http::field::connection, "close");
        http::write(socket, request);
        beast::flat_buffer buffer;
        http::response_parser<http::string_body> parser;
        parser.skip(verb == http::verb::head);
        beast::error_code error;
        http::read(socket, buffer, parser, error);
        EXPECT_FALSE(error) << error.message();
        return parser.release();
    }

    /// The value of a metric, -1 if it is not there.
    double metric(const std::string& name) {
        const std::string text = get("/metrics").body();
        const std::size_t at = text.find("\n" + name + " ");
        return at == std::string::npos ? -1 : std::stod(text.substr(at + name.size() + 2));
    }

    LogCapture log;
    SmallSea host;
    server::NetOptions options;
    std::unique_ptr<server::NetServer> net;
};

} // namespace seaway::tests
