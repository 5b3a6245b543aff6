// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/questions.h"

#include <chrono>
#include <utility>

#include <fmt/format.h>

#include "server/host/refusal.h"

namespace seaway::server {

void Questions::ask(Question question) {
    std::optional<Error> refusal;
    {
        const std::scoped_lock lock(mutex_);
        if (closed_) {
            refusal = closed_;
        } else if (waiting_.size() >= questions_waiting_max) {
            refusal = Error{Refusal::busy, fmt::format("{} questions wait already, try again later",
                                                       questions_waiting_max)};
        } else {
            ++asked_;
            waiting_.push_back(std::move(question));
        }
    }
    if (refusal)
        return question.refuse(*refusal);
    changed_.notify_all();
}

std::optional<Question> Questions::take(std::optional<sea::TimeUs> wait_us) {
    std::unique_lock lock(mutex_);
    const auto something = [&] { return woken_ || !waiting_.empty(); };
    if (waiting_.empty() || (woken_ && !passed_over_)) {
        passed_over_ = !waiting_.empty();
        if (wait_us)
            changed_.wait_for(lock, std::chrono::microseconds(*wait_us), something);
        else
            changed_.wait(lock, something);
        woken_ = false;
        return std::nullopt;
    }
    passed_over_ = false;
    Question question = std::move(waiting_.front());
    waiting_.pop_front();
    return question;
}

void Questions::put_back(Question question) {
    const std::scoped_lock lock(mutex_);
    waiting_.push_back(std::move(question));
}

void Questions::wake() {
    {
        const std::scoped_lock lock(mutex_);
        woken_ = true;
    }
    changed_.notify_all();
}

void Questions::close(const Error& why) {
    std::deque<Question> left;
    {
        const std::scoped_lock lock(mutex_);
        closed_ = why;
        left.swap(waiting_);
    }
    for (const Question& question : left)
        question.refuse(why);
}

std::uint64_t Questions::asked() const {
    const std::scoped_lock lock(mutex_);
    return asked_;
}

} // namespace seaway::server
