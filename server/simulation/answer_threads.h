// SPDX-License-Identifier: Apache-2.0
// AnswerThreads: threads that sample points of what is held and sum exact answers, slice by slice, so that
// neither waits for the thread that makes keyframes. Whose slice is next stands in Questions.
//
// turn() from any thread.
#pragma once

#include <chrono>
#include <deque>
#include <thread>
#include <vector>

#include "server/simulation/heartbeat.h"
#include "server/simulation/questions.h"

namespace seaway::server {

/// As many as there are `usable_processors()`, four at most: more points than they answer are more than a
/// network thread reads.
int answer_threads_default();
inline constexpr int answer_threads_max = 64;

class AnswerThreads {
  public:
    /// `questions` outlives them; they end when it is closed.
    explicit AnswerThreads(Questions& questions) : questions_(questions) {}
    ~AnswerThreads() { join(); }
    AnswerThreads(const AnswerThreads&) = delete;
    AnswerThreads& operator=(const AnswerThreads&) = delete;

    /// Throws std::system_error where the system gives no thread.
    void start(int threads);
    /// Waits for their end.
    void join();

    /// For how long the slice that has been under way for longest has lasted.
    Heartbeat::Clock::duration turn() const;

  private:
    void work(Heartbeat& heartbeat);

    Questions& questions_;
    std::deque<Heartbeat> heartbeats_; ///< one a thread
    std::vector<std::thread> threads_;
};

} // namespace seaway::server
