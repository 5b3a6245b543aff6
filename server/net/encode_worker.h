// SPDX-License-Identifier: Apache-2.0
// EncodeWorker: the thread that owns the Encoder. Streamed keyframes go before fetched ones, and
// both lines are bounded: what does not fit is refused to its owner, who counts it.
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
    using Job = std::function<void(Encoder&)>;

    /// Keyframes that wait to be streamed: two of each cascade and quality in use.
    static constexpr std::size_t streamed_waiting_max = 32;
    /// Fetches that wait, of all sessions together.
    static constexpr std::size_t fetches_waiting_max = 64;

    EncodeWorker();
    ~EncodeWorker();
    EncodeWorker(const EncodeWorker&) = delete;
    EncodeWorker& operator=(const EncodeWorker&) = delete;

    /// False: full, or stopped. Any thread.
    [[nodiscard]] bool submit_streamed(Job job);
    [[nodiscard]] bool submit_fetched(Job job);

    /// Drops what waits and joins the thread. Idempotent; not from a job.
    void stop();

    EncoderCounters counters() const;

  private:
    bool submit(std::deque<Job>& line, std::size_t waiting_max, Job job);
    void run();

    mutable std::mutex mutex_;
    std::condition_variable wake_;
    bool stopping_ = false;
    std::deque<Job> streamed_;
    std::deque<Job> fetched_;
    EncoderCounters counters_;
    std::thread thread_;
};

} // namespace seaway::server
