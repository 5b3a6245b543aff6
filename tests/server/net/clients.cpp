// SPDX-License-Identifier: Apache-2.0
#include "tests/server/net/clients.h"

#include <algorithm>
#include <array>
#include <cstdlib>

#include <gtest/gtest.h>
#include <sys/socket.h>

#include "tests/server/net/tcp.h"

namespace seaway::tests {

/// Of a frame (RFC 6455, section 5.2).
enum class Opcode : unsigned { binary = 2, close = 8, ping = 9, pong = 10 };

namespace {

using Clock = Tcp::Clock;
using std::chrono::milliseconds;

/// Of a RawPeer, for which only ctest's limit holds.
constexpr milliseconds for_ever = std::chrono::hours(1);

std::span<const std::uint8_t> bytes_of(std::string_view text) {
    return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// The frame of a client (RFC 6455, section 5.2), whole and masked with `key`.
protocol::Bytes frame_of(Opcode opcode, std::span<const std::uint8_t> payload,
                         std::array<std::uint8_t, 4> key) {
    protocol::Bytes bytes{static_cast<std::uint8_t>(0x80u | static_cast<unsigned>(opcode))};
    const int length_bytes = payload.size() < 126 ? 0 : payload.size() < 65536 ? 2 : 8;
    const std::size_t first = length_bytes == 0 ? payload.size() : length_bytes == 2 ? 126 : 127;
    bytes.push_back(static_cast<std::uint8_t>(0x80 | first));
    for (int shift = 8 * (length_bytes - 1); shift >= 0; shift -= 8)
        bytes.push_back(static_cast<std::uint8_t>(payload.size() >> shift));
    bytes.insert(bytes.end(), key.begin(), key.end());
    for (std::size_t i = 0; i < payload.size(); ++i)
        bytes.push_back(payload[i] ^ key[i % 4]);
    return bytes;
}

std::string upgrade_request(const std::string& subprotocol, const std::string& fields = {}) {
    return "GET /v1/stream HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: Upgrade\r\n"
           "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
           "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: " +
           subprotocol + "\r\n" + fields + "\r\n";
}
/// What RFC 6455 (section 1.3) says that key must be answered with.
constexpr const char* accepted_key = "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=";

/// Status and fields of a header, the empty line at its end included.
HttpAnswer parse_header(const std::string& header) {
    HttpAnswer answer;
    EXPECT_TRUE(header.starts_with("HTTP/1.1 ")) << header;
    std::size_t line = header.find("\r\n");
    if (line == std::string::npos || line < 12)
        return answer;
    answer.status = std::atoi(header.c_str() + 9);
    for (line += 2; line < header.size();) {
        const std::size_t end = header.find("\r\n", line);
        const std::size_t colon = header.find(": ", line);
        if (end == line || colon > end || end == std::string::npos)
            break;
        answer.fields[header.substr(line, colon - line)] =
            header.substr(colon + 2, end - colon - 2);
        line = end + 2;
    }
    return answer;
}

} // namespace

// ---- Client ------------------------------------------------------------------------------------

struct Client::Impl {
    Impl(int to, std::string by, milliseconds longest)
        : port(to), from(std::move(by)), patience(longest) {}

    struct Frame {
        Opcode opcode{};
        protocol::Bytes payload;
    };

    /// Waits until `count` bytes are there.
    bool have(std::size_t count, Clock::time_point end) {
        while (!error && received.size() < count)
            error = tcp.read(received, end);
        return !error;
    }

