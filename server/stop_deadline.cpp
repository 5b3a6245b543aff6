// SPDX-License-Identifier: Apache-2.0
#include "server/stop_deadline.h"

#include <csignal>
#include <cstdlib>
#include <optional>
#include <utility>

#include <poll.h>
#include <unistd.h>

#include "base/thread_name.h"

namespace seaway::server {
namespace {

using Clock = std::chrono::steady_clock;

/// Costs nothing, and no stop is asked for more precisely.
constexpr std::chrono::milliseconds look_every{250};

/// Whoever reads stderr may hang, too.
void say(const std::string& line) {
    pollfd writable{STDERR_FILENO, POLLOUT, 0};
    if (poll(&writable, 1, 0) == 1) [[maybe_unused]]
        const ssize_t written = write(STDERR_FILENO, line.data(), line.size());
}

} // namespace

StopDeadline::StopDeadline(std::chrono::milliseconds limit, int exit_code,
                           std::function<std::string()> last_words)
    : limit_(limit), exit_code_(exit_code), last_words_(std::move(last_words)),
      thread_([this] { watch(); }) {}

StopDeadline::~StopDeadline() {
    {
        const std::scoped_lock lock(mutex_);
        ended_ = true;
    }
    changed_.notify_all();
    thread_.join();
}

bool StopDeadline::signal_waits() {
    sigset_t pending;
    sigemptyset(&pending);
    sigpending(&pending);
    return sigismember(&pending, SIGTERM) == 1 || sigismember(&pending, SIGINT) == 1;
}

void StopDeadline::watch() {
    name_thread("sea-stop");
    std::optional<Clock::time_point> asked;
    std::unique_lock lock(mutex_);
    while (!changed_.wait_for(lock, look_every, [this] { return ended_; })) {
        if (!asked && (stopping_ || signal_waits()))
            asked = Clock::now();
        if (!asked || Clock::now() - *asked < limit_)
            continue;
        say(last_words_() + "\n");
        std::_Exit(exit_code_);
    }
}

} // namespace seaway::server
