// SPDX-License-Identifier: Apache-2.0
// Client: what was subscribed to is, again, once a connection has come back (decision 0045). On the keeper's thread; of a client
// without threads in turns.
#include <utility>

#include "client/again.h"
#include "client/client.h"
#include "client/link/failure.h"

namespace seaway::client {

using std::chrono::steady_clock;

steady_clock::time_point Client::subscribes_next_held() const {
    if (!resuming_)
        return steady_clock::time_point::max();
    return again_ ? again_->due() : steady_clock::time_point::min();
}

void Client::subscribe_again(std::unique_lock<std::mutex>& lock) {
    if (!again_)
        again_ = std::make_unique<Again>(pauses_);
    lock.unlock();
    const std::optional<Error> no_tiles = step_again(subscription_, again_->tiles);
    const std::optional<Error> no_waves = step_again(spectrum_subscription_, again_->waves);
    lock.lock();
    if (joining_->end) // and all that was asked for has failed with it
        return;
    if (!note_subscribed(no_tiles ? no_tiles : no_waves))
        return;
    lock.unlock();
    say_status();
    lock.lock();
}

bool Client::note_subscribed(const std::optional<Error>& missed) {
    bool other = false;
    if (missed && status_.reason != missed->message) {
        status_.reason = missed->message;
        other = true;
    }
    if (status_.state != LinkState::connected && again_->is_connected()) {
        status_.state = LinkState::connected;
        pauses_.connected();
        other = true;
    }
    if (again_->is_done()) {
        resuming_ = false;
        again_.reset();
    }
    return other;
}

template <class Kind>
std::optional<Error> Client::step_again(Kept<Kind>& kept, RungAgain<Kind>& rung) {
    if (rung.due() > steady_clock::now())
        return std::nullopt;
    if (!rung.answer) {
        if (!ask_as_before(kept, rung))
            rung.state = RungState::unwanted;
        return std::nullopt;
    }
    Waiter answer = *std::exchange(rung.answer, std::nullopt);
    const Result<RungState> stands = take_again(kept, rung.asked, answer.wait());
    if (stands) {
        rung.state = *stands;
        return std::nullopt;
    }
    rung.state = RungState::missed;
    rung.next = steady_clock::now() +
                std::chrono::ceil<steady_clock::duration>(rung.pauses.next(stands.error()));
    return stands.error();
}

template <class Kind>
bool Client::ask_as_before(const Kept<Kind>& kept, RungAgain<Kind>& rung) {
    Waiter answer;
    const std::scoped_lock asking(asking_);
    std::unique_lock lock(mutex_);
    rung.asked = kept.wanted_one();
    lock.unlock();
    if (!rung.asked.wish)
        return false;
    // Who keeps the client waits for answers to several questions at once.
    const auto told = [this, handler = answer.handler()](Result<Reply> reply) {
        handler(std::move(reply));
        const std::scoped_lock heard(mutex_);
        changed_.notify_all();
    };
    ask_for(*link(), *rung.asked.wish, told);
    rung.answer = std::move(answer);
    return true;
}

template <class Kind>
Result<RungState> Client::take_again(Kept<Kind>& kept, const typename Kept<Kind>::One& asked,
                                     const Result<Reply>& reply) {
    const auto had = granted(*asked.wish, reply);
    const std::scoped_lock lock(asking_, mutex_);
    if (had)
        kept.granted(asked.serial, *asked.wish);
    else if (had.error().is(Failure::refused)) // where it is lost it is asked for again
        kept.failed(asked.serial, *asked.wish, had.error());
    if (kept.is_over(asked.serial))
        return RungState::unwanted;
    return had ? Result<RungState>(RungState::granted) : had.error();
}

} // namespace seaway::client
