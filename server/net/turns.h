// SPDX-License-Identifier: Apache-2.0
// Turns: what the io thread has to send to many, a little at a time. Between two turns it looks at who has said something,
// so that a question waits for a turn or two, not until everybody has been sent what is next in his line.
// Of the io thread alone.
#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <optional>

namespace seaway::server {

class Turns {
  public:
    using Clock = std::chrono::steady_clock;
    using Work = std::function<void()>;

    /// Of a turn, for keyframes and for all else each: what takes longer ends with the work that is begun. To send a whole
    /// keyframe of a gale to one session takes 0.05 ms.
    static constexpr std::chrono::microseconds length{100};

    using Now = std::function<Clock::time_point()>;

    /// `post` runs what it is given on the io thread, behind what is ready there.
    explicit Turns(std::function<void(Work)> post, Now now = Clock::now)
        : post_(std::move(post)), now_(std::move(now)) {}

    /// In the next turn, before all else; there is one of it at a time. Throws std::bad_alloc, as later() does, where there is no
    /// memory for a turn: what waits has it with the next one that is asked for (go_on()).
    void first(Work work);
    /// In one of the next turns, after those that came before, and not in the one that is under way: who goes on and on has one
    /// work a turn.
    void later(Work work);
    /// A turn for what waits, if there was no memory for one.
    void go_on();
    /// Who is at work has been for long enough.
    bool over() const { return now_() >= begun_ + length; }
    /// What waits is never done.
    void clear();

  private:
    void ask_for_one();
    void turn();

    const std::function<void(Work)> post_;
    const Now now_;
    Work first_;
    std::deque<Work> waiting_;
    Clock::time_point begun_;
    bool asked_ = false; ///< for the next one
};

} // namespace seaway::server
