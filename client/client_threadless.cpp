// SPDX-License-Identifier: Apache-2.0
// Client: one that makes no thread. What a connection's thread and the keeper do elsewhere is done here in turns, by whoever
// calls work_until() or waits for a reply (decision 0063).
#include <algorithm>

#include "client/client.h"
#include "client/link/waiter.h"

namespace seaway::client {

using std::chrono::steady_clock;

namespace {

/// A turn is no longer, so that who waits for another thread's reply sees it, and another thread has its turn.
constexpr std::chrono::milliseconds turn_max{20};

} // namespace

Result<Reply> Client::reply_of(Waiter& waiter) {
    if (threadless())
        work_until(steady_clock::time_point::max(), [&] { return waiter.ready(); });
    return waiter.wait();
}

void Client::rest_until(steady_clock::time_point until, const ConnectionPtr& connection) {
    const auto over = [&] { // mutex_ held
        return leaving_.stop_requested() || connection_ != connection || joining_->end;
    };
    if (threadless()) {
        work_until(until, [&] {
            const std::scoped_lock lock(mutex_);
            return over();
        });
        return;
    }
    std::unique_lock lock(mutex_);
    changed_.wait_until(lock, until, over);
}

bool Client::work_until(steady_clock::time_point until, const std::function<bool()>& done) {
    // Where another thread is at work nobody has to wait for it to see what has come.
    if (std::unique_lock working(working_, std::try_to_lock); working)
        work_held(steady_clock::time_point::min());
    for (;;) {
        if (done())
            return true;
        const auto now = steady_clock::now();
        if (now >= until)
            return false;
        work(std::min(until, now + turn_max));
    }
}

Result<int> Client::descriptor_with(int other) {
    SEAWAY_TRY(readiness_->add(other));
    return readiness_->descriptor();
}

void Client::work(steady_clock::time_point until) {
    const std::scoped_lock working(working_);
    work_held(until);
}

void Client::work_held(steady_clock::time_point until) {
    readiness_->clear();
    keep_turn();
    const bool opening = turn_ == Turn::opening;
    const ConnectionPtr at_work = opening ? coming_.connection : link();
    if (!watching_ && at_work->descriptor() >= 0)
        watching_ = readiness_->add(at_work->descriptor()).has_value();
    bool over = false;
    {
        const std::scoped_lock lock(mutex_);
        over = !opening && joining_->end.has_value();
    }
    if (over) // for the next attempt, or for nothing
        std::this_thread::sleep_until(until);
    else
        at_work->work(until);
    keep_turn();
}

void Client::keep_turn() {
    std::unique_lock lock(mutex_);
    const bool ended = joining_->end && !options_.stays_lost;
    switch (turn_) {
    case Turn::standing:
        if (ended) {
            status_.attempts = 0;
            return lose(lock, *joining_->end);
        }
        if (subscribes_next_held() <= steady_clock::now())
            subscribe_again(lock);
        return;
    case Turn::waiting:
        if (steady_clock::now() >= next_attempt_)
            begin_link(lock);
        return;
    case Turn::opening:
        return open_turn(lock);
    case Turn::stopped:
        return;
    }
}

void Client::lose(std::unique_lock<std::mutex>& lock, const Error& why) {
    note_wait(why);
    turn_ = status_.state == LinkState::stopped ? Turn::stopped : Turn::waiting;
    lock.unlock();
    say_status();
}

void Client::begin_link(std::unique_lock<std::mutex>& lock) {
    note_attempt();
    lock.unlock();
    say_status();
    const auto joining = std::make_shared<Joining>();
    ConnectOptions options = options_;
    options.stop = leaving_.get_token();
    auto begun = Connection::begin(options, connection_events(joining));
    lock.lock();
    if (!begun)
        return lose(lock, begun.error());
    watching_ = false;
    coming_ = {std::move(*begun), joining};
    turn_ = Turn::opening;
}

void Client::open_turn(std::unique_lock<std::mutex>& lock) {
    lock.unlock(); // what ends here ends with events
    const std::optional<Result<void>> opened = coming_.connection->opened();
    if (!opened)
        return;
    const Coming come = std::exchange(coming_, {});
    if (!*opened) {
        lock.lock();
        return lose(lock, opened->error());
    }
    adopt(come.connection, come.joining);
    lock.lock();
    turn_ = Turn::standing;
}

} // namespace seaway::client
