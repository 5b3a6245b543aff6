// SPDX-License-Identifier: Apache-2.0
#include "sockets/web_socket.h"

#include <algorithm>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <gtest/gtest.h>

#include "base/memory_file.h"
#include "sockets/frame_header.h"
#include "sockets/served_web_socket.h"
#include "sockets/upgrade.h"
#include "tests/sockets/pair.h"

namespace seaway::sockets {
namespace {

namespace asio = boost::asio;
namespace http = boost::beast::http;

WebSocketOptions options(const std::string& subprotocol) {
    return {.subprotocol = subprotocol,
            .program = "test/1",
            .handshake_patience = std::chrono::seconds(10),
            .idle_patience = std::chrono::seconds(10),
            .message_bytes_max = 1000,
            .kept_buffer_bytes = 16};
}

/// A request as Beast's parser would hand it over.
Upgrade upgrade_of(const std::string& request) {
    Upgrade upgrade{{http::verb::get, "/v1/stream", 11}};
    const std::string name = "\r\nSec-WebSocket-Key: ";
    const std::size_t key = request.find(name) + name.size();
    upgrade.request.set(http::field::host, "here");
    upgrade.request.set(http::field::upgrade, "websocket");
    upgrade.request.set(http::field::connection, "Upgrade");
    upgrade.request.set(http::field::sec_websocket_version, "13");
    upgrade.request.set(http::field::sec_websocket_key,
                        request.substr(key, request.find("\r\n", key) - key));
    return upgrade;
}

/// A client that speaks "a.v1", and the other end, which reads its request first.
class WebSocketTest : public ::testing::Test {
  protected:
    WebSocketTest() : client(std::move(*pair.ends[0]), options("a.v1")) {
        client.shake_hands("here", "/v1/stream", [this](Result<void> done) { shaken = done; });
        asio::async_read_until(*pair.ends[1], asio::dynamic_buffer(request), "\r\n\r\n",
                               [](error_code, std::size_t) {});
        while (request.find("\r\n\r\n") == std::string::npos && pair.io.run_one() > 0)
            continue;
    }
    void answer(const std::string& text) {
        asio::async_write(*pair.ends[1], asio::buffer(text), [](error_code, std::size_t) {});
        while (!shaken && pair.io.run_one() > 0)
            continue;
    }
    ServedWebSocket& accept(const std::string& subprotocol) {
        server.emplace(std::move(*pair.ends[1]), options(subprotocol));
        server->accept(upgrade_of(request), [this](Result<void> done) { accepted = done; });
        while (!(shaken && accepted) && pair.io.run_one() > 0)
            continue;
        return *server;
    }