    /// The next frame, in `frame`; false with `error` set.
    bool read_frame(Clock::time_point end) {
        const auto at = [&](std::size_t i) { return static_cast<std::uint8_t>(received[i]); };
        if (!have(2, end))
            return false;
        const std::size_t first = at(1);
        EXPECT_LT(first, 128u) << "frames of a server are not masked";
        const std::size_t length_bytes = first < 126 ? 0 : first == 126 ? 2 : 8;
        if (!have(2 + length_bytes, end))
            return false;
        std::size_t size = length_bytes == 0 ? first : 0;
        for (std::size_t i = 0; i < length_bytes; ++i)
            size = size << 8 | at(2 + i);
        EXPECT_LE(size, 1u << 20);
        const std::size_t begin = 2 + length_bytes;
        if (size > 1u << 20 || !have(begin + size, end)) {
            error = error ? error : std::make_error_code(std::errc::message_size);
            return false;
        }
        EXPECT_EQ(at(0) & 0xF0, 0x80) << "a message is one frame, without extensions";
        frame.opcode = static_cast<Opcode>(at(0) & 0xF);
        const auto payload = bytes_of(received).subspan(begin, size);
        frame.payload.assign(payload.begin(), payload.end());
        received.erase(0, begin + size);
        return true;
    }

    /// The next message, in `frame`. Pings are answered and a close is, too.
    bool read_message(Clock::time_point end) {
        while (read_frame(end)) {
            if (frame.opcode == Opcode::binary)
                return true;
            if (frame.opcode == Opcode::ping)
                write(Opcode::pong, frame.payload);
            if (frame.opcode == Opcode::close) {
                if (frame.payload.size() >= 2)
                    close_code = frame.payload[0] * 256u + frame.payload[1];
                write(Opcode::close, frame.payload);
                for (std::string last; !tcp.read(last, Clock::now() + patience);)
                    continue;
                error = std::make_error_code(std::errc::no_message_available);
            }
        }
        return false;
    }

    std::error_code write(Opcode opcode, std::span<const std::uint8_t> payload) {
        return tcp.write(frame_of(opcode, payload, {0x37, 0xfa, 0x21, 0x3d}), patience);
    }

