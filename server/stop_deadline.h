// SPDX-License-Identifier: Apache-2.0
// StopDeadline: a process that was asked to stop ends, also where a device or a thread hangs and nothing would. Sees
// SIGTERM and SIGINT while they are blocked and nobody has taken them yet, as in a start-up that hangs.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace seaway::server {

class StopDeadline {
  public:
    /// From the stop on the process has `limit`; then the line of `last_words` goes to stderr, if that takes it
    /// at once, and the process ends by _Exit(exit_code). Make it after the signals were blocked. What hangs may
    /// hold any lock: last_words must take none, as that of a log.
    StopDeadline(std::chrono::milliseconds limit, int exit_code,
                 std::function<std::string()> last_words);
    /// All has ended in time.
    ~StopDeadline();
    StopDeadline(const StopDeadline&) = delete;
    StopDeadline& operator=(const StopDeadline&) = delete;

    /// The signal has been taken, stopping begins.
    void begins() { stopping_ = true; }

  private:
    void watch();
    static bool signal_waits();

    const std::chrono::milliseconds limit_;
    const int exit_code_;
    const std::function<std::string()> last_words_;
    std::atomic<bool> stopping_ = false;
    std::mutex mutex_;
    std::condition_variable changed_;
    bool ended_ = false;
    std::thread thread_;
};

} // namespace seaway::server
