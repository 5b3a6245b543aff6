// SPDX-License-Identifier: Apache-2.0
#include "client/held_surfaces.h"

#include <algorithm>

namespace seaway::client {

namespace {

bool made_of(const sea::Surface& surface, const HeldPairs& held) {
    return std::ranges::equal(
        surface.pairs(), held.pairs, [](const sea::SplinePair& made, const KeyframePair& pair) {
            return made.before == pair.before->spline() && made.after == pair.after->spline();
        });
}

/// A keyframe that stands alone is right at its own time, and at no other of those that no keyframe lies between.
TimeSpan times_of(const HeldPairs& held, const SeaState& state, sea::TimeUs time_us) {
    const bool alone = std::ranges::any_of(held.pairs, [](const KeyframePair& pair) {
        return !pair.covers || pair.before == pair.after;
    });
    return alone ? TimeSpan{time_us, time_us + 1} : cell_span(state, time_us);
}

} // namespace

TimeSpan TimeSpan::within(const TimeSpan& other) const {
    return {std::max(from_us, other.from_us), std::min(until_us, other.until_us)};
}

TimeSpan cell_span(const SeaState& state, sea::TimeUs time_us) {
    const TimeCell cell = time_cell(state, time_us);
    TimeSpan span;
    for (std::size_t c = 0; c < cell.size(); ++c) {
        const sea::TimeUs interval_us = state.cascades[c].interval_us;
        span = span.within({cell[c] * interval_us, (cell[c] + 1) * interval_us});
    }
    return span;
}

HeldSurfaces::Lent::~Lent() {
    give_back();
}

void HeldSurfaces::Lent::give_back() {
    if (place_)
        place_->users.fetch_sub(1, std::memory_order_release);
    place_ = nullptr;
    own_.reset();
}

bool HeldSurfaces::fits(const Place& place, const SeaStatePtr& state, sea::TimeUs time_us,
                        sea::FieldSet fields, std::uint32_t cascades) {
    if (!place.local || place.state != state || place.fields != fields ||
        place.cascades != cascades || !place.times.contains(time_us))
        return false;
    const sea::Choppiness& made = place.local->surface.choppiness();
    return made.x == state->choppiness_x_at(time_us) && made.y == state->choppiness_y_at(time_us);
}

void HeldSurfaces::take(Place& place, Lent& lent) {
    place.users.fetch_add(1, std::memory_order_relaxed);
    place.last_used = ++uses_;
    lent.place_ = &place;
}

bool HeldSurfaces::find(const SeaStatePtr& state, const KeyframeRing& ring, sea::TimeUs time_us,
                        sea::FieldSet fields, Lent& lent, std::uint32_t cascades) {
    lent.give_back();
    const std::uint64_t changes = ring.changes();
    const std::scoped_lock lock(mutex_);
    for (Place& place : places_)
        if (place.ring_changes == changes && fits(place, state, time_us, fields, cascades)) {
            take(place, lent);
            return true;
        }
    return false;
}

Result<void> HeldSurfaces::lend(const SeaStatePtr& state, const KeyframeRing& ring,
                                sea::TimeUs time_us, sea::FieldSet fields, Lent& lent,
                                std::uint32_t cascades) {
    const std::uint64_t changes = ring.changes(); // before the ring is looked at
    if (find(state, ring, time_us, fields, lent, cascades))
        return {};
    SEAWAY_TRY_LET(const HeldPairs held, held_pairs(*state, ring, time_us, fields, cascades));
    const std::scoped_lock lock(mutex_);
    Place* oldest = nullptr;
    for (Place& place : places_) {
        if (fits(place, state, time_us, fields, cascades) && place.local->covers == held.covers &&
            made_of(place.local->surface, held)) {
            place.ring_changes = std::max(place.ring_changes, changes);
            take(place, lent);
            return {};
        }
        const bool idle = place.users.load(std::memory_order_acquire) == 0;
        if (idle && (!oldest || !place.local || place.last_used < oldest->last_used))
            oldest = &place;
    }
    LocalSurface made{surface_of(*state, time_us, held), held.covers};
    const TimeSpan times = times_of(held, *state, time_us);
    if (!oldest) {
        lent.own_.emplace(std::move(made));
        lent.own_times_ = times;
        return {};
    }
    oldest->state = state;
    oldest->fields = fields;
    oldest->cascades = cascades;
    oldest->times = times;
    oldest->ring_changes = changes;
    oldest->local.emplace(std::move(made));
    take(*oldest, lent);
    return {};
}

void HeldSurfaces::follow(const KeyframeRing& ring) {
    const std::scoped_lock lock(mutex_);
    for (Place& place : places_) {
        if (!place.local || place.users.load(std::memory_order_acquire) > 0)
            continue;
        const auto gone = [&](const sea::SplinePair& pair) {
            return !ring.holds(pair.before.get()) || !ring.holds(pair.after.get());
        };
        if (std::ranges::any_of(place.local->surface.pairs(), gone))
            place.local.reset();
    }
}

} // namespace seaway::client
