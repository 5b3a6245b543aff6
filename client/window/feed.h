// SPDX-License-Identifier: Apache-2.0
// Feed: a client that is waited for. A thread of its own connects and subscribes to what is drawn, with the waits of
// link/reconnect.h until that is had once; from then on the client goes on by itself (client.h).
//
// Thread-safe; nothing but the destructor blocks, until its thread has ended: a moment. Of a host whose name is still looked
// for, or of a server that does not answer a subscription, it stays behind after a second and ends by itself, later.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>

#include "client/client.h"
#include "client/tile_limits.h"

namespace seaway::client {

enum class Link { connecting, live, waiting, stopped };

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
    explicit Feed(const ConnectOptions& options, const TileLimits& limits = {});
    ~Feed();
    Feed(const Feed&) = delete;
    Feed& operator=(const Feed&) = delete;

    /// Null before the first connection.
    std::shared_ptr<Client> client() const;
    FeedStatus status() const;

  private:
    /// Outlives the feed where somebody has its client still.
    struct Counts {
        std::atomic<std::uint64_t> keyframes = 0, bytes = 0;
    };
    /// Outlives the feed where its thread does.
    struct State {
        ConnectOptions options;
        TileLimits limits;
        std::mutex mutex;
        std::condition_variable changed;
        bool ended = false; ///< the thread
        FeedStatus status;
        std::chrono::steady_clock::time_point next;
        std::shared_ptr<Counts> counts = std::make_shared<Counts>(); ///< by the client's events
        std::shared_ptr<Client> client;
    };
    static void run(const std::shared_ptr<State>& state);
    static Result<std::shared_ptr<Client>> first_connection(const std::shared_ptr<State>& state);

    std::stop_source leaving_;
    std::shared_ptr<State> state_;
    std::thread thread_;
};

} // namespace seaway::client
