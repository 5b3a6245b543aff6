// SPDX-License-Identifier: Apache-2.0
// Questions: what is asked of the simulation, waiting in turn. Bounded; whoever asks is answered
// once, by what was asked for or by why not, also when the simulation ends.
//
// Thread-safe.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>

#include "base/result.h"
#include "sea/basics/time.h"
#include "server/host/asker.h"

namespace seaway::server {

/// Questions that wait at most; one more is refused at once.
inline constexpr std::size_t questions_waiting_max = 1024;

/// Something asked: worked on slice by slice until it is answered, or refused.
struct Question {
    std::function<bool()> slice; ///< true: answered
    std::function<void(const Error&)> refuse;
    Asker asker;
};

class Questions {
  public:
    /// Refused at once, Refusal::busy, where no more may wait; after close() with its reason.
    void ask(Question question);

    /// The one whose turn it is. Where none waits, or after wake(): none, once one has come, wake()
    /// has been called or `wait_us` have passed (for ever without it), so that who waited looks at
    /// the clock before anything else. Never none twice in a row while one waits, however often
    /// wake() is called.
    std::optional<Question> take(std::optional<sea::TimeUs> wait_us);
    /// To the end of the line: a large question delays small ones by a slice at a time.
    void put_back(Question question);

    /// Ends the wait of take(), now or the next one.
    void wake();
    /// Refuses all that wait and all that come.
    void close(const Error& why);

    std::uint64_t asked() const;

  private:
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<Question> waiting_;
    std::optional<Error> closed_;
    bool woken_ = false;
    bool passed_over_ = false; ///< the first one, for a wake()
    std::uint64_t asked_ = 0;
};

} // namespace seaway::server
