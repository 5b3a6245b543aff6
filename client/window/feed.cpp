// SPDX-License-Identifier: Apache-2.0
#include "client/window/feed.h"

#include <algorithm>
#include <thread>

#include "client/link/reconnect.h"
#include "client/view/sea/sea_source.h"

namespace seaway::client {

namespace {

using Clock = std::chrono::steady_clock;

/// A window shows the sea of now, or of a late frame.
constexpr sea::TimeUs look_back_us = 1'000'000;

Link link_of(LinkState state) {
    switch (state) {
    case LinkState::connected:
        return Link::live;
    case LinkState::waiting:
        return Link::waiting;
    case LinkState::connecting:
        return Link::connecting;
    case LinkState::stopped:
        break;
    }
    return Link::stopped;
}

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
    const std::shared_ptr<Client> client = std::move(state_->client);
    lock.unlock(); // for its events
}

std::shared_ptr<Client> Feed::client() const {
    const std::scoped_lock lock(state_->mutex);
    return state_->client;
}

FeedStatus Feed::status() const {
    std::unique_lock lock(state_->mutex);
    FeedStatus status = state_->status;
    status.keyframes = state_->counts->keyframes;
    status.bytes = state_->counts->bytes;
    if (status.link == Link::waiting)
        status.next_s =
            std::max(std::chrono::duration<double>(state_->next - Clock::now()).count(), 0.0);
    const std::shared_ptr<Client> client = state_->client;
    lock.unlock();
    if (!client)
        return status;
    const ClientStatus now = client->status();
    status.link = link_of(now.state);
    status.reason = now.reason;
    status.next_s = now.next_attempt_s;
    status.connections = now.connections;
    status.grant = client->grant().value_or(Grant{});
    return status;
}

/// From here on the client goes on by itself.
Result<std::shared_ptr<Client>> Feed::first_connection(const std::shared_ptr<State>& state) {
    ClientEvents events;
    events.on_keyframe = [counts = state->counts](const HeldKeyframePtr& keyframe) {
        ++counts->keyframes;
        counts->bytes += keyframe->keyframe().values.size() * sizeof(float);
    };
    SEAWAY_TRY_LET(std::shared_ptr<Client> client,
                   Client::connect(state->options, std::move(events),
                                   {.as_splines = true, .look_back_us = look_back_us}));
    protocol::TileWish wish{.fields = drawn_fields};
    state->limits.put_into(wish);
    SEAWAY_TRY(client->subscribe(wish, credit, state->options.timeout_s));
    return client;
}

void Feed::run(const std::shared_ptr<State>& state) {
    ReconnectPauses pauses;
    std::unique_lock lock(state->mutex);
    while (!state->stop && !state->client) {
        state->status.link = Link::connecting;
        lock.unlock();
        Result<std::shared_ptr<Client>> client = first_connection(state);
        lock.lock();
        if (client) {
            state->client = std::move(*client);
            break;
        }
        state->status.link = Link::waiting;
        state->status.reason = client.error().message;
        state->next =
            Clock::now() + std::chrono::ceil<Clock::duration>(pauses.next(client.error()));
        state->changed.wait_until(lock, state->next, [&] { return state->stop; });
    }
    state->ended = true;
    state->changed.notify_all();
}

} // namespace seaway::client
