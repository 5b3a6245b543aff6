// SPDX-License-Identifier: Apache-2.0
#include "client/window/feed.h"

#include <algorithm>
#include <thread>

#include "client/link/reconnect.h"
#include "client/view/sea/sea_source.h"

namespace seaway::client {

namespace {

using Clock = std::chrono::steady_clock;

/// A window shows the sea of now: around it lie what is sent ahead and the keyframes of a late frame.
constexpr sea::TimeUs reach_us = 1'000'000;

std::chrono::duration<double> seconds(double s) {
    return std::chrono::duration<double>(s);
}

} // namespace

Feed::Feed(const ConnectOptions& options, const TileLimits& limits)
    : state_(std::make_shared<State>()) {
    state_->options = options;
    state_->limits = limits;
    std::thread([state = state_] { run(state); }).detach();
}

Feed::~Feed() {
    std::unique_lock lock(state_->mutex);
    state_->stop = true;
    state_->changed.notify_all();
    state_->changed.wait_for(lock, seconds(0.3), [&] { return state_->ended; });
    state_->client.reset();
}

std::shared_ptr<Client> Feed::client() const {
    const std::scoped_lock lock(state_->mutex);
    return state_->client;
}

FeedStatus Feed::status() const {
    const std::scoped_lock lock(state_->mutex);
    FeedStatus status = state_->status;
    status.keyframes = state_->keyframes;
    status.bytes = state_->bytes;
    if (status.link == Link::waiting)
        status.next_s =
            std::max(std::chrono::duration<double>(state_->next - Clock::now()).count(), 0.0);
    return status;
}

/// Returns why it has ended, or could not begin.
Error Feed::one_connection(const std::shared_ptr<State>& state) {
    ClientEvents events;
    events.on_keyframe = [state = state.get()](const HeldKeyframePtr& keyframe) {
        ++state->keyframes;
        state->bytes += keyframe->keyframe().values.size() * sizeof(float);
    };
    Result<std::unique_ptr<Client>> made = Client::connect(
        state->options, std::move(events), {.reach_us = reach_us, .as_splines = true});
    if (!made)
        return made.error();
    const std::shared_ptr<Client> client = std::move(*made);
    protocol::TileWish wish{.fields = drawn_fields};
    state->limits.put_into(wish);
    const Result<Grant> grant = client->subscribe(wish, credit, state->options.timeout_s);
    if (!grant)
        return grant.error();
    std::unique_lock lock(state->mutex);
    std::shared_ptr<Client> before = std::exchange(state->client, client);
    state->status.link = Link::live;
    state->status.grant = *grant;
    ++state->status.connections;
    lock.unlock();
    before.reset(); // waits for its connection's thread
    lock.lock();
    while (!state->stop && !client->end())
        state->changed.wait_for(lock, seconds(0.1));
    return client->end().value_or(Error{"the window closes"});
}

void Feed::run(const std::shared_ptr<State>& state) {
    ReconnectPauses pauses;
    std::unique_lock lock(state->mutex);
    while (!state->stop) {
        const int connections = state->status.connections;
        state->status.link = Link::connecting;
        lock.unlock();
        const Error ended = one_connection(state);
        lock.lock();
        if (state->status.connections > connections)
            pauses.connected();
        state->status.link = Link::waiting;
        state->status.reason = ended.message;
        state->next = Clock::now() + std::chrono::ceil<Clock::duration>(pauses.next(ended));
        state->changed.wait_until(lock, state->next, [&] { return state->stop; });
    }
    state->ended = true;
    state->changed.notify_all();
}

} // namespace seaway::client
