// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/slice.h"

#include <chrono>
#include <new>
#include <system_error>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "server/host/refusal.h"

namespace seaway::server {

namespace {

Error busy(std::string why) {
    Error error{Refusal::busy, std::move(why)};
    error.retry_after_ms = 1000;
    return error;
}

void refuse_surely(const Question& question, const Error& why) {
    for (int attempt = 0; attempt < 100; ++attempt) {
        try {
            return question.refuse(why);
        } catch (const std::bad_alloc&) { // others give some back soon
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
    }
}

bool answered(Questions& questions, Question& question) {
    using Clock = std::chrono::steady_clock;
    const Clock::time_point start = Clock::now();
    bool done = true;
    try {
        done = question.slice();
    } catch (const std::bad_alloc&) {
        refuse_surely(question, busy("there is no memory for this now, try again later"));
    } catch (const std::system_error& error) { // a thread that could not be started
        refuse_surely(question, busy(fmt::format("the system gives no more: {}, try again later",
                                                 error.code().message())));
    }
    questions.spent(question,
                    std::chrono::duration<double, std::micro>(Clock::now() - start).count());
    return done;
}

} // namespace

void work_on_slice(Questions& questions, Question question) {
    if (question.asker.gone())
        question.refuse({Refusal::gone, "nobody waits for the answer"});
    else if (!answered(questions, question))
        return questions.put_back(std::move(question));
    questions.over(question);
}

} // namespace seaway::server
