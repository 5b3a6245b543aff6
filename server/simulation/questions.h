// SPDX-License-Identifier: Apache-2.0
// Questions: what is asked of the simulation, waiting in turn: a line for each asker. Everything is
// priced before it may wait, against the budget of its asker; the next turn is that of the asker who
// would be served first if all who wait had equal shares of the thread (fair queueing, by what slices
// have really taken). So a single point goes before batches, whoever floods, and one who asks much
// delays others no more than one who asks little. Bounded; whoever asks is answered once, by what was
// asked for or by why not, also when the simulation ends.
//
// Fair queueing: A. Demers, S. Keshav, S. Shenker, "Analysis and simulation of a fair queueing
// algorithm", SIGCOMM 1989: smallest finish tag first, tag = max(virtual time, own last tag) + price.
//
// Thread-safe.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <optional>

#include "base/result.h"
#include "sea/basics/time.h"
#include "server/host/asker.h"
#include "server/host/memory.h"
#include "server/simulation/account.h"

namespace seaway::server {

/// Questions that wait at most; one more is refused at once. Who has none waiting finds room for one
/// all the same, up to as many again: nobody is shut out by those who ask much.
inline constexpr std::size_t questions_waiting_max = 1024;
/// Of one asker; a session has fewer by the limits of the wire.
inline constexpr std::size_t questions_of_one_max = 64;
/// Points that wait, and their answers, have half of their room; who has none waiting finds all of it, and who
/// has but a few points always.
inline constexpr std::size_t small_question_bytes = 16u * 1024;
/// Prompt questions go before all others, which have a fifth of the thread where both wait: they are owed a
/// quarter of what the prompt ones take, and have their turns once this much is owed.
inline constexpr double owed_us_max = 50'000;
/// Who has asked nothing for a while is served as if it were so far behind the others: its next few
/// points come before the next points of those who ask without end.
inline constexpr double head_start_us = 50'000;

/// Something asked: worked on slice by slice until it is answered, or refused.
struct Question {
    std::function<bool()> slice; ///< true: answered
    std::function<void(const Error&)> refuse;
    Asker asker;
    /// False: a slice would come to nothing yet; it is passed over. Empty: always ready. Called by
    /// take() alone, with the line locked; what makes it ready is followed by a wake().
    std::function<bool()> ready = {};
    double price_us = 0;
    bool prompt = false;    ///< goes before those that are not (Prices::prompt_us)
    std::size_t bytes = 0;  ///< held while it waits
    double spent_us = 0;    ///< so far
    Room::Place place = {}; ///< of its bytes, while it waits
};

class Questions {
  public:
    explicit Questions(WorkBudget budget = {},
                       std::shared_ptr<Room> room = Memory().room(MemoryUse::points),
                       std::function<double()> now_s = steady_seconds)
        : budget_(budget), room_(std::move(room)), now_s_(std::move(now_s)) {}

    /// Refused at once, Refusal::busy, where no more may wait or the asker's budget is spent, with
    /// the time after which it is worth asking again; after close() with its reason.
    void ask(Question question);

    /// The one whose turn it is. Where none waits, or after wake(): none, once one has come, wake()
    /// has been called or `wait_us` have passed (for ever without it), so that who waited looks at
    /// the clock before anything else. Never none twice in a row while one waits, however often
    /// wake() is called.
    std::optional<Question> take(std::optional<sea::TimeUs> wait_us);
    /// What a slice took: to be said after each, then put_back() or over().
    void spent(Question& question, double us);
    /// To the end of its asker's line; a long one to its head, so that an asker has one of them under way,
    /// and what that holds.
    void put_back(Question question);
    /// It has been answered, or dropped: what it took less than its price goes back to its asker.
    void over(const Question& question);

    /// Ends the wait of take(), now or the next one.
    void wake();
    /// Refuses all that wait and all that come.
    void close(const Error& why);

    std::uint64_t asked() const;
    std::uint64_t over_budget() const; ///< refused for it
    std::size_t bytes() const;         ///< of those that wait or are worked on

  private:
    struct Line { ///< of one asker
        Line(const WorkBudget& budget, double now_s, double all_us)
            : account(budget, now_s), virtual_us(all_us) {}

        std::deque<Question> waiting;
        std::size_t bytes = 0; ///< of them
        Account account;
        double virtual_us;      ///< what it has been served, or what all had when it came
        std::uint64_t turn = 0; ///< when it was served last, or came
    };
    using Lines = std::map<Asker, Line, Asker::Order>;
    struct Place {
        Lines::iterator line;
        std::deque<Question>::iterator question;
        double finish_us; ///< by which it would be done if all had equal shares
    };

    Line& line_of(const Asker& asker);
    void forget_who_left();
    void add(Line& line, Question question, bool first = false);
    std::optional<Place> next();
    /// The first of its line that is ready, of the prompt ones or of the others.
    static std::optional<Place> next_of(Lines::iterator line, bool prompt);
    static void earlier(std::optional<Place>& best, const std::optional<Place>& other);
    std::optional<Error> why_not(const Question& question, Line& line);

    const WorkBudget budget_;
    const std::shared_ptr<Room> room_;
    const std::function<double()> now_s_;

    mutable std::mutex mutex_;
    std::condition_variable changed_;
    Lines lines_; ///< also of some who have nothing waiting
    std::size_t lines_most_ = 64;
    std::size_t waiting_ = 0;
    double virtual_us_ =
        0; ///< of who was served furthest: start-time fair queueing (Goyal, Vin, Cheng 1996)
    double owed_us_ = 0;
    std::uint64_t turns_ = 0;
    std::optional<Error> closed_;
    bool woken_ = false;
    bool passed_over_ = false; ///< the first one, for a wake()
    std::uint64_t asked_ = 0;
    std::uint64_t over_budget_ = 0;
};

} // namespace seaway::server
