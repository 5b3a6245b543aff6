// SPDX-License-Identifier: Apache-2.0
// StopSignal: SIGTERM and SIGINT as something main can wait for. Make it before any thread starts,
// so that every thread inherits the blocked signals.
#pragma once

#include <csignal>
#include <unistd.h>

namespace seaway::server {

class StopSignal {
  public:
    StopSignal() {
        sigemptyset(&set_);
        for (const int signal : {SIGTERM, SIGINT, failure})
            sigaddset(&set_, signal);
        pthread_sigmask(SIG_BLOCK, &set_, nullptr);
        std::signal(SIGPIPE, SIG_IGN); // a peer that goes away is an error code, not our end
    }

    /// Waits; true if somebody asked to stop, false after fail().
    bool wait() const {
        int signal = 0;
        sigwait(&set_, &signal);
        return signal != failure;
    }

    /// Ends the wait because the server cannot go on. Any thread.
    static void fail() { kill(getpid(), failure); }

  private:
    static constexpr int failure = SIGUSR1;
    sigset_t set_;
};

} // namespace seaway::server
