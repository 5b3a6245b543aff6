// SPDX-License-Identifier: Apache-2.0
// Feed: a client that is kept connected. A thread of its own connects, subscribes to what is drawn, and does so again
// when the connection has ended, with the waits of link/reconnect.h. The client that was connected last stays: what it
// holds can still be shown, and its clock goes on.
//
// Thread-safe; nothing but the destructor blocks, a third of a second: an attempt that still waits for a silent host then
// ends by itself, later.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "client/client.h"
#include "client/tile_limits.h"

namespace seaway::client {

enum class Link { connecting, live, waiting };

struct FeedStatus {
    Link link = Link::connecting;
    std::string reason;          ///< why the last attempt or connection ended; empty: none has
    double next_s = 0;           ///< waiting: until the next attempt
    int connections = 0;         ///< so far
    Grant grant;                 ///< of the last subscription
    std::uint64_t keyframes = 0; ///< that have come, of all cascades
    std::uint64_t bytes = 0;     ///< of their maps, as they are held
};

class Feed {
  public:
    static constexpr int credit = 2;

    explicit Feed(const ConnectOptions& options, const TileLimits& limits = {});
    ~Feed();
    Feed(const Feed&) = delete;
    Feed& operator=(const Feed&) = delete;

    /// Null before the first connection.
    std::shared_ptr<Client> client() const;
    FeedStatus status() const;

  private:
    /// Outlives the feed where its thread does.
    struct State {
        ConnectOptions options;
        TileLimits limits;
        std::mutex mutex;
        std::condition_variable changed;
        bool stop = false, ended = false;
        FeedStatus status;
        std::chrono::steady_clock::time_point next;
        std::atomic<std::uint64_t> keyframes = 0, bytes = 0; ///< the client's events count
        std::shared_ptr<Client> client;
    };
    static void run(const std::shared_ptr<State>& state);
    static Error one_connection(const std::shared_ptr<State>& state);

    std::shared_ptr<State> state_;
};

} // namespace seaway::client
