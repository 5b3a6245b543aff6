// SPDX-License-Identifier: Apache-2.0
#include "server/net/turns.h"

#include <new>
#include <utility>

namespace seaway::server {

void Turns::first(Work work) {
    first_ = std::move(work);
    ask_for_one();
}

void Turns::later(Work work) {
    waiting_.push_back(std::move(work));
    ask_for_one();
}

void Turns::go_on() {
    if (first_ || !waiting_.empty())
        ask_for_one();
}

void Turns::clear() {
    first_ = nullptr;
    waiting_.clear();
}

void Turns::ask_for_one() {
    if (std::exchange(asked_, true))
        return;
    try {
        post_([this] { turn(); });
    } catch (...) {
        asked_ = false;
        throw;
    }
}

void Turns::turn() {
    struct Ends { // also by an exception: the others have theirs all the same
        Turns& turns;
        ~Ends() {
            try {
                turns.asked_ = false;
                turns.go_on();
            } catch (const std::bad_alloc&) { // whoever comes next asks, or the server's watch
            }
        }
    } const ends{*this};
    begun_ = now_();
    if (const Work work = std::exchange(first_, nullptr))
        work();
    begun_ = now_();
    for (std::size_t left = waiting_.size(); left > 0;
         --left) { // what they ask for comes next time
        const Work work = std::move(waiting_.front());
        waiting_.pop_front();
        work();
        if (over())
            break;
    }
}

} // namespace seaway::server
