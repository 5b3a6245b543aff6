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

#include <array>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <mutex>
#include <optional>

#include "base/for_want_of_memory.h"
#include "base/result.h"
#include "sea/basics/time.h"
#include "server/host/asker.h"
#include "server/host/memory.h"
#include "server/simulation/account.h"

namespace seaway::server {

/// Questions that wait or are worked on at most; one more is refused at once. Who has none waiting finds room for one
/// all the same, up to as many again: nobody is shut out by those who ask much.
inline constexpr std::size_t questions_waiting_max = 1024;
/// Of one asker; a session has fewer by the limits of the wire.
inline constexpr std::size_t questions_of_one_max = 64;
/// Points that wait, and their answers, have half of their room; who has none waiting finds all of it, and who
/// has but a few points always.
inline constexpr std::size_t small_question_bytes = 16u * 1024;
/// Prompt questions go before all others, which have a fifth of the hands that both wait for: they are owed a
/// quarter of what the prompt ones take, and have their turns once this much is owed.
inline constexpr double owed_us_max = 50'000;
/// Who has asked nothing for a while is served as if it were so far behind the others: its next few
/// points come before the next points of those who ask without end.
inline constexpr double head_start_us = 50'000;

/// Who does the next slice of a question.
enum class Hand : std::size_t {
    simulation, ///< the one thread that has the device
    answers,    ///< any of the threads that answer
};
inline constexpr std::size_t hands = 2;

/// Something asked: worked on slice by slice, each on one thread, until it is answered, or refused.
struct Question {
    std::function<bool()> slice; ///< true: answered
    std::function<void(const Error&)> refuse;
    Asker asker;
    /// False: a slice would come to nothing yet; it is passed over. Empty: always ready. Called
    /// with the line locked; what makes it ready is followed by a wake().
    std::function<bool()> ready = {};
    /// Whose slice is the next one; asked while nobody works on it. Empty: the simulation's.
    std::function<Hand()> hand = {};
    double price_us = 0;
    bool prompt = false;          ///< goes before those that are not (Prices::prompt_us)
    bool own = false;             ///< of the server itself: not counted among what was asked
    std::size_t bytes = 0;        ///< held while it waits
    double spent_us = 0;          ///< so far
    Room::Place place = {};       ///< of its bytes, while it waits
    Hand next = Hand::simulation; ///< what `hand` said last
    bool askers = false;          ///< who asked works on it
};

/// By what `why` makes. Where there is no memory for it tried for a second: others give some back soon. Who asked himself, on a
/// thread that many wait for, is told by what is thrown.
template <class Why>
void refuse_surely(const Question& question, const Why& why) {
    if (question.askers)
        return question.refuse(why());
    (void)tried_for_a_second([&] { question.refuse(why()); });
}

class Questions {
  public:
    explicit Questions(WorkBudget budget = {},
                       std::shared_ptr<Room> room = Memory().room(MemoryUse::points),
                       std::function<double()> now_s = steady_seconds)
        : budget_(budget), room_(std::move(room)), now_s_(std::move(now_s)) {}

    /// Refused at once, Refusal::busy, where no more may wait or the asker's budget is spent, with
    /// the time after which it is worth asking again; after close() with its reason.
    void ask(Question question);
    /// Why a question of so many bytes would be refused, whatever it costs: asked before it is priced, where that takes long.
    std::optional<Error> why_not(const Asker& asker, std::size_t bytes);
    /// As ask(); but where it is this question's turn among those for the threads that answer, who asks is given it, to work
    /// on as they do: a slice, spent(), put_back() or over().
    std::optional<Question> ask_or_take(Question question);

    /// Takes the price of work that waits in no line here, and is done elsewhere, out of the budget of its asker; or why
    /// not, as ask(). settle() once it is done.
    Result<void> charge(const Asker& asker, double price_us);
    /// What it took less than its price goes back, or more is taken.
    void settle(const Asker& asker, double left_us);

