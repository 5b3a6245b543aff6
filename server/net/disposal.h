// SPDX-License-Identifier: Apache-2.0
// Disposal: the thread on which ends what may take long to end, as a map whose threads are in the
// middle of a row, so that the io thread waits for none of it. Thread-safe.
#pragma once

#include <condition_variable>
#include <list>
#include <memory>
#include <mutex>
#include <thread>

namespace seaway::server {

class Disposal {
  public:
    Disposal() : thread_([this] { run(); }) {}
    ~Disposal() { stop(); }
    Disposal(const Disposal&) = delete;
    Disposal& operator=(const Disposal&) = delete;

    /// One thing, in what it takes to wait here: made where there is memory, it may end where there is none.
    using Things = std::list<std::shared_ptr<void>>;

    /// Lets go of it, elsewhere and soon; after stop() here and at once.
    void take(Things one);
    void take(const std::shared_ptr<void>& thing) { take(Things(1, thing)); }

    /// Waits until all that was taken has ended. Idempotent. What is taken may hold the owner of this:
    /// who has taken anything stops before it lets go of the owner.
    void stop();

  private:
    void run();

    std::mutex mutex_;
    std::condition_variable wake_;
    Things things_;
    bool ending_ = false;
    std::thread thread_;
};

} // namespace seaway::server
