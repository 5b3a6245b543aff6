// SPDX-License-Identifier: Apache-2.0
// Senders: the threads that write what a turn of deliveries has for its sessions (--io-threads). All that is decided stays with the
// io thread; a write alone, which touches its own connection and bytes that nobody changes, is dealt out, and the io thread
// goes on when all of them are done. With one thread, its own, each is written at once.
//
// Of the io thread alone.
#pragma once

#include <csignal>
#include <memory>
#include <vector>

#include "base/thread_pool.h"

namespace seaway::server {

/// Most of them are asleep unless many sessions are sent to at once.
inline constexpr int io_threads_max = 64;

/// What a connection does when it sends.
class Sending {
  public:
    virtual ~Sending() = default;
    /// Takes what is to be sent. False: there is nothing.
    virtual bool take() noexcept = 0;
    /// On any thread: as much of it as the system takes at once.
    virtual void write() noexcept = 0;
    virtual void written() noexcept = 0;
};

/// While it lives, this thread and those that it starts get no SIGPIPE: a file that is sent (Socket::send_now) raises it where the peer
/// has gone; of other writes sockets are told call by call.
class NoBrokenPipes {
  public:
    NoBrokenPipes();
    ~NoBrokenPipes();
    NoBrokenPipes(const NoBrokenPipes&) = delete;
    NoBrokenPipes& operator=(const NoBrokenPipes&) = delete;

  private:
    sigset_t before_{};
};

class Senders {
  public:
    /// Threads in all. Throws std::system_error where the system gives none.
    void start(int threads);

    int threads() const { return pool_ == nullptr ? 1 : pool_->threads(); }

    /// Runs `deliver`, and sends what it has brought to those who said later() meanwhile.
    template <class Deliver>
    void together(Deliver deliver) {
        struct
            Gathers { // what was gathered is sent, too, where an exception comes out of `deliver`
            Senders& senders;
            explicit Gathers(Senders& of) : senders(of) { senders.gathers_ = true; }
            ~Gathers() {
                senders.gathers_ = false;
                senders.send();
            }
        } const gathers(*this);
        deliver();
    }
    /// True: it is sent to in a moment, with the others. False: now is the time.
    bool later(std::shared_ptr<Sending> one);

  private:
    void send() noexcept;

    std::unique_ptr<ThreadPool> pool_; ///< null: the io thread alone
    bool gathers_ = false;
    std::vector<std::shared_ptr<Sending>> waiting_;
    std::vector<std::shared_ptr<Sending>> sending_;
};

} // namespace seaway::server
