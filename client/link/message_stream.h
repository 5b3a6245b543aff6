// SPDX-License-Identifier: Apache-2.0
// MessageStream: whole binary messages to and from a server, whatever carries them. The WebSocket
// below is the one that programs use; tests can bring another.
#pragma once

#include <chrono>
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

/// All on the stream's own thread, or in work() of one that has none, one after the other.
struct MessageStreamEvents {
    /// The bytes are valid during the call.
    std::function<void(std::span<const std::uint8_t>)> on_message;
    /// About every 50 ms.
    std::function<void()> on_tick;
    /// The stream has ended; once, and last. One line.
    std::function<void(std::string reason)> on_closed;
    /// Of a stream without a thread: whether it is open now. Nothing comes before it, and nothing after an error.
    std::function<void(const Result<void>&)> on_opened;
};

class MessageStream {
  public:
    /// As end().
    virtual ~MessageStream() = default;

    /// Closes it and waits for its thread, a second at most for the peer. Idempotent; not from a callback.
    virtual void end() = 0;

    /// Messages are read from here on; once.
    virtual void start(MessageStreamEvents events) = 0;

    /// Queues a message. False if the peer takes nothing: more than `waiting_bytes_max` wait. Of a stream that has
    /// ended, or ends, it is lost: on_closed says why. Thread-safe.
    virtual bool send(protocol::Bytes message) = 0;

    /// Ends it; on_closed gets the reason. Thread-safe.
    virtual void close(std::string reason) = 0;

    /// Ends it without a goodbye, so that nothing waits for the peer. Thread-safe.
    virtual void drop() { end(); }

    /// Of a stream without a thread: does what there is to do, events and all, and where there is nothing waits for something
    /// until `until`. For one thread at a time; not from an event.
    virtual void work(std::chrono::steady_clock::time_point until) { (void)until; }
    /// Of a stream without a thread: readable when something has come for work(). -1: there is none as yet.
    virtual int descriptor() { return -1; }

    static constexpr std::size_t waiting_bytes_max = 4u * 1024 * 1024;
};

struct WebSocketOptions {
    double connect_timeout_s = 5;
    /// Certificates (PEM) to trust besides the system's; for a server with one of its own.
    std::string ca_file;
    std::string user_agent = "seaway-client/" SEAWAY_VERSION;
    std::stop_token stop{}; ///< connecting is given up soon after
    /// It makes no thread: work() does everything, connecting too.
    bool threadless = false;
};

/// Connects and shakes hands; blocks until that is done or has failed. A silent peer is found out
/// by WebSocket pings within 30 s. `threadless`: at once, on_opened says how it went; the name is looked up in work(), which waits
/// for the system to find it. Errors: cannot_connect; for_good where the server declines for a reason that stays.
Result<std::unique_ptr<MessageStream>> open_websocket(const Url& url,
                                                      const WebSocketOptions& options);

} // namespace seaway::client
