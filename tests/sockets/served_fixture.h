// SPDX-License-Identifier: Apache-2.0
// A ServedWebSocket behind its handshake, and what its peer says and is told.
#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/http.hpp>
#include <gtest/gtest.h>

#include "sockets/upgrade.h"
#include "tests/sockets/client_frames.h"
#include "tests/sockets/pair.h"

namespace seaway::sockets {

/// The server's end behind its handshake, and a bare socket at the other.
class ServedWebSocketTest : public ::testing::Test {
  protected:
    ServedWebSocketTest() { accept(); }

    void accept(std::chrono::milliseconds patience = std::chrono::seconds(10),
                std::chrono::milliseconds handshake_patience = std::chrono::seconds(10)) {
        namespace http = boost::beast::http;
        Upgrade upgrade{{http::verb::get, "/", 11}};
        upgrade.request.set(http::field::host, "here");
        upgrade.request.set(http::field::upgrade, "websocket");
        upgrade.request.set(http::field::connection, "Upgrade");
        upgrade.request.set(http::field::sec_websocket_version, "13");
        upgrade.request.set(http::field::sec_websocket_key, "dGhlIHNhbXBsZSBub25jZQ==");
        server.reset();
        pair.emplace();
        server.emplace(std::move(*pair->ends[0]),
                       WebSocketOptions{.subprotocol = "a.v1",
                                        .program = "test/1",
                                        .handshake_patience = handshake_patience,
                                        .idle_patience = patience,
                                        .message_bytes_max = 100'000,
                                        .kept_buffer_bytes = 16,
                                        .later = later});
        bool accepted = false;
        server->accept(upgrade, [&](const Result<void>& done) { accepted = done.has_value(); });
        answer.clear();
        listen();
        run_until([&] { return accepted && answer.find("\r\n\r\n") != std::string::npos; });
        answer.erase(0, answer.find("\r\n\r\n") + 4);
    }
    ~ServedWebSocketTest() override { server.reset(); }

    template <class Condition>
    void run_until(Condition condition) {
        boost::asio::steady_timer deadline(pair->io, std::chrono::seconds(20));
        bool late = false;
        deadline.async_wait([&](error_code error) { late = !error; });
        pair->io.restart();
        while (!condition() && !late && pair->io.run_one() > 0)
            continue;
        EXPECT_FALSE(late);
        deadline.cancel();
        pair->io.poll();
    }
    /// Everything that the server says, for as long as it does.
    void listen() {
        pair->ends[1]->async_read_some(boost::asio::buffer(chunk),
                                       [this](error_code error, std::size_t bytes) {
                                           answer.append(chunk.data(), bytes);
                                           gone = static_cast<bool>(error);
                                           in_order = error == boost::asio::error::eof;
                                           if (!error && listens)
                                               listen();
                                       });
    }
    void say(const FrameBytes& bytes) {
        sent.push_back(bytes);
        boost::asio::async_write(*pair->ends[1], boost::asio::buffer(sent.back()),
                                 [](error_code, std::size_t) {});
    }
    void read_all() {
        server->read([this](const Result<ServedWebSocket::Message>& message) {
            if (!message) {
                end = message.error();
                return;
            }
            heard.emplace_back(message->bytes.begin(), message->bytes.end());
            if (!message->more)
                last_of_a_turn.push_back(heard.size());
            if (heard.size() < read_max)
                read_all();
        });
    }

    std::optional<Pair> pair;
    std::optional<ServedWebSocket> server;
    std::deque<FrameBytes> sent;
    std::array<char, 4096> chunk{};
    std::string answer;
    bool gone = false;
    bool listens = true;
    bool in_order = false;
    std::vector<FrameBytes> heard;
    std::vector<std::size_t> last_of_a_turn; ///< messages behind which none was promised at once
    std::function<void(std::function<void()>)> later;
    std::size_t read_max = 1'000'000;
    std::optional<Error> end;
};

} // namespace seaway::sockets
