// SPDX-License-Identifier: Apache-2.0
#include "client/window/feed.h"

#include <algorithm>

#include "client/link/reconnect.h"
#include "client/view/sea/sea_source.h"
#include "protocol/limits.h"

namespace seaway::client {

namespace {

using Clock = std::chrono::steady_clock;

/// A window shows the sea of now, or of a late frame.
constexpr sea::TimeUs look_back_us = 1'000'000;

/// No window that is closed waits longer for its thread.
constexpr std::chrono::seconds patience{1};

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

} // namespace

Feed::Feed(const ConnectOptions& options, const TileLimits& limits)
    : state_(std::make_shared<State>()) {
    state_->options = options;
    state_->options.stop = leaving_.get_token();
    state_->limits = limits;
    thread_ = std::thread([state = state_] { run(state); });
}

Feed::~Feed() {
    std::unique_lock lock(state_->mutex);
    leaving_.request_stop();
    state_->changed.notify_all();
    const bool ended = state_->changed.wait_for(lock, patience, [&] { return state_->ended; });
    const std::shared_ptr<Client> client = std::move(state_->client);
    lock.unlock(); // for its events
    if (ended)
        thread_.join();
    else
        thread_.detach();
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
    SEAWAY_TRY(client->subscribe(wish, protocol::limits::credit_default, state->options.timeout_s));
    return client;
}

void Feed::run(const std::shared_ptr<State>& state) {
    ReconnectPauses pauses;
    std::unique_lock lock(state->mutex);
    const std::stop_token& stop = state->options.stop;
    while (!stop.stop_requested() && !state->client) {
        state->status.link = Link::connecting;
        lock.unlock();
        Result<std::shared_ptr<Client>> client = Error{"there is no memory for a connection"};
        try {
            client = first_connection(state);
        } catch (const std::bad_alloc&) {
        }
        lock.lock();
        if (client) {
            state->client = std::move(*client);
            break;
        }
        state->status.link = Link::waiting;
        state->status.reason = client.error().message;
        state->next =
            Clock::now() + std::chrono::ceil<Clock::duration>(pauses.next(client.error()));
        state->changed.wait_until(lock, state->next, [&] { return stop.stop_requested(); });
    }
    state->ended = true;
    state->changed.notify_all();
}

} // namespace seaway::client