    Pair pair;
    WebSocket client;
    std::optional<ServedWebSocket> server;
    std::string request;
    std::optional<Result<void>> shaken, accepted;
};

TEST_F(WebSocketTest, a_server_that_declines_is_told_from_one_that_is_none) {
    answer("HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n");
    ASSERT_TRUE(shaken && !*shaken);
    EXPECT_EQ(shaken->error().message, "the server answers HTTP 404 at /v1/stream");
}

// A server that is too busy, or wants a token, says so in a line; a terminal is shown plain characters.
TEST_F(WebSocketTest, a_server_that_declines_says_why_in_the_first_line_of_its_page) {
    const std::string body = "too many sessions,\x1b[2J try again\nsecond line\n";
    answer("HTTP/1.1 503 Service Unavailable\r\nContent-Length: " + std::to_string(body.size()) +
           "\r\n\r\n" + body);
    ASSERT_TRUE(shaken && !*shaken);
    EXPECT_EQ(shaken->error().message, "the server answers HTTP 503 at /v1/stream: too many "
                                       "sessions,?[2J try again");
}

TEST_F(WebSocketTest, a_server_that_declines_for_a_while_says_when_to_come_again) {
    answer("HTTP/1.1 503 Service Unavailable\r\nRetry-After: 7\r\nContent-Length: 0\r\n\r\n");
    ASSERT_TRUE(shaken && !*shaken);
    EXPECT_EQ(shaken->error().retry_after_ms, 7000u);
}

TEST_F(WebSocketTest, a_time_to_come_again_that_is_no_number_of_seconds_is_none) {
    answer("HTTP/1.1 503 Service Unavailable\r\nRetry-After: Fri, 31 Dec 1999 23:59:59 GMT\r\n"
           "Content-Length: 0\r\n\r\n");
    ASSERT_TRUE(shaken && !*shaken);
    EXPECT_EQ(shaken->error().retry_after_ms, 0u);
}

TEST_F(WebSocketTest, a_time_to_come_again_beyond_all_numbers_is_the_largest) {
    answer("HTTP/1.1 503 Service Unavailable\r\nRetry-After: 99999999999\r\n"
           "Content-Length: 0\r\n\r\n");
    ASSERT_TRUE(shaken && !*shaken);
    EXPECT_EQ(shaken->error().retry_after_ms, 4'294'967'000u);
}

TEST_F(WebSocketTest, what_speaks_no_http_is_no_server) {
    answer("220 mail.example.org ESMTP\r\n\r\n");
    ASSERT_TRUE(shaken && !*shaken);
    EXPECT_EQ(shaken->error().message.find("this is no WebSocket server ("), 0u);
}

TEST_F(WebSocketTest, a_server_of_another_subprotocol_is_left) {
    accept("b.v1");
    EXPECT_NE(request.find("Sec-WebSocket-Protocol: a.v1"), std::string::npos) << request;
    ASSERT_TRUE(shaken && !*shaken);
    EXPECT_EQ(shaken->error().message, "the server does not speak a.v1");
}

TEST_F(WebSocketTest, messages_go_both_ways_and_the_end_has_its_code_and_reason) {
    ServedWebSocket& far = accept("a.v1");
    ASSERT_TRUE(shaken && *shaken && *accepted);
    const std::vector<std::uint8_t> there(500, 7), back{1, 2, 3};
    std::vector<std::vector<std::uint8_t>> received;
    const auto keep = [&](const Result<WebSocket::Message>& message) {
        if (message)
            received.emplace_back(message->bytes.begin(), message->bytes.end());
    };
    far.read(keep);
    client.read(keep);
    client.write(there, [&](const Result<void>& sent) { EXPECT_TRUE(sent); });
    while (received.empty() && pair.io.run_one() > 0)
        continue;
    const std::vector<std::span<const std::uint8_t>> one{back};
    EXPECT_TRUE(far.begin(one));
    while (received.size() < 2 && pair.io.run_one() > 0)
        continue;
    ASSERT_EQ(received.size(), 2u);
    EXPECT_EQ(received[0], there);
    EXPECT_EQ(received[1], back);

    std::optional<Error> end, far_end;
    client.read([&](const Result<WebSocket::Message>& message) { end = message.error(); });
    far.read([&](const Result<WebSocket::Message>& message) { far_end = message.error(); });
    far.close({4001, std::string(200, 'x')});
    while (!far_end && pair.io.run_one() > 0)
        continue;
    bool left = false;
    far.leave([&] { left = true; });
    while (!(end && left) && pair.io.run_one() > 0)
        continue;
    EXPECT_TRUE(far_end->is(WebSocketEnd::closed)) << far_end->message;
    EXPECT_TRUE(end->is(WebSocketEnd::closed)) << end->message;
    EXPECT_EQ(client.peer_close().code, 4001u);
    EXPECT_EQ(client.peer_close().reason, std::string(123, 'x'))
        << "a closing frame holds 125 bytes";
}

// Lengths at which a frame's header changes, RFC 6455, 5.2. The client's frames are Beast's.
TEST_F(WebSocketTest, messages_of_one_write_come_one_by_one_in_order_whatever_their_lengths) {
    ServedWebSocket& far = accept("a.v1");
    std::vector<std::vector<std::uint8_t>> messages;
    for (const std::size_t length : {1, 125, 126, 127, 999, 0, 1000})
        messages.emplace_back(length, static_cast<std::uint8_t>(messages.size() + 1));
    const std::vector<std::span<const std::uint8_t>> spans(messages.begin(), messages.end());
    std::vector<std::vector<std::uint8_t>> received;
    const std::function<void(const Result<WebSocket::Message>&)> keep =
        [&](const Result<WebSocket::Message>& message) {
            ASSERT_TRUE(message) << message.error().message;
            EXPECT_TRUE(message->binary);
            received.emplace_back(message->bytes.begin(), message->bytes.end());
            client.read(keep);
        };
    client.read(keep);
    int written = 0;
    if (far.begin(spans))
        ++written;
    else
        finish(far, [&] { ++written; });
    while ((received.size() < messages.size() || written == 0) && pair.io.run_one() > 0)
        continue;
    EXPECT_EQ(received, messages);
    EXPECT_EQ(written, 1);
}

// Naive: a ping, which the library sends by itself, goes into the middle of a message that is half written.
TEST_F(WebSocketTest, a_ping_waits_for_the_end_of_what_is_being_written) {
    WebSocketOptions impatient = options("a.v1");
    impatient.idle_patience = std::chrono::seconds(2); // a ping after one of silence
    server.emplace(std::move(*pair.ends[1]), impatient);
    server->accept(upgrade_of(request), [this](Result<void> done) { accepted = done; });
    while (!(shaken && accepted) && pair.io.run_one() > 0)
        continue;
    server->read([](const Result<WebSocket::Message>&) {});
    const std::vector<std::uint8_t> message(1000, 'm');
    const std::vector<std::span<const std::uint8_t>> spans(20'000,
                                                           message); // 20 MB: no socket takes it
    bool written = false;
    ASSERT_FALSE(server->begin(spans));
    finish(*server, [&] { written = true; });
    pair.io.restart();
    pair.io.run_for(std::chrono::milliseconds(1300)); // nobody reads
    EXPECT_FALSE(written);
    std::size_t received = 0;
    bool broken = false;
    const std::function<void(const Result<WebSocket::Message>&)> count =
        [&](const Result<WebSocket::Message>& next) {
            broken = !next || !std::ranges::equal(next->bytes, message);
            received += broken ? 0 : 1;
            if (!broken && received < spans.size())
                client.read(count);
        };
    client.read(count);
    pair.io.restart();
    while (!broken && !(written && received == spans.size()) && pair.io.run_one() > 0)
        continue;
    EXPECT_FALSE(broken);
    EXPECT_EQ(received, spans.size());
    EXPECT_TRUE(written);
}

// Nobody reads until the system takes no more, which is somewhere in a message; written, and sent from a file.
TEST_F(WebSocketTest, what_the_system_takes_a_part_of_comes_whole) {
    ServedWebSocket& far = accept("a.v1");
    std::vector<std::vector<std::uint8_t>> messages;
    std::vector<std::uint8_t> framed{1, 2, 3}; // something else comes before
    for (std::size_t length = 967; length < 999; ++length) {
        messages.emplace_back(length);
        for (std::size_t i = 0; i < length; ++i)
            messages.back()[i] = static_cast<std::uint8_t>(i * 31 + length);
        const FrameHeader header(length);
        framed.insert(framed.end(), header.bytes.begin(), header.bytes.begin() + header.size);
        framed.insert(framed.end(), messages.back().begin(), messages.back().end());
    }
    const std::shared_ptr<const MemoryFile> file = MemoryFile::of(framed);
    ASSERT_TRUE(file);
    const std::vector<std::span<const std::uint8_t>> spans(messages.begin(), messages.end());
    for (const FileRange& same : {FileRange{}, FileRange{file->handle(), 3, framed.size() - 3}}) {
        std::size_t begun = 1;
        while (far.begin(spans, same))
            ++begun;
        EXPECT_GT(begun, 1u);
        bool finished = false;
        finish(far, [&] { finished = true; });
        std::size_t received = 0;
        bool broken = false;
        const std::function<void(const Result<WebSocket::Message>&)> count =
            [&](const Result<WebSocket::Message>& next) {
                broken =
                    !next || !std::ranges::equal(next->bytes, messages[received % messages.size()]);
                received += broken ? 0 : 1;
                if (!broken && received < begun * messages.size())
                    client.read(count);
            };
        client.read(count);
        while (!broken && !(finished && received == begun * messages.size()) &&
               pair.io.run_one() > 0)
            continue;
        EXPECT_FALSE(broken) << "message " << received;
        EXPECT_TRUE(finished);
    }
}

TEST_F(WebSocketTest, a_message_above_the_limit_is_not_understood) {
    ServedWebSocket& far = accept("a.v1");
    std::optional<Error> end;
    far.read([&](const Result<WebSocket::Message>& message) { end = message.error(); });
    client.read([](const Result<WebSocket::Message>&) {}); // answers the closing frame
    const std::vector<std::uint8_t> large(1001);
    client.write(large, [](const Result<void>&) {});
    while (!end && pair.io.run_one() > 0)
        continue;
    ASSERT_TRUE(end);
    EXPECT_TRUE(end->is(WebSocketEnd::not_understood)) << end->message;
}

TEST_F(WebSocketTest, a_client_says_which_program_it_is_and_what_it_wants) {
    EXPECT_NE(request.find("User-Agent: test/1\r\n"), std::string::npos) << request;
    EXPECT_NE(request.find("GET /v1/stream HTTP/1.1\r\n"), std::string::npos) << request;
    EXPECT_NE(request.find("Host: here\r\n"), std::string::npos) << request;
}

// Naive: what ends TCP may be lost on its way, and until then, for as long as one is patient with silence, the connection stands.
TEST_F(WebSocketTest, a_peer_that_has_said_its_last_word_is_not_waited_for) {
    ServedWebSocket& far = accept("a.v1");
    ASSERT_TRUE(shaken && *shaken && *accepted);
    const auto began = std::chrono::steady_clock::now();
    std::optional<Error> end;
    client.read([&](const Result<WebSocket::Message>& message) { end = message.error(); });
    far.close({1001, "moving"});
    while (!end && pair.io.run_one() > 0)
        continue;
    ASSERT_TRUE(end);
    EXPECT_EQ(client.peer_close().code, 1001u);
    EXPECT_EQ(client.peer_close().reason, "moving");
    // Of silence it would have been ten seconds.
    EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(8));
}

// One kind of patience is for the handshake, the other for a peer that falls silent after it. The one that
// does not count is longer than the test waits.
TEST(WebSocketPatience, of_the_handshake_and_of_silence_are_two) {
    constexpr auto short_one = std::chrono::milliseconds(100);
    constexpr auto long_one = std::chrono::hours(1);
    {
        Pair pair;
        WebSocketOptions hasty = options("a.v1");
        hasty.handshake_patience = short_one;
        hasty.idle_patience = long_one;
        WebSocket client(std::move(*pair.ends[0]), hasty);
        std::optional<Result<void>> shaken;
        client.shake_hands("here", "/", [&](Result<void> done) { shaken = done; });
        pair.run(); // nobody answers
        ASSERT_TRUE(shaken);
        EXPECT_FALSE(*shaken);
    }
    for (const bool silent : {true, false}) {
        Pair pair;
        WebSocketOptions calm = options("a.v1");
        calm.handshake_patience = silent ? long_one : short_one;
        calm.idle_patience = silent ? short_one : long_one;
        WebSocket client(std::move(*pair.ends[0]), calm);
        std::string request;
        std::optional<Result<void>> shaken;
        client.shake_hands("here", "/", [&](Result<void> done) { shaken = done; });
        asio::async_read_until(*pair.ends[1], asio::dynamic_buffer(request), "\r\n\r\n",
                               [](error_code, std::size_t) {});
        while (request.find("\r\n\r\n") == std::string::npos && pair.io.run_one() > 0)
            continue;
        ServedWebSocket far(std::move(*pair.ends[1]), options("a.v1"));
        far.accept(upgrade_of(request), [](const Result<void>&) {});
        while (!shaken && pair.io.run_one() > 0)
            continue;
        if (!*shaken)
            continue; // the machine was busy for longer than the short patience: nothing is learnt
        std::optional<Error> end;
        client.read([&](const Result<WebSocket::Message>& message) { end = message.error(); });
        pair.io.restart();
        const auto until = std::chrono::steady_clock::now() +
                           (silent ? std::chrono::seconds(20) : std::chrono::milliseconds(300));
        while (!end && pair.io.run_one_until(until) > 0)
            continue;
        EXPECT_EQ(end.has_value(), silent);
        if (end) {
            EXPECT_TRUE(end->is(WebSocketEnd::silent)) << end->message;
        }
    }
}

} // namespace
} // namespace seaway::sockets
