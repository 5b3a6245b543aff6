// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/questions.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include <fmt/format.h>

#include "server/host/refusal.h"

namespace seaway::server {

std::list<Questions::Line>::iterator Questions::line_of(const Asker& asker) {
    return std::ranges::find_if(lines_,
                                [&](const Line& line) { return line.front().asker.same(asker); });
}

void Questions::add(Question question) {
    auto line = line_of(question.asker);
    if (line == lines_.end())
        line = lines_.emplace(lines_.end());
    line->push_back(std::move(question));
    ++waiting_;
}

std::optional<Questions::Place> Questions::first_ready() {
    for (auto line = lines_.begin(); line != lines_.end(); ++line)
        for (auto question = line->begin(); question != line->end(); ++question)
            if (!question->ready || question->asker.gone() || question->ready())
                return Place{line, question};
    return std::nullopt;
}

std::optional<Error> Questions::why_not(const Question& question) {
    if (closed_)
        return closed_;
    const auto line = line_of(question.asker);
    const std::size_t own = line == lines_.end() ? 0 : line->size();
    if (own >= questions_of_one_max)
        return Error{Refusal::busy, fmt::format("{} questions of yours wait already", own)};
    if (waiting_ >= questions_waiting_max * (own == 0 ? 2 : 1))
        return Error{Refusal::busy, fmt::format("{} questions wait already, try again later",
                                                questions_waiting_max)};
    return std::nullopt;
}

void Questions::ask(Question question) {
    std::unique_lock lock(mutex_);
    if (const std::optional<Error> refusal = why_not(question)) {
        lock.unlock();
        return question.refuse(*refusal);
    }
    ++asked_;
    add(std::move(question));
    lock.unlock();
    changed_.notify_all();
}

std::optional<Question> Questions::take(std::optional<sea::TimeUs> wait_us) {
    std::unique_lock lock(mutex_);
    const auto something = [&] { return woken_ || first_ready(); };
    const std::optional<Place> first = first_ready();
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
    Question question = std::move(*first->question);
    first->line->erase(first->question);
    --waiting_;
    if (first->line->empty())
        lines_.erase(first->line);
    else
        lines_.splice(lines_.end(), lines_, first->line);
    return question;
}

void Questions::put_back(Question question) {
    const std::scoped_lock lock(mutex_);
    add(std::move(question));
}

void Questions::wake() {
    {
        const std::scoped_lock lock(mutex_);
        woken_ = true;
    }
    changed_.notify_all();
}

void Questions::close(const Error& why) {
    std::list<Line> left;
    {
        const std::scoped_lock lock(mutex_);
        closed_ = why;
        left.swap(lines_);
        waiting_ = 0;
    }
    for (const Line& line : left)
        for (const Question& question : line)
            question.refuse(why);
}

std::uint64_t Questions::asked() const {
    const std::scoped_lock lock(mutex_);
    return asked_;
}

} // namespace seaway::server
