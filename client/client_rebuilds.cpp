// SPDX-License-Identifier: Apache-2.0
// Client: seas that it makes of the scenes that the server sent, and the changes that begin on them (decision 0037).
#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "client/client.h"
#include "client/link/failure.h"
#include "client/wave_room.h"

namespace seaway::client {

using sea::TimeUs;

namespace {

/// Who looks back looks no further than that.
constexpr TimeUs followed_for_us = 60'000'000;
/// Seas that are made at once; of a gale 5 to 7 MB each.
constexpr std::size_t rebuilt_max = 16;

} // namespace

Result<void> Client::rebuild(TimeUs time_us) {
    SEAWAY_TRY(check_time(time_us));
    const std::scoped_lock turn(rebuilding_);
    return rebuild(sea_state(time_us), glides_chained_max);
}

Result<void> Client::rebuild(const SeaStatePtr& state, int depth) {
    {
        const std::scoped_lock lock(mutex_);
        if (waves_held(state).made)
            return {};
    }
    const Result<OwnSeaPtr> before = state->glide ? rebuild_before(state, depth) : OwnSeaPtr();
    const sea::RealizationPtr waves =
        before && *before ? (*before)->waves_at(state->start_time_us) : nullptr;
    const Result<RebuiltSeaPtr> made = rebuild_from_scene(*state, waves.get());
    if (made)
        keep_made(state, *made);
    if (!before) // and where a glide leads may be known all the same
        return before.error();
    return made ? Result<void>() : made.error();
}

Result<OwnSeaPtr> Client::rebuild_before(const SeaStatePtr& glide, int depth) {
    const auto here = [&]() -> OwnSeaPtr {
        WavesOf of;
        {
            const std::scoped_lock lock(mutex_);
            of = waves_before_held(glide, depth);
        }
        return own_sea(of);
    };
    const TimeUs before_us = glide->start_time_us - 1;
    const SeaStatePtr before = sea_state(before_us);
    const bool told = [&] {
        const std::scoped_lock lock(mutex_);
        return is_told_held(before_us);
    }();
    if (!told || before == glide || depth == 0)
        return failed(Failure::not_held,
                      fmt::format("the sea changes from {:g} s on, and from what is not known "
                                  "here: hold a time before that",
                                  sea::seconds_from_us(glide->start_time_us)));
    if (OwnSeaPtr sea = here())
        return sea;
    const Result<void> made = rebuild(before, depth - 1);
    if (OwnSeaPtr sea = here())
        return sea;
    return made ? failed(Failure::not_held, "the sea was changed meanwhile") : made.error();
}

SeaStatePtr Client::to_follow_held() const {
    const auto found = std::ranges::find_if(sea_states_, [this](const SeaStatePtr& state) {
        return state->glide && !rebuilt_.contains(state->epoch) &&
               !followed_.contains(state->epoch) && is_told_held(state->start_time_us - 1) &&
               waves_before_held(state).made;
    });
    return found == sea_states_.end() ? nullptr : *found;
}

void Client::keep_made(const SeaStatePtr& state, const RebuiltSeaPtr& made) {
    const std::scoped_lock lock(mutex_);
    if (std::ranges::find(sea_states_, state) == sea_states_.end()) // replaced meanwhile
        return;
    rebuilt_[state->epoch] = made;
    changed_.notify_all(); // what begins on it may have been announced
    if (rebuilt_.size() <= rebuilt_max)
        return;
    const auto furthest = std::ranges::max_element(rebuilt_, {}, [&](const auto& one) {
        return one.first == state->epoch ? -1.0 : away_us(sea_states_, heard_us_, one.first);
    });
    rebuilt_.erase(furthest);
}

void Client::follow(std::unique_lock<std::mutex>& lock, const SeaState& glide) {
    followed_.insert(glide.epoch); // once, whatever comes of it
    const TimeUs start_us = glide.start_time_us;
    lock.unlock();
    (void)rebuild(start_us); // what cannot be made is answered from tiles, or not at all
    lock.lock();
    // The last that is over is the sea that runs; what led to it goes.
    TimeUs last_us = std::numeric_limits<TimeUs>::min();
    const auto is_over = [&](const SeaStatePtr& state) {
        return state->glide && followed_.contains(state->epoch) &&
               state->glide->end_us + followed_for_us < heard_us_;
    };
    for (const SeaStatePtr& state : sea_states_)
        if (is_over(state))
            last_us = std::max(last_us, state->start_time_us);
    for (const SeaStatePtr& state : sea_states_)
        if (is_over(state) && state->start_time_us < last_us)
            rebuilt_.erase(state->epoch);
}

} // namespace seaway::client
