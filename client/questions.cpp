// SPDX-License-Identifier: Apache-2.0
#include "client/questions.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>

#include <fmt/format.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "client/link/failure.h"

namespace seaway::client {

Questions::~Questions() {
    if (descriptor_ >= 0)
        ::close(descriptor_);
}

std::optional<std::uint64_t> Questions::open() {
    const std::scoped_lock lock(mutex_);
    if (questions_.size() >= open_max)
        return std::nullopt;
    questions_[++last_];
    return last_;
}

void Questions::answer(std::uint64_t question, Answers answers) {
    const std::scoped_lock lock(mutex_);
    const auto found = questions_.find(question);
    if (found == questions_.end())
        return;
    found->second.emplace(std::move(answers));
    add({Event::Kind::answered, question});
}

std::optional<Questions::Answers> Questions::take(std::uint64_t question, std::size_t count) {
    const std::scoped_lock lock(mutex_);
    const auto found = questions_.find(question);
    if (found == questions_.end())
        return failed(
            Failure::bad_argument,
            fmt::format("question {}: there is none, or it was taken or cancelled", question));
    if (!found->second)
        return std::nullopt;
    if (*found->second && (*found->second)->size() != count)
        return failed(Failure::bad_argument,
                      fmt::format("question {} is of {} points, room is given for {}", question,
                                  (*found->second)->size(), count));
    Answers answers = *std::move(found->second);
    questions_.erase(found);
    forget(question);
    return answers;
}

bool Questions::cancel(std::uint64_t question) {
    const std::scoped_lock lock(mutex_);
    forget(question);
    return questions_.erase(question) > 0;
}

void Questions::status_changed() {
    const std::scoped_lock lock(mutex_);
    // Who has not looked yet will see the newest one.
    if (std::ranges::none_of(events_, [](const Event& e) { return e.kind == Event::Kind::status; }))
        add({Event::Kind::status, 0});
}

std::optional<Questions::Event> Questions::next(double timeout_s) {
    std::unique_lock lock(mutex_);
    came_.wait_for(lock, std::chrono::duration<double>(timeout_s),
                   [&] { return !events_.empty(); });
    if (events_.empty())
        return std::nullopt;
    const Event event = events_.front();
    events_.pop_front();
    show();
    return event;
}

bool Questions::has_event() const {
    const std::scoped_lock lock(mutex_);
    return !events_.empty();
}

Result<int> Questions::descriptor() {
    const std::scoped_lock lock(mutex_);
    if (descriptor_ < 0) {
        descriptor_ = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
        if (descriptor_ < 0)
            return failed(Failure::none,
                          fmt::format("no descriptor to wait for: {}", std::strerror(errno)));
        show();
    }
    return descriptor_;
}

std::size_t Questions::open_count() const {
    const std::scoped_lock lock(mutex_);
    return questions_.size();
}

void Questions::add(Event event) {
    events_.push_back(event);
    show();
    came_.notify_one();
}

void Questions::forget(std::uint64_t question) {
    std::erase_if(events_, [&](const Event& event) {
        return event.kind == Event::Kind::answered && event.question == question;
    });
    show();
}

void Questions::show() {
    const bool waiting = !events_.empty();
    if (descriptor_ < 0 || waiting == shown_)
        return;
    eventfd_t value = 0;
    const int done =
        waiting ? ::eventfd_write(descriptor_, 1) : ::eventfd_read(descriptor_, &value);
    shown_ = done == 0 ? waiting : shown_;
}

} // namespace seaway::client
