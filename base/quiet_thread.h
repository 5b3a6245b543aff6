// SPDX-License-Identifier: Apache-2.0
// QuietThreads: while one stands, threads that are begun take no signals of the process. These are its program's: a
// library's thread that takes one runs a handler where nobody expects it, or ends a program that waits for it elsewhere. What
// a thread does itself, as touching memory that is not there, stays its own: handlers of the program see it. So does what runtimes
// with a garbage collector send to each thread that has called them back, for whose answer they wait: real-time signals (.NET, Mono),
// SIGPWR and SIGXCPU (Boehm's collector, which is Unity's).
#pragma once

#include <csignal>
#include <initializer_list>

namespace seaway {

/// Of the calling thread, which is as before afterwards.
class QuietThreads {
  public:
    QuietThreads() {
        sigset_t all;
        sigfillset(&all);
        for (const int own :
             {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTRAP, SIGABRT, SIGSYS, SIGPWR, SIGXCPU})
            sigdelset(&all, own);
        for (int own = SIGRTMIN; own <= SIGRTMAX; ++own)
            sigdelset(&all, own);
        pthread_sigmask(SIG_BLOCK, &all, &before_);
    }
    ~QuietThreads() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
    QuietThreads(const QuietThreads&) = delete;
    QuietThreads& operator=(const QuietThreads&) = delete;

  private:
    sigset_t before_;
};

} // namespace seaway