    /// The one whose turn it is of those for the simulation. Where none waits, or after wake(): none, once one has
    /// come, wake() has been called or `wait_us` have passed (for ever without it), so that who waited looks at
    /// the clock before anything else. Never none twice in a row while one waits, however often
    /// wake() is called. For one thread.
    std::optional<Question> take(std::optional<sea::TimeUs> wait_us);
    /// The one whose turn it is of those for the threads that answer; waits for it. None: it is closed.
    std::optional<Question> take_to_answer();
    /// What a slice took: to be said after each, then put_back() or over().
    void spent(Question& question, double us);
    /// To the end of its asker's line; a long one to its head, so that an asker has one of them under way,
    /// and what that holds. Takes no memory. Refused where the line has been closed meanwhile.
    void put_back(Question question);
    /// It has been answered, or dropped: what it took less than its price goes back to its asker.
    void over(const Question& question);

    /// Ends the wait of take(), now or the next one, and lets the others look for what is ready.
    void wake();
    /// Refuses all that wait and all that come; take_to_answer() has ended.
    void close(Error why);

    std::uint64_t asked() const;
    std::uint64_t over_budget() const; ///< refused for it
    std::size_t bytes() const;         ///< of those that wait or are worked on

  private:
    using Waiting = std::list<Question>;
    struct Line { ///< of one asker
        Line(const WorkBudget& budget, double now_s, double all_us)
            : account(budget, now_s), virtual_us(all_us) {}

        Waiting waiting;
        std::size_t bytes = 0; ///< of them
        Waiting worked_on;     ///< taken, and neither put back nor over: where each was
        std::size_t longs = 0; ///< of these not prompt
        Account account;
        double virtual_us;      ///< what it has been served, or what all had when it came
        std::uint64_t turn = 0; ///< when it was served last, or came
    };
    using Lines = std::map<Asker, Line, Asker::Order>;
    struct Place {
        Lines::iterator line;
        Waiting::iterator question;
        double finish_us; ///< by which it would be done if all had equal shares
    };

    /// Into its line, or null: it is refused.
    Line* admit(std::unique_lock<std::mutex>& lock, Question& question);
    Line& line_of(const Asker& asker);
    void forget_who_left();
    void add(Line& line, Waiting one, bool first = false);
    std::optional<Place> next(Hand hand);
    /// The first of its line that is ready for this hand, of the prompt ones; of the others the first that is
    /// ready at all, if it is for this hand.
    static std::optional<Place> next_of(Lines::iterator line, Hand hand, bool prompt);
    static void earlier(std::optional<Place>& best, const std::optional<Place>& other);
    Question taken(const Place& place);
    /// Where it was, or another: they are empty.
    Waiting given_back(Line& line, const Question& question);
    std::optional<Error> why_not(std::size_t bytes, Line& line);
    std::optional<Error> over_its_budget(Line& line);
    std::condition_variable& waits_for(Hand hand) {
        return hand == Hand::simulation ? changed_ : to_answer_;
    }

    const WorkBudget budget_;
    const std::shared_ptr<Room> room_;
    const std::function<double()> now_s_;

    mutable std::mutex mutex_;
    std::condition_variable changed_;   ///< for the simulation
    std::condition_variable to_answer_; ///< for those who answer
    Lines lines_;                       ///< also of some who have nothing waiting
    std::size_t lines_most_ = 64;
    std::size_t open_ = 0; ///< that wait or are worked on
    int idle_ = 0;         ///< threads in take_to_answer()
    double virtual_us_ =
        0; ///< of who was served furthest: start-time fair queueing (Goyal, Vin, Cheng 1996)
    std::array<double, hands> owed_us_{}; ///< of each hand's time
    std::uint64_t turns_ = 0;
    std::optional<Error> closed_;
    bool woken_ = false;
    bool passed_over_ = false; ///< the first one, for a wake()
    std::uint64_t asked_ = 0;
    std::uint64_t over_budget_ = 0;
};

} // namespace seaway::server