    Tcp tcp;
    int port;
    std::string from;
    milliseconds patience;
    HttpAnswer response;
    std::string received; ///< and not yet taken apart
    Frame frame;
    unsigned close_code = 0;
    std::error_code error;
    protocol::MessageReader reader{protocol::Sender::server};
};

Client::Client(int port, std::string from, milliseconds patience)
    : impl_(std::make_unique<Impl>(port, std::move(from), patience)) {}
Client::~Client() = default;

std::error_code Client::connect(const std::string& subprotocol, const std::string& fields) {
    Impl& c = *impl_;
    if (const std::error_code error = c.tcp.connect(c.port, c.from))
        return error;
    if (const std::error_code error =
            c.tcp.write(bytes_of(upgrade_request(subprotocol, fields)), c.patience))
        return error;
    const Clock::time_point end = Clock::now() + c.patience;
    std::size_t header = std::string::npos;
    while ((header = c.received.find("\r\n\r\n")) == std::string::npos)
        if (const std::error_code error = c.tcp.read(c.received, end))
            return error;
    c.response = parse_header(c.received.substr(0, header + 4));
    c.received.erase(0, header + 4);
    if (c.response.status != 101)
        return std::make_error_code(std::errc::connection_refused);
    EXPECT_EQ(c.response.fields["Sec-WebSocket-Accept"], accepted_key);
    return {};
}

std::error_code Client::send(const protocol::Bytes& bytes) {
    return impl_->write(Opcode::binary, bytes);
}

const wire::Message* Client::receive() {
    return receive(impl_->patience);
}

const wire::Message* Client::receive(milliseconds wait) {
    Impl& c = *impl_;
    if (c.error == std::errc::timed_out)
        c.error = {};
    if (c.error || !c.read_message(Clock::now() + wait))
        return nullptr;
    auto message = c.reader.read(c.frame.payload);
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

bool Client::stays_quiet_for(milliseconds wait) {
    return !impl_->error && !impl_->read_message(Clock::now() + wait) &&
           impl_->error == std::errc::timed_out;
}

unsigned Client::close_code() {
    while (receive() != nullptr)
        continue;
    return impl_->close_code;
}

std::error_code Client::error() const {
    return impl_->error;
}
int Client::status() const {
    return impl_->response.status;
}
std::string Client::field(const std::string& name) const {
    return impl_->response.fields[name];
}
std::string Client::subprotocol() const {
    return field("Sec-WebSocket-Protocol");
}

// ---- RawPeer -----------------------------------------------------------------------------------

struct RawPeer::Impl {
    Tcp tcp;
    std::error_code end;
    std::size_t bytes_read = 0;

    /// Appends what is there; `end` is set when there will be no more.
    void read(std::string& to) {
        const std::size_t before = to.size();
        end = tcp.read(to, Clock::now() + for_ever);
        bytes_read += to.size() - before;
    }
};

RawPeer::RawPeer(int port, int receive_buffer_bytes, const std::string& from)
    : impl_(std::make_unique<Impl>()) {
    if (receive_buffer_bytes > 0)
        impl_->tcp.set(SO_RCVBUF, &receive_buffer_bytes, sizeof receive_buffer_bytes);
    EXPECT_FALSE(impl_->tcp.connect(port, from));
}
RawPeer::~RawPeer() = default;

void RawPeer::say(std::span<const std::uint8_t> bytes) {
    // The server may have closed already, which is no failure.
    static_cast<void>(impl_->tcp.write(bytes, for_ever));
}

void RawPeer::say(std::string_view text) {
    say(bytes_of(text));
}

void RawPeer::upgrade() {
    say(upgrade_request("seaway.v1"));
    const std::string answer = header();
    EXPECT_NE(answer.find("101"), std::string::npos) << answer;
}

void RawPeer::frame(const protocol::Bytes& payload, std::size_t bytes_sent) {
    const protocol::Bytes bytes = frame_of(Opcode::binary, payload, {});
    say(std::span(bytes).first(std::min(bytes_sent, bytes.size())));
}

void RawPeer::reset() {
    const linger at_once{1, 0};
    impl_->tcp.set(SO_LINGER, &at_once, sizeof at_once);
    impl_->tcp.close();
}

std::string RawPeer::header() {
    std::string answer;
    while (answer.find("\r\n\r\n") == std::string::npos && !impl_->end)
        impl_->read(answer);
    EXPECT_FALSE(impl_->end) << impl_->end.message() << " after \"" << answer << '"';
    return answer;
}

bool RawPeer::reads(std::size_t bytes) {
    std::string some;
    while (some.size() < bytes && !impl_->end)
        impl_->read(some);
    return !impl_->end;
}

std::string RawPeer::rest() {
    std::string all;
    while (!impl_->end)
        impl_->read(all);
    return all;
}

bool RawPeer::closed_by_server() {
    rest();
    return true;
}

bool RawPeer::ended_in_order() const {
    return impl_->end == std::errc::no_message_available;
}

std::size_t RawPeer::bytes_read() const {
    return impl_->bytes_read;
}

// ---- HTTP --------------------------------------------------------------------------------------

HttpAnswer ask_http(int port, const std::string& target, const std::string& method,
                    const std::string& authorization, const std::string& from) {
    RawPeer peer(port, 0, from);
    peer.say(method + " " + target + " HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n" +
             (authorization.empty() ? "" : "Authorization: " + authorization + "\r\n") + "\r\n");
    const std::string all = peer.rest();
    EXPECT_TRUE(peer.ended_in_order());
    const std::size_t body = std::min(all.find("\r\n\r\n"), all.size() - 4) + 4;
    HttpAnswer answer = parse_header(all.substr(0, body));
    answer.body = all.substr(body);
    const std::size_t size = method == "HEAD" ? 0 : std::stoul(answer.fields["Content-Length"]);
    EXPECT_EQ(answer.body.size(), size) << target;
    return answer;
}

} // namespace seaway::tests
