// SPDX-License-Identifier: Apache-2.0
// EncodeWorker: the thread that owns the Encoder. Streamed keyframes go before fetched ones, also in
// the middle of a fetch: a large one is encoded slice by slice. The lines are bounded: what does not
// fit is refused to its owner, who counts it.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

#include "server/publish/encoder.h"

namespace seaway::server {

class EncodeWorker {
  public:
    /// Encodes one keyframe a call; true: that was the last.
    using Job = std::function<bool(Encoder&)>;

    /// Keyframes that wait to be streamed: two of each of 8 cascades at three qualities. A server that
    /// is further behind than that leaves keyframes out.
    static constexpr std::size_t streamed_waiting_max = 48;
    /// Parts of fetches, and starts of subscriptions, that wait: there is room for as many as all
    /// sessions may have in flight. How much they hold is bounded by who makes them.
    static constexpr std::size_t fetches_waiting_max = 4096;
    static constexpr std::size_t starts_waiting_max = 4096;

    /// Keyframes that wait to be streamed, and what the encoder remembers, have their room in `memory`.
    explicit EncodeWorker(MemoryPtr memory = std::make_shared<Memory>());
    ~EncodeWorker();
    EncodeWorker(const EncodeWorker&) = delete;
    EncodeWorker& operator=(const EncodeWorker&) = delete;

    /// False: full, or stopped. Any thread. A streamed one holds `bytes` until it is encoded.
    [[nodiscard]] bool submit_streamed(Job job, std::size_t bytes = 0);
    [[nodiscard]] bool submit_fetched(Job job);
    [[nodiscard]] bool submit_start(Job job);

    /// Drops what waits and joins the thread. Idempotent; not from a job.
    void stop();

    /// With all that its jobs have been told. Any thread.
    EncoderCounters counters() const;

  private:
    struct Waiting {
        Job job;
        Room::Place place;
    };
    using Line = std::deque<Waiting>;

    bool submit(Line& line, std::size_t waiting_max, Job job, std::size_t bytes = 0);
    void run();
    /// The line whose turn it is, or null: streamed keyframes, then starts and fetches one by one.
    Line* next_line();

    const MemoryPtr memory_;
    mutable std::mutex mutex_;
    std::condition_variable wake_;
    bool stopping_ = false;
    Line streamed_;
    Line fetched_;
    Line starts_;
    bool starts_turn_ = true;
    Encoder
        encoder_; ///< of the thread alone but for its counters, and made before it, where what throws is heard
    std::thread thread_;
};

} // namespace seaway::server
