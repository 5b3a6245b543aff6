// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/answer_threads.h"

#include <algorithm>
#include <new>

#include "base/processors.h"
#include "base/stand_back.h"
#include "base/thread_name.h"
#include "server/simulation/slice.h"

namespace seaway::server {

int answer_threads_default() {
    constexpr int most = 4;
    return std::clamp(usable_processors(), 1, most);
}

void AnswerThreads::start(int threads) {
    for (int i = 0; i < threads; ++i) {
        Heartbeat& heartbeat = heartbeats_.emplace_back();
        threads_.emplace_back([this, &heartbeat] { work(heartbeat); });
    }
}

void AnswerThreads::join() {
    for (std::thread& thread : threads_)
        if (thread.joinable())
            thread.join();
}

void AnswerThreads::work(Heartbeat& heartbeat) {
    name_thread("sea-answers");
    while (std::optional<Question> question = questions_.take_to_answer()) {
        heartbeat.works();
        const bool prompt = question->prompt;
        try {
            work_on_slice(questions_, *std::move(question));
        } catch (const std::bad_alloc&) { // the question is lost
        }
        heartbeat.rests();
        if (!prompt)
            stand_back();
    }
}

Heartbeat::Clock::duration AnswerThreads::turn() const {
    Heartbeat::Clock::duration longest{};
    for (const Heartbeat& heartbeat : heartbeats_)
        longest = std::max(longest, heartbeat.turn());
    return longest;
}

} // namespace seaway::server
