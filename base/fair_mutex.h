// SPDX-License-Identifier: Apache-2.0
// FairMutex: who waits longer has it first. A std::mutex goes to whoever comes by when it is let go of, which is the thread
// that has just done so: one that works in turns would never let another in.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>

namespace seaway {

class FairMutex {
  public:
    void lock() {
        std::unique_lock lock(mutex_);
        const std::uint64_t mine = last_++;
        changed_.wait(lock, [&] { return now_ == mine; });
    }
    /// Nobody has it, or waits for it.
    bool try_lock() {
        const std::scoped_lock lock(mutex_);
        if (now_ != last_)
            return false;
        ++last_;
        return true;
    }
    void unlock() {
        {
            const std::scoped_lock lock(mutex_);
            ++now_;
        }
        changed_.notify_all();
    }

  private:
    std::mutex mutex_;
    std::condition_variable changed_;
    std::uint64_t last_ = 0; ///< number of who comes next
    std::uint64_t now_ = 0;  ///< of who has it
};

} // namespace seaway
