// SPDX-License-Identifier: Apache-2.0
// Client: whose waves it has, and what sea follows of them.
#include "client/client.h"

namespace seaway::client {

using sea::TimeUs;

OwnSeaPtr Client::own_sea(const SeaStatePtr& state) const {
    const std::scoped_lock lock(mutex_);
    return own_sea_held(state);
}

std::uint32_t Client::epoch_of_waves_held(const SeaState& steady) const {
    if (has_waves_held(steady.epoch))
        return steady.epoch;
    // Its waves are those that the last glide before it led to. One that this took over from may have been meant to end then, too.
    std::uint32_t led_to = steady.epoch;
    for (const SeaStatePtr& other : sea_states_) // in the order in which they begin
        if (other->glide && other->glide->end_us == steady.start_time_us)
            led_to = other->epoch;
    return led_to;
}

bool Client::has_waves_held(std::uint32_t epoch) const {
    const auto found = received_.find(epoch);
    return found != received_.end() && found->second->has_come();
}

namespace {

/// A glide whose end is reached then: the waves of its epoch are all that counts.
bool has_ended_by(const SeaState& glide, TimeUs time_us) {
    return glide.glide && glide.glide->end_us <= time_us;
}

} // namespace

bool Client::holds_waves_held(const SeaStatePtr& state, int depth) const {
    if (rebuilt_.contains(state->epoch))
        return true;
    if (!state->glide)
        return has_waves_held(epoch_of_waves_held(*state));
    const SeaStatePtr before = sea_state_held(state->start_time_us - 1);
    if (!has_waves_held(state->epoch) || depth == 0 || before == state)
        return false;
    return has_ended_by(*before, state->start_time_us) ? has_waves_held(before->epoch)
                                                       : holds_waves_held(before, depth - 1);
}

OwnSeaPtr Client::own_sea_held(const SeaStatePtr& state, int depth) const {
    if (const auto found = rebuilt_.find(state->epoch); found != rebuilt_.end())
        return found->second;
    const auto received = [&](std::uint32_t epoch) -> OwnSeaPtr {
        const auto found = received_.find(epoch);
        return found == received_.end() ? nullptr : found->second->sea();
    };
    if (!state->glide)
        return received(epoch_of_waves_held(*state));
    const OwnSeaPtr waves = received(state->epoch);
    const SeaStatePtr before = sea_state_held(state->start_time_us - 1);
    if (!waves || depth == 0 || before == state)
        return nullptr;
    const OwnSeaPtr from = has_ended_by(*before, state->start_time_us)
                               ? received(before->epoch)
                               : own_sea_held(before, depth - 1);
    if (!from)
        return nullptr;
    Glide& glide = glides_[state->epoch];
    if (glide.from != from || glide.to != waves) {
        const auto made =
            GlidingSea::create(*state, *from, *waves, state->start_time_us, state->glide->end_us);
        glide = {from, waves, made ? *made : nullptr};
    }
    return glide.sea;
}

} // namespace seaway::client
