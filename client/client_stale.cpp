// SPDX-License-Identifier: Apache-2.0
// Client: what it means for answers that nothing is heard of the server, or that it never told of their seas.
#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "client/client.h"

namespace seaway::client {

using sea::TimeUs;

namespace {

/// A server answers pings each second; whose third is missing is silent.
constexpr LocalUs silent_us = 3'000'000;

} // namespace

bool Client::silent(LocalUs now_us) const {
    return joining_->end || unsure_ || now_us - heard_at_us_ > silent_us;
}

KnownSea Client::known_held(const SeaState& state) const {
    // The sea that it was told of first may have been forgotten since.
    KnownSea known{std::max(told_from_us_, sea_states_.front()->start_time_us),
                   state.start_time_us};
    if (const auto seen = seen_until_us_.find(state.epoch); seen != seen_until_us_.end())
        known.seen_until_us = seen->second;
    return known;
}

KnownSea Client::known_sea(TimeUs time_us) const {
    const std::scoped_lock lock(mutex_);
    return known_held(*sea_state_held(time_us));
}

bool Client::is_told_held(TimeUs time_us) const {
    const KnownSea known = known_held(*sea_state_held(time_us));
    return missed_.contains(time_us) ? known.was_seen(time_us) : known.has(time_us);
}

bool Client::knows_sea_of(TimeUs time_us) const {
    const std::scoped_lock lock(mutex_);
    return is_told_held(time_us) &&
           (missed_.contains(time_us) ||
            time_us <= told_until_us(*sea_state_held(heard_us_), heard_us_));
}

void Client::note_seen(std::span<const std::pair<TimeUs, SeaStatePtr>> seas) {
    const std::scoped_lock lock(mutex_);
    for (const auto& [time_us, state] : seas) {
        // What is to come may be changed yet. A state may have been forgotten meanwhile.
        if (time_us > heard_us_ || sea_state_held(time_us)->epoch != state->epoch)
            continue;
        TimeUs& until_us =
            seen_until_us_.try_emplace(state->epoch, std::numeric_limits<TimeUs>::min())
                .first->second;
        if (time_us <= until_us)
            continue;
        until_us = time_us;
        ++times_seen_;
    }
}

void Client::mark_stale(std::span<const sea::QueryPoint> points, std::span<sea::Answer> answers,
                        std::span<sea::ErrorTerms> terms, std::span<double> moved_off_m) const {
    std::array<Unheard, 2> unheard; // what was missed once, and the silence of now
    {
        const std::scoped_lock lock(mutex_);
        unheard[0] = missed_;
        if (silent(local_now_us()))
            unheard[1] = {heard_us_};
    }
    mark(unheard, points, answers, terms, moved_off_m);
}

void Client::mark_unsure(std::span<const sea::QueryPoint> points,
                         std::span<sea::Answer> answers) const {
    Unheard unheard;
    {
        const std::scoped_lock lock(mutex_);
        if (!unsure_)
            return;
        unheard.from_us = heard_us_;
    }
    mark({&unheard, 1}, points, answers);
}

void Client::mark(std::span<const Unheard> unheard, std::span<const sea::QueryPoint> points,
                  std::span<sea::Answer> answers, std::span<sea::ErrorTerms> terms,
                  std::span<double> moved_off_m) const {
    for (std::size_t i = 0; i < points.size(); ++i) {
        TimeUs from_us = std::numeric_limits<TimeUs>::max();
        for (const Unheard& span : unheard)
            if (span.contains(points[i].time_us) &&
                !(span.missed && known_sea(points[i].time_us).was_seen(points[i].time_us)))
                from_us = std::min(from_us, span.from_us);
        if (from_us == std::numeric_limits<TimeUs>::max())
            continue;
        answers[i].flags |= sea::answer_stale;
        if (answers[i].flags & sea::answer_invalid)
            continue;
        const SeaStatePtr state = sea_state(points[i].time_us);
        const double stale_m = stale_error_m(*state, from_us, points[i].time_us);
        answers[i].error_m += stale_m;
        if (!terms.empty())
            terms[i].stale_m = stale_m;
        if (!moved_off_m.empty())
            moved_off_m[i] += stale_displacement_error_m(*state, from_us, points[i].time_us);
    }
}

} // namespace seaway::client
