// SPDX-License-Identifier: Apache-2.0
// Questions: what was asked of the server and is to be taken later, and what a program that polls has not been told yet.
//
// Thread-safe. Shared by the client that asks and by the replies under way, which may come after it.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

#include "base/result.h"
#include "sea/surface/answer.h"

namespace seaway::client {

class Questions {
  public:
    using Answers = Result<std::vector<sea::Answer>>;
    /// Neither taken nor cancelled.
    static constexpr std::size_t open_max = 256;

    struct Event {
        enum class Kind { answered, status } kind = Kind::answered;
        std::uint64_t question = 0; ///< answered
    };

    Questions() = default;
    ~Questions();
    Questions(const Questions&) = delete;
    Questions& operator=(const Questions&) = delete;

    /// The number of a new one, from 1 on; nothing: too many are open.
    std::optional<std::uint64_t> open();
    /// Its reply. One that was cancelled is dropped.
    void answer(std::uint64_t question, Answers answers);
    /// Ends it. Nothing: it is still under way. An error, too: there is none of this number, or not `count` answers.
    std::optional<Answers> take(std::uint64_t question, std::size_t count);
    /// False: there is none.
    bool cancel(std::uint64_t question);

    void status_changed();

    /// The next event, in the order in which they came; waits for one this long.
    std::optional<Event> next(double timeout_s);
    bool has_event() const;
    /// Readable while there are events. An error: the system gives no more.
    Result<int> descriptor();

    std::size_t open_count() const;

  private:
    void add(Event event);      ///< mutex_ held
    void forget(std::uint64_t); ///< mutex_ held: its event
    void show();                ///< mutex_ held: the descriptor is as the events are

    mutable std::mutex mutex_;
    std::condition_variable came_;
    std::map<std::uint64_t, std::optional<Answers>> questions_; ///< nothing: under way
    std::uint64_t last_ = 0;
    std::deque<Event> events_;
    int descriptor_ = -1;
    bool shown_ = false; ///< it is readable
};

} // namespace seaway::client
