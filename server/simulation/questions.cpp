// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/questions.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "server/host/refusal.h"

namespace seaway::server {

namespace {

Error busy(double wait_s, std::string why) {
    Error error{Refusal::busy, std::move(why)};
    // A day is as good as never, and fits.
    error.retry_after_ms = static_cast<std::uint32_t>(std::ceil(1e3 * std::min(wait_s, 86'400.0)));
    return error;
}

/// Where much waits in the server as a whole, some of it is done by then.
constexpr double crowd_wait_s = 1;

} // namespace

Questions::Line& Questions::line_of(const Asker& asker) {
    const auto found = lines_.find(asker);
    if (found != lines_.end())
        return found->second;
    forget_who_left();
    return lines_.emplace(asker, Line(budget_, now_s_(), virtual_us_ - head_start_us))
        .first->second;
}

/// Whoever owes nothing and has nothing waiting is as good as new.
void Questions::forget_who_left() {
    if (lines_.size() < lines_most_)
        return;
    const double now_s = now_s_();
    for (auto at = lines_.begin(); at != lines_.end();) {
        Line& line = at->second;
        const bool as_new =
            line.virtual_us <= virtual_us_ - head_start_us && line.account.full(now_s);
        const bool forgotten =
            line.waiting.empty() && line.worked_on.empty() && (at->first.left() || as_new);
        at = forgotten ? lines_.erase(at) : std::next(at);
    }
    lines_most_ = std::max<std::size_t>(64, 2 * lines_.size());
}

void Questions::add(Line& line, Waiting one, bool first) {
    Question& question = one.front();
    if (line.waiting.empty()) {
        line.virtual_us = std::max(line.virtual_us, virtual_us_ - head_start_us);
        line.turn = ++turns_;
    }
    if (question.place == nullptr)
        question.place = room_->take_anyway(question.bytes);
    question.next = question.hand ? question.hand() : Hand::simulation;
    line.bytes += question.bytes;
    line.waiting.splice(first ? line.waiting.begin() : line.waiting.end(), one);
    ++open_;
}

std::optional<Questions::Place> Questions::next_of(Lines::iterator line, Hand hand, bool prompt) {
    if (!prompt && line->second.longs > 0)
        return std::nullopt;
    Waiting& waiting = line->second.waiting;
    const auto first = std::ranges::find_if(waiting, [&](const Question& question) {
        return question.prompt == prompt && (!prompt || question.next == hand) &&
               (!question.ready || question.ready());
    });
    if (first == waiting.end() || first->next != hand)
        return std::nullopt;
    return Place{line, first,
                 line->second.virtual_us + std::max(first->price_us - first->spent_us, 0.0)};
}

void Questions::earlier(std::optional<Place>& best, const std::optional<Place>& other) {
    if (other && (!best || other->finish_us < best->finish_us ||
                  (other->finish_us == best->finish_us &&
                   other->line->second.turn < best->line->second.turn)))
        best = other;
}

std::optional<Questions::Place> Questions::next(Hand hand) {
    std::optional<Place> prompt, other;
    for (auto line = lines_.begin(); line != lines_.end(); ++line) {
        Waiting& waiting = line->second.waiting;
        const auto gone = std::ranges::find_if(
            waiting, [](const Question& question) { return question.asker.gone(); });
        if (gone != waiting.end()) // dropped before anything is worked on
            return Place{line, gone, 0};
        earlier(prompt, next_of(line, hand, true));
        earlier(other, next_of(line, hand, false));
    }
    const double owed_us = owed_us_[static_cast<std::size_t>(hand)];
    return !prompt || (other && owed_us >= owed_us_max) ? other : prompt;
}

std::optional<Error> Questions::why_not(std::size_t bytes, Line& line) {
    if (closed_)
        return closed_;
    const std::size_t own = line.waiting.size() + line.worked_on.size();
    if (own >= questions_of_one_max)
        return busy(crowd_wait_s, fmt::format("{} questions of yours wait already", own));
    if (open_ >= questions_waiting_max * (own == 0 ? 2 : 1))
        return busy(crowd_wait_s, fmt::format("{} questions wait already, try again later",
                                              questions_waiting_max));
    if (room_->held_bytes() + bytes > room_->bytes_max() / (own == 0 ? 1 : 2) &&
        line.bytes + bytes > small_question_bytes)
        return busy(crowd_wait_s, "points that wait fill the memory there is for them");
    return over_its_budget(line);
}

std::optional<Error> Questions::over_its_budget(Line& line) {
    if (line.account.may_ask(now_s_()))
        return std::nullopt;
    ++over_budget_;
    return busy(line.account.wait_s(),
                fmt::format("what you have asked for takes longer than {:g} s and {:g} of the time "
                            "since: again in {:.1f} s",
                            budget_.burst_s, budget_.rate, std::max(line.account.wait_s(), 0.1)));
}

Result<void> Questions::charge(const Asker& asker, double price_us) {
    const std::scoped_lock lock(mutex_);
    if (closed_)
        return *closed_;
    Line& line = line_of(asker);
    if (std::optional<Error> refusal = over_its_budget(line))
        return *std::move(refusal);
    line.account.take(price_us);
    return {};
}

void Questions::settle(const Asker& asker, double left_us) {
    const std::scoped_lock lock(mutex_);
    if (const auto line = lines_.find(asker); line != lines_.end())
        line->second.account.give_back(left_us);
}

Questions::Line* Questions::admit(std::unique_lock<std::mutex>& lock, Question& question) {
    Line& line = line_of(question.asker);
    if (const std::optional<Error> refusal = why_not(question.bytes, line)) {
        lock.unlock();
        question.refuse(*refusal);
        return nullptr;
    }
    asked_ += question.own ? 0 : 1;
    line.account.take(question.price_us);
    Waiting one;
    one.push_back(std::move(question));
    add(line, std::move(one));
    return &line;
}

std::optional<Error> Questions::why_not(const Asker& asker, std::size_t bytes) {
    const std::scoped_lock lock(mutex_);
    return why_not(bytes, line_of(asker));
}

void Questions::ask(Question question) {
    std::unique_lock lock(mutex_);
    const Line* line = admit(lock, question);
    if (!line)
        return;
    const Hand hand = line->waiting.back().next;
    lock.unlock();
    waits_for(hand).notify_one();
}

std::optional<Question> Questions::ask_or_take(Question question) {
    std::unique_lock lock(mutex_);
    Line* line = admit(lock, question);
    if (!line)
        return std::nullopt;
    const Question* own = &line->waiting.back();
    const Hand hand = own->next;
    const std::optional<Place> first = hand == Hand::answers ? next(Hand::answers) : std::nullopt;
    if (first && &*first->question == own) {
        Question mine = taken(*first);
        mine.askers = true;
        return mine;
    }
    lock.unlock();
    waits_for(hand).notify_one();
    return std::nullopt;
}

std::optional<Question> Questions::take(std::optional<sea::TimeUs> wait_us) {
    std::unique_lock lock(mutex_);
    const auto something = [&] { return woken_ || next(Hand::simulation); };
    const std::optional<Place> first = next(Hand::simulation);
    if (!first || (woken_ && !passed_over_)) {
        passed_over_ = first.has_value();
        if (wait_us)
            changed_.wait_for(lock, std::chrono::microseconds(*wait_us), something);
        else
            changed_.wait(lock, something);
        woken_ = false;
        return std::nullopt;
    }
    passed_over_ = false;
    return taken(*first);
}

std::optional<Question> Questions::take_to_answer() {
    std::unique_lock lock(mutex_);
    std::optional<Place> first;
    ++idle_;
    to_answer_.wait(lock, [&] { return closed_ || (first = next(Hand::answers)); });
    --idle_;
    if (closed_)
        return std::nullopt;
    Question question = taken(*first);
    if (idle_ > 0 && next(Hand::answers)) // who puts something back tells nobody: it looks itself
        to_answer_.notify_one();
    return question;
}

Question Questions::taken(const Place& place) {
    Line& line = place.line->second;
    Question question = std::move(*place.question);
    line.worked_on.splice(line.worked_on.end(), line.waiting, place.question);
    line.turn = ++turns_;
    line.longs += question.prompt ? 0 : 1;
    virtual_us_ = std::max(virtual_us_, line.virtual_us);
    line.bytes -= question.bytes;
    return question;
}

Questions::Waiting Questions::given_back(Line& line, const Question& question) {
    --open_;
    line.longs -= question.prompt ? 0 : 1;
    Waiting one;
    one.splice(one.end(), line.worked_on, line.worked_on.begin());
    return one;
}

void Questions::spent(Question& question, double us) {
    const double taken_us = std::max(question.price_us, question.spent_us);
    question.spent_us += us;
    const std::scoped_lock lock(mutex_);
    double& owed_us = owed_us_[static_cast<std::size_t>(question.next)];
    owed_us =
        question.prompt ? std::min(owed_us + us / 4, 2 * owed_us_max) : std::max(owed_us - us, 0.0);
    const auto line = lines_.find(question.asker);
    if (line == lines_.end())
        return; // closed
    line->second.virtual_us += us;
    if (question.spent_us > taken_us)
        line->second.account.take(question.spent_us - taken_us, now_s_());
}

void Questions::put_back(Question question) {
    std::unique_lock lock(mutex_);
    if (closed_) {
        lock.unlock();
        return refuse_surely(question, [this] { return *closed_; });
    }
    Line& line = line_of(question.asker);
    Waiting one = given_back(line, question);
    const double own_us = line.virtual_us;
    const bool is_long = !question.prompt;
    const Hand before = question.next;
    const bool was_askers = std::exchange(question.askers, false); // who looks for no other
    one.front() = std::move(question);
    add(line, std::move(one), is_long);
    if (line.waiting.size() == 1)
        line.virtual_us = own_us; // it has not been away
    const Hand hand = (is_long ? line.waiting.front() : line.waiting.back()).next;
    lock.unlock();
    if (hand != before || was_askers)
        waits_for(hand).notify_one();
}

void Questions::over(const Question& question) {
    {
        const std::scoped_lock lock(mutex_);
        const auto line = lines_.find(question.asker);
        if (closed_ || line == lines_.end())
            return;
        (void)given_back(line->second, question);
        line->second.account.give_back(std::max(question.price_us - question.spent_us, 0.0));
    }
    if (question.prompt)
        return;
    changed_.notify_all(); // the next long one of its asker may begin
    to_answer_.notify_all();
}

void Questions::wake() {
    {
        const std::scoped_lock lock(mutex_);
        woken_ = true;
    }
    changed_.notify_all();
    to_answer_.notify_all();
}

void Questions::close(Error why) {
    Lines left;
    {
        const std::scoped_lock lock(mutex_);
        closed_ = std::move(why);
        left.swap(lines_);
        open_ = 0;
    }
    to_answer_.notify_all();
    for (const auto& [asker, line] : left)
        for (const Question& question : line.waiting)
            refuse_surely(question, [this] { return *closed_; });
}

std::uint64_t Questions::asked() const {
    const std::scoped_lock lock(mutex_);
    return asked_;
}

std::uint64_t Questions::over_budget() const {
    const std::scoped_lock lock(mutex_);
    return over_budget_;
}

std::size_t Questions::bytes() const {
    return room_->held_bytes();
}

} // namespace seaway::server
