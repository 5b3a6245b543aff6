// SPDX-License-Identifier: Apache-2.0
// WebSocket: binary messages over a Socket, the client's end. Beast's templates are compiled in web_socket.cpp and
// in served_web_socket.cpp, which is the server's end, and nowhere else.
//
// Of one thread, that of the socket's executor, which also runs the callbacks. At most one read() and
// one write() are under way; whoever owns the WebSocket keeps it until each has called back, and
// callbacks that own the owner see to that.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>

#include "base/result.h"
#include "sockets/socket.h"

namespace seaway::sockets {

/// Kinds of errors.
enum class WebSocketEnd {
    closed, ///< the peer said so
    silent, ///< nothing was heard of the peer for too long
    unread, ///< of a ServedWebSocket: pings, or answers to the peer's, lie there for too long
    not_understood, ///< what came is no WebSocket, or a message too large
    broken,         ///< the connection is gone
    declined,       ///< of shake_hands(): by a server that would decline again
};

struct WebSocketOptions {
    std::string subprotocol;
    /// "Server" or "User-Agent" of the handshake.
    std::string program;
    std::chrono::milliseconds handshake_patience{};
    /// A peer that says nothing is pinged at half of it and given up at the end, and so is one that takes no pings or pongs.
    std::chrono::milliseconds idle_patience{};
    std::size_t message_bytes_max = 0;
    /// The read buffer, where it has become larger, is given back before the next message.
    std::size_t kept_buffer_bytes = std::numeric_limits<std::size_t>::max();
    /// Of a ServedWebSocket: called before more is received, with the bytes that came since and received_frame_bytes for each frame of
    /// any kind; says how long nothing is received from this peer. Empty: what it says costs it nothing.
    std::function<std::chrono::milliseconds(std::size_t)> charge = {};
    /// Of a ServedWebSocket: runs on its thread, in a later handler and behind those of others, what is left of an arrival of many
    /// messages. May throw std::bad_alloc, which ends the connection. Empty: behind what is ready then.
    std::function<void(std::function<void()>)> later = {};
};

/// What a frame costs beside its bytes: empty ones have to be looked at, and messages answered. 131 000 in a second are an address's
/// share of requests, unless that was changed (docs/decisions/0031-the-door.md).
inline constexpr std::size_t received_frame_bytes = 1024;

class WebSocket {
  public:
    using Done = std::function<void(Result<void>)>;
    struct Message {
        std::span<const std::uint8_t> bytes; ///< until the next read()
        bool binary = true;
        /// Of a ServedWebSocket: whoever asks for the next one is given it, or an error, before this handler of his ends.
        bool more = false;
    };
    struct Close {
        unsigned code = 0;
        std::string reason;
    };

    WebSocket(Socket socket, const WebSocketOptions& options);
    ~WebSocket();
    WebSocket(WebSocket&&) noexcept;
    WebSocket& operator=(WebSocket&&) = delete;

    /// Asks a server; errors are whole lines: that it is none, that it declines and with which
    /// status, that it does not speak the subprotocol. One that declines may say when to come again (retry_after_ms).
    void shake_hands(const std::string& host, const std::string& path, Done done);

    void read(std::function<void(Result<Message>)> done);
    /// One binary message in one frame; `bytes` stay until `done`.
    void write(std::span<const std::uint8_t> bytes, Done done);
    /// Sends the closing frame and waits for the peer's. Reasons are cut at what a frame holds.
    void close(const Close& why, std::function<void()> done);

    /// What the peer's closing frame said; code 0: none came, or one without a code. Where TCP does not end within a second of it, read() ends as `broken`.
    Close peer_close() const;
    Socket& socket();

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace seaway::sockets
