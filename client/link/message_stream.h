// SPDX-License-Identifier: Apache-2.0
// MessageStream: whole binary messages to and from a server, whatever carries them. The WebSocket
// below is the one that programs use; tests can bring another.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <stop_token>
#include <string>

#include "base/result.h"
#include "client/link/url.h"
#include "protocol/messages.h"

namespace seaway::client {

/// All on the stream's own thread, one after the other.
struct MessageStreamEvents {
    /// The bytes are valid during the call.
    std::function<void(std::span<const std::uint8_t>)> on_message;
    /// About every 50 ms.
    std::function<void()> on_tick;
    /// The stream has ended; once, and last. One line.
    std::function<void(std::string reason)> on_closed;
};

class MessageStream {
  public:
    /// Closes it and waits for its thread, a second at most for the peer. Not from a callback.
    virtual ~MessageStream() = default;

    /// Messages are read from here on; once.
    virtual void start(MessageStreamEvents events) = 0;

    /// Queues a message. False if the peer takes nothing: more than `waiting_bytes_max` wait. Of a stream that has
    /// ended, or ends, it is lost: on_closed says why. Thread-safe.
    virtual bool send(protocol::Bytes message) = 0;

    /// Ends it; on_closed gets the reason. Thread-safe.
    virtual void close(std::string reason) = 0;

    static constexpr std::size_t waiting_bytes_max = 4u * 1024 * 1024;
};

struct WebSocketOptions {
    double connect_timeout_s = 5;
    /// Certificates (PEM) to trust besides the system's; for a server with one of its own.
    std::string ca_file;
    std::string user_agent = "seaway-client/" SEAWAY_VERSION;
    std::stop_token stop{}; ///< connecting is given up soon after
};

/// Connects and shakes hands; blocks until that is done or has failed. A silent peer is found out
/// by WebSocket pings within 30 s. Errors: cannot_connect; for_good where the server declines for a reason that stays.
Result<std::unique_ptr<MessageStream>> open_websocket(const Url& url,
                                                      const WebSocketOptions& options);

} // namespace seaway::client
