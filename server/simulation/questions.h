// SPDX-License-Identifier: Apache-2.0
// Questions: what is asked of the simulation, waiting in turn: a line for each asker, who take turns,
// so that one who asks much delays others no more than one who asks little. Bounded; whoever asks is
// answered once, by what was asked for or by why not, also when the simulation ends.
//
// Thread-safe.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <list>
#include <mutex>
#include <optional>

#include "base/result.h"
#include "sea/basics/time.h"
#include "server/host/asker.h"

namespace seaway::server {

/// Questions that wait at most; one more is refused at once. Who has none waiting finds room for one
/// all the same, up to as many again: nobody is shut out by those who ask much.
inline constexpr std::size_t questions_waiting_max = 1024;
/// Of one asker; a session has fewer by the limits of the wire.
inline constexpr std::size_t questions_of_one_max = 64;

/// Something asked: worked on slice by slice until it is answered, or refused.
struct Question {
    std::function<bool()> slice; ///< true: answered
    std::function<void(const Error&)> refuse;
    Asker asker;
    /// False: a slice would come to nothing yet; it is passed over. Empty: always ready. Called by
    /// take() alone, with the line locked; what makes it ready is followed by a wake().
    std::function<bool()> ready = {};
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
    /// To the end of its asker's line, whose turn comes after those of all others: a large question
    /// delays small ones by a slice at a time.
    void put_back(Question question);

    /// Ends the wait of take(), now or the next one.
    void wake();
    /// Refuses all that wait and all that come.
    void close(const Error& why);

    std::uint64_t asked() const;

  private:
    using Line = std::deque<Question>; ///< of one asker; never empty
    struct Place {
        std::list<Line>::iterator line;
        Line::iterator question;
    };
    std::list<Line>::iterator line_of(const Asker& asker);
    void add(Question question);
    std::optional<Place> first_ready();
    std::optional<Error> why_not(const Question& question);

    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::list<Line> lines_; ///< the one whose turn it is first
    std::size_t waiting_ = 0;
    std::optional<Error> closed_;
    bool woken_ = false;
    bool passed_over_ = false; ///< the first one, for a wake()
    std::uint64_t asked_ = 0;
};

} // namespace seaway::server
