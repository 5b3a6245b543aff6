// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/slice.h"

#include <chrono>
#include <new>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "base/undo.h"
#include "server/host/refusal.h"

namespace seaway::server {

namespace {

bool answered(Questions& questions, Question& question, const std::function<bool()>& slice) {
    using Clock = std::chrono::steady_clock;
    const Clock::time_point start = Clock::now();
    bool done = true;
    try {
        done = slice();
    } catch (const std::bad_alloc&) {
        refuse_surely(question, no_memory);
    } catch (const std::system_error& error) { // a thread that could not be started
        refuse_surely(question, [&error] {
            return busy(fmt::format("the system gives no more: {}, try again later",
                                    error.code().message()));
        });
    }
    questions.spent(question,
                    std::chrono::duration<double, std::micro>(Clock::now() - start).count());
    return done;
}

bool done_or_lost(Questions& questions, Question& question, const std::function<bool()>& slice) {
    try {
        return answered(questions, question, slice);
    } catch (const std::bad_alloc&) {
        questions.over(question);
        throw;
    }
}

/// Whatever comes of it, the question is over.
template <class Why>
void refuse_and_end(Questions& questions, Question& question, const Why& why) {
    try {
        refuse_surely(question, why);
    } catch (const std::bad_alloc&) {
        questions.over(question);
        throw;
    }
    questions.over(question);
}

} // namespace

void work_on_slice(Questions& questions, Question question) {
    const bool gone = question.asker.gone();
    // At the end, when what it held is free: the turn of foam, for one.
    const Undo wakes([&] {
        if (gone)
            questions.wake();
    });
    Question mine = std::move(question);
    std::function<bool()> slice; // goes on when the question has been put back
    try {
        slice = mine.slice;
    } catch (const std::bad_alloc&) {
        return refuse_and_end(questions, mine, no_memory);
    }
    work_on_slice(questions, std::move(mine), slice);
}

void work_on_slice(Questions& questions, Question question, const std::function<bool()>& slice) {
    if (question.asker.gone())
        return refuse_and_end(questions, question, [] {
            return Error{Refusal::gone, "nobody waits for the answer"};
        });
    if (!done_or_lost(questions, question, slice))
        return questions.put_back(std::move(question));
    questions.over(question);
}

} // namespace seaway::server
