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
    step_again(subscription_, again_->tiles);
    step_again(spectrum_subscription_, again_->waves);
    lock.lock();
    if (joining_->end) // and all that was asked for has failed with it
        return;
    if (!note_subscribed())
        return;
    lock.unlock();
    say_status();
    lock.lock();
}

bool Client::note_subscribed() {
    const Error* missed = again_->why_missed();
    bool other = missed != nullptr && status_.reason != missed->message;
    if (other)
        status_.reason = missed->message;
    if (status_.state != LinkState::connected && again_->is_connected()) {
        status_.state = LinkState::connected;
        pauses_.connected();
        other = true;
    }
    if (again_->is_done()) {
        other = other || again_->has_missed();
        resuming_ = false;
        again_.reset();
    }
    return other;
}

template <class Kind>
void Client::step_again(Kept<Kind>& kept, RungAgain<Kind>& rung) {
    if (rung.due() > steady_clock::now())
        return;
    if (!rung.answer) {
        if (const std::optional<RungState> stands = ask_as_before(kept, rung))
            rung.state = *stands;
        return;
    }
    Waiter answer = *std::exchange(rung.answer, std::nullopt);
    const Result<RungState> stands = take_again(kept, rung, answer.wait());
    rung.state = stands ? *stands : RungState::missed;
    if (stands)
        return;
    rung.why_missed = stands.error();
    rung.next = steady_clock::now() +
                std::chrono::ceil<steady_clock::duration>(rung.pauses.next(stands.error()));
}

template <class Kind>
std::optional<RungState> Client::ask_as_before(const Kept<Kind>& kept, RungAgain<Kind>& rung) {
    Waiter answer;
    const std::scoped_lock asking(asking_);
    std::unique_lock lock(mutex_);
    rung.asked = kept.wanted_one();
    rung.connection = status_.connections;
    const bool is_granted = kept.is_granted_on(rung.connection); // to who asked meanwhile
    lock.unlock();
    if (!rung.asked.wish)
        return RungState::unwanted;
    if (is_granted)
        return RungState::granted;
    // Who keeps the client waits for answers to several questions at once.
    const auto told = [this, handler = answer.handler()](Result<Reply> reply) {
        handler(std::move(reply));
        const std::scoped_lock heard(mutex_);
        changed_.notify_all();
    };
    ask_for(*link(), *rung.asked.wish, told);
    rung.answer = std::move(answer);
    return std::nullopt;
}

template <class Kind>
Result<RungState> Client::take_again(Kept<Kind>& kept, const RungAgain<Kind>& rung,
                                     const Result<Reply>& reply) {
    const auto& asked = rung.asked;
    const auto had = granted(*asked.wish, reply);
    const std::scoped_lock lock(asking_, mutex_);
    if (had)
        kept.granted(asked.serial, *asked.wish, rung.connection);
    else if (had.error().is(Failure::refused)) // where it is lost it is asked for again
        kept.failed(asked.serial, *asked.wish, had.error());
    if (kept.is_over(asked.serial))
        return RungState::unwanted;
    return had ? Result<RungState>(RungState::granted) : had.error();
}

} // namespace seaway::client
