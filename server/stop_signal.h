// SPDX-License-Identifier: Apache-2.0
// StopSignal: the signals of a server as something main can wait for: SIGTERM and SIGINT stop it, SIGHUP
// is handed on, SIGUSR1, SIGUSR2 and SIGPIPE do nothing. Make it before most threads start, so that
// they inherit the blocked signals; others hand them on.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <initializer_list>
#include <unistd.h>

namespace seaway::server {

class StopSignal {
  public:
    /// First of all, while nothing is served yet and all that there is may end at any instant: who is asked to
    /// stop ends with this code. A SIGHUP waits until wait() is called, others do nothing from here on.
    static void end_at_once(int exit_code) {
        early_exit_code_ = exit_code;
        for (const int signal : {SIGTERM, SIGINT})
            std::signal(signal, [](int) { std::_Exit(early_exit_code_); });
        // SIGPIPE: a peer that goes away is an error code, not our end.
        for (const int signal : {SIGPIPE, SIGUSR1, SIGUSR2})
            std::signal(signal, SIG_IGN);
        block({SIGHUP});
    }

    /// Threads that have begun before it hand on what they are sent, to whoever waits for it.
    StopSignal() : set_(block({SIGTERM, SIGINT, SIGHUP})) {
        struct sigaction hands_on = {};
        hands_on.sa_sigaction = &hand_on;
        hands_on.sa_flags = SA_SIGINFO | SA_RESTART;
        for (const int signal : {SIGTERM, SIGINT})
            sigaction(signal, &hands_on, nullptr);
    }

    /// Waits, calling `hung_up` at each SIGHUP and `beat` whenever `every` has passed; true if somebody asked to
    /// stop, false after fail().
    bool wait(const std::function<void()>& hung_up, std::chrono::microseconds every,
              const std::function<void()>& beat) const {
        using Clock = std::chrono::steady_clock;
        for (Clock::time_point next = Clock::now() + every;;) {
            const int signal = next_signal(std::chrono::duration_cast<std::chrono::microseconds>(
                std::max(next - Clock::now(), Clock::duration(0))));
            if (failed_)
                return false;
            if (signal == SIGHUP)
                hung_up();
            else if (signal > 0)
                return true;
            if (Clock::now() < next)
                continue;
            beat();
            next = Clock::now() + every;
        }
    }

    /// Ends the wait because the server cannot go on. Any thread.
    static void fail() {
        failed_ = true;
        kill(getpid(), SIGTERM);
    }

  private:
    /// 0 or less: none within the limit.
    int next_signal(std::chrono::microseconds limit) const {
        const auto whole = std::chrono::floor<std::chrono::seconds>(limit);
        const timespec wait{static_cast<std::time_t>(whole.count()),
                            static_cast<long>(1000 * (limit - whole).count())};
        return sigtimedwait(&set_, nullptr, &wait);
    }

    /// From here on this thread blocks them, too: sent once more, it is for the next one, or waits for the process.
    static void hand_on(int signal, siginfo_t*, void* context) {
        sigset_t& blocked_behind = static_cast<ucontext_t*>(context)->uc_sigmask;
        for (const int each : {SIGTERM, SIGINT})
            sigaddset(&blocked_behind, each);
        kill(getpid(), signal);
    }

    static sigset_t block(std::initializer_list<int> signals) {
        sigset_t set;
        sigemptyset(&set);
        for (const int signal : signals)
            sigaddset(&set, signal);
        pthread_sigmask(SIG_BLOCK, &set, nullptr);
        return set;
    }

    static inline volatile std::sig_atomic_t early_exit_code_ = 0;
    static inline std::atomic<bool> failed_ = false;
    sigset_t set_;
};

} // namespace seaway::server
