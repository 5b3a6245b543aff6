// SPDX-License-Identifier: Apache-2.0
#include "client/held/keyframe_ring.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <set>
#include <utility>

#include "base/check.h"
#include "protocol/limits.h"
#include "sea/surface/budget/error_budget.h"
#include "sea/surface/budget/spending.h"
#include "sea/surface/maps/regrid.h"

namespace seaway::client {

using sea::Field;
using sea::TimeUs;

namespace {

constexpr sea::FieldSet sampled_fields{Field::height, Field::height_rate};

/// No server has shorter ones.
TimeUs real_interval_us(TimeUs told_us) {
    return std::max(told_us, *std::ranges::min_element(sea::keyframe_intervals_us));
}

} // namespace

HeldKeyframe::HeldKeyframe(sea::Keyframe keyframe, const FieldErrors& errors,
                           const Compact& compact)
    : keyframe_(std::make_shared<const sea::Keyframe>(std::move(keyframe))),
      fields_(keyframe_->fields), errors_(errors), compact_(compact),
      compact_share_(compact.size > 0 ? sea::disc_share(compact.size) : 1.0) {}

double HeldKeyframe::coded_rms(Field field) const {
    return sea::rounded_rms(static_cast<double>(error(field))) *
           std::sqrt(compact_share_ * (follows(field) ? compact_.gain : 1.0));
}

bool HeldKeyframe::can_be_sampled() const {
    return fields_.contains(sampled_fields);
}

HeldKeyframePtr HeldKeyframe::as_spline(const HeldKeyframePtr& whole) {
    if (!whole->can_be_sampled())
        return whole;
    const sea::Keyframe& from = whole->keyframe();
    sea::Keyframe rest{from.epoch, from.cascade, from.time_us, from.size, from.length_m, {}, {}};
    for (const Field field : from.fields) {
        if (sea::surface_fields.contains(field))
            continue;
        rest.fields.insert(field);
        const std::span<const float> plane = from.plane(field);
        rest.values.insert(rest.values.end(), plane.begin(), plane.end());
    }
    const auto made =
        std::make_shared<HeldKeyframe>(std::move(rest), whole->errors_, whole->compact_);
    made->fields_ = whole->fields_;
    std::call_once(made->spline_once_, [&] { made->spline_ = whole->spline(); });
    made->splined_ = true;
    return made;
}

sea::SplineMapPtr HeldKeyframe::spline() const {
    std::call_once(spline_once_, [this] {
        spline_ = std::make_shared<const sea::SplineMap>(*keyframe_);
        splined_ = true;
    });
    return spline_;
}

std::size_t HeldKeyframe::bytes() const {
    return keyframe_->values.size() * sizeof(float) +
           (can_be_sampled() ? sea::SplineMap::bytes_of(keyframe_->size) : 0);
}

std::size_t HeldKeyframe::bytes_of(sea::FieldSet fields, int size) {
    const auto side = static_cast<std::size_t>(size);
    return static_cast<std::size_t>(fields.size()) * side * side * sizeof(float) +
           (fields.contains(sampled_fields) ? sea::SplineMap::bytes_of(size) : 0);
}

std::size_t RingLimits::room(std::size_t keyframe_bytes) const {
    const std::size_t by_bytes = bytes_per_cascade / std::max<std::size_t>(keyframe_bytes, 1);
    return std::min(std::max(by_bytes, keyframes_per_cascade_min), keyframes_per_cascade);
}

std::size_t RingLimits::more_passing(sea::TimeUs interval_us) const {
    if (look_back_us <= look_back_usual_us)
        return 0;
    // One for a part of an interval, and one before it. The least that are held are what is ahead, and now.
    return 2 + static_cast<std::size_t>(look_back_us / real_interval_us(interval_us));
}

std::size_t RingLimits::sent_ahead(TimeUs interval_us, double hurry) {
    const double lead_us = hurry * static_cast<double>(sea::publish_lead_us);
    const double ahead = std::ceil(lead_us / static_cast<double>(real_interval_us(interval_us)));
    return 3 + static_cast<std::size_t>(ahead); // the pair of now, and the one that comes
}

void KeyframeRing::insert(HeldKeyframePtr keyframe) {
    if (limits_.as_splines)
        keyframe = HeldKeyframe::as_spline(keyframe);
    const std::scoped_lock lock(mutex_);
    ++changes_;
    if (Cascade* cascade = take({std::move(keyframe), false}))
        make_room(*cascade);
}

void KeyframeRing::insert_passing(HeldKeyframePtr keyframe, TimeUs now_us, TimeUs interval_us,
                                  double hurry) {
    if (limits_.as_splines)
        keyframe = HeldKeyframe::as_spline(keyframe);
    const std::size_t more = limits_.more_passing(interval_us);
    const std::size_t least = std::max(
        RingLimits::keyframes_per_cascade_min,
        std::min(RingLimits::sent_ahead(interval_us, hurry),
                 RingLimits::ahead_bytes_max / std::max<std::size_t>(keyframe->bytes(), 1)));
    const std::scoped_lock lock(mutex_);
    ++changes_;
    Cascade* cascade = take({std::move(keyframe), true});
    if (!cascade)
        return;
    let_pass(*cascade, now_us);
    drop_maps_of_splines();
    make_room(*cascade);
    const TimeUs ahead_us = std::llround(hurry * static_cast<double>(sea::publish_lead_us));
    make_room_around(*cascade, now_us, {now_us - interval_us, now_us + ahead_us + 2 * interval_us},
                     {std::max(limits_.keyframes_per_cascade, least) + more, least + more});
}

KeyframeRing::Cascade* KeyframeRing::take(Held fresh_held) {
    const HeldKeyframePtr& keyframe = fresh_held.keyframe;
    const sea::Keyframe& fresh = keyframe->keyframe();
    SEAWAY_CHECK(fresh.cascade >= 0 && fresh.cascade < protocol::limits::cascades_max,
                 "the cascade of a keyframe is checked when its tiles are read");
    const auto index = static_cast<std::size_t>(fresh.cascade);
    if (cascades_.size() <= index)
        cascades_.resize(index + 1);
    Cascade& cascade = cascades_[index];
    const auto same = [&](const Held& held) {
        return held.keyframe->keyframe().time_us == fresh.time_us &&
               held.keyframe->keyframe().epoch == fresh.epoch;
    };
    for (auto at = cascade.by_arrival.begin(); at != cascade.by_arrival.end();) {
        const sea::FieldSet held = at->keyframe->fields(), come = keyframe->fields();
        if (!same(*at) || (!held.contains(come) && !come.contains(held))) {
            ++at;
            continue;
        }
        at->passes = at->passes && fresh_held.passes; // what was asked for stays so
        if (held.contains(come) && held != come)
            return nullptr;
        fresh_held.passes = at->passes;
        cascade.bytes -= at->keyframe->bytes();
        at = cascade.by_arrival.erase(at);
    }
    cascade.bytes += keyframe->bytes();
    cascade.by_arrival.push_back(std::move(fresh_held));
    return &cascade;
}

void KeyframeRing::let_pass(Cascade& cascade, TimeUs now_us) {
    const TimeUs needed_from_us = now_us - limits_.look_back_us;
    // Of each epoch the last one at or before that time is needed, but where nothing of it follows and a later epoch has begun.
    std::map<std::uint32_t, TimeUs> oldest_us;
    std::set<std::uint32_t> goes_on;
    for (const Held& held : cascade.by_arrival) {
        const sea::Keyframe& keyframe = held.keyframe->keyframe();
        if (keyframe.time_us > needed_from_us) {
            goes_on.insert(keyframe.epoch);
            continue;
        }
        TimeUs& latest_us = oldest_us.try_emplace(keyframe.epoch, keyframe.time_us).first->second;
        latest_us = std::max(latest_us, keyframe.time_us);
    }
    const auto left_behind = [&](const sea::Keyframe& old) {
        const auto oldest = oldest_us.find(old.epoch);
        if (oldest == oldest_us.end() || old.time_us > needed_from_us)
            return false;
        const bool is_over = !goes_on.contains(old.epoch) && oldest_us.rbegin()->first > old.epoch;
        return is_over || old.time_us < oldest->second;
    };
    for (auto at = cascade.by_arrival.begin();
         at != cascade.by_arrival.end() &&
         cascade.by_arrival.size() > RingLimits::passing_per_cascade_min;) {
        const sea::Keyframe& keyframe = at->keyframe->keyframe();
        const bool far = keyframe.time_us - now_us > RingLimits::ahead_max_us;
        if (!at->passes || (!far && !left_behind(keyframe))) {
            ++at;
            continue;
        }
        cascade.bytes -= at->keyframe->bytes();
        at = cascade.by_arrival.erase(at);
    }
}

void KeyframeRing::drop_maps_of_splines() {
    for (Cascade& cascade : cascades_)
        for (Held& held : cascade.by_arrival) {
            if (!held.keyframe->has_spline() || !held.keyframe->has_maps())
                continue;
            cascade.bytes -= held.keyframe->bytes();
            held.keyframe = HeldKeyframe::as_spline(held.keyframe);
            cascade.bytes += held.keyframe->bytes();
        }
}

void KeyframeRing::make_room(Cascade& cascade) {
    const auto first_to_come = [](const Held&, const Held&) { return false; };
    drop(cascade, false, {limits_.keyframes_per_cascade, RingLimits::keyframes_per_cascade_min},
         first_to_come);
}

// The furthest from now goes first, but what has been before what a server sends ahead. A stream that is sent further ahead than
// that leaves out some of what comes, and never what is now.
void KeyframeRing::make_room_around(Cascade& cascade, TimeUs now_us, const Span& needed,
                                    const Room& room) {
    const auto away = [&](const Held& held) {
        const TimeUs time_us = held.keyframe->keyframe().time_us;
        const bool is_needed = time_us >= needed.from_us && time_us <= needed.to_us;
        return std::pair(!is_needed, std::abs(time_us - now_us));
    };
    drop(cascade, true, room, [&](const Held& a, const Held& b) { return away(a) > away(b); });
}

template <class Sooner>
void KeyframeRing::drop(Cascade& cascade, bool passing, const Room& room, const Sooner& sooner) {
    std::size_t count = 0, bytes = 0;
    for (const Held& held : cascade.by_arrival)
        if (held.passes == passing) {
            ++count;
            bytes += held.keyframe->bytes();
        }
    const auto goes_first = [&](const Held& a, const Held& b) {
        return a.passes != b.passes ? a.passes == passing : a.passes == passing && sooner(a, b);
    };
    while (count > room.keyframes ||
           (bytes > limits_.bytes_per_cascade && count > room.whatever_bytes)) {
        const auto at = std::ranges::min_element(cascade.by_arrival, goes_first);
        const std::size_t gone = at->keyframe->bytes();
        cascade.bytes -= gone;
        bytes -= gone;
        cascade.by_arrival.erase(at);
        --count;
    }
}

const KeyframeRing::Cascade* KeyframeRing::find(int cascade) const {
    const auto index = static_cast<std::size_t>(cascade);
    return cascade >= 0 && index < cascades_.size() ? &cascades_[index] : nullptr;
}

namespace {

/// The keyframes on one side of a time, of which the first of each time counts.
struct Side {
    TimeUs time_us;
    HeldKeyframePtr nearest = {};
    HeldKeyframePtr next = {}; ///< behind it

    TimeUs away_us(const HeldKeyframePtr& held) const {
        return std::abs(held->keyframe().time_us - time_us);
    }
    void take(const HeldKeyframePtr& held) {
        if (!nearest || away_us(held) < away_us(nearest))
            next = std::exchange(nearest, held);
        else if (away_us(held) > away_us(nearest) && (!next || away_us(held) < away_us(next)))
            next = held;
    }
};

} // namespace

std::optional<KeyframePair> KeyframeRing::around(int cascade, std::uint32_t epoch, TimeUs time_us,
                                                 TimeUs interval_us, sea::FieldSet fields) const {
    const std::scoped_lock lock(mutex_);
    const Cascade* ring = find(cascade);
    if (!ring)
        return std::nullopt;
    Side past{time_us}, future{time_us};
    const sea::Keyframe* newest = nullptr;
    for (auto at = ring->by_arrival.rbegin(); at != ring->by_arrival.rend(); ++at) {
        const HeldKeyframePtr& held = at->keyframe;
        const sea::Keyframe& keyframe = held->keyframe();
        if (keyframe.epoch != epoch || !held->fields().contains(fields))
            continue;
        // A server that uses the number of an epoch again, long after, has other maps for it.
        newest = newest ? newest : &keyframe;
        if (keyframe.size != newest->size || keyframe.length_m != newest->length_m)
            continue;
        (keyframe.time_us <= time_us ? past : future).take(held);
    }
    if (!past.nearest && !future.nearest)
        return std::nullopt;
    const auto together = [interval_us](const HeldKeyframePtr& before,
                                        const HeldKeyframePtr& after) {
        return before && after &&
               after->keyframe().time_us - before->keyframe().time_us <=
                   std::max(
                       {interval_us, before->coarser().interval_us, after->coarser().interval_us});
    };
    if (together(past.nearest, future.nearest))
        return KeyframePair{past.nearest, future.nearest, true};
    if (past.nearest && past.away_us(past.nearest) == 0)
        return KeyframePair{past.nearest, past.nearest, true};
    // Of two that are too far apart the nearer one: a cubic through both swells between them.
    if (!future.nearest ||
        (past.nearest && past.away_us(past.nearest) <= future.away_us(future.nearest)))
        return KeyframePair{together(past.next, past.nearest) ? past.next : past.nearest,
                            past.nearest, false};
    return KeyframePair{future.nearest,
                        together(future.nearest, future.next) ? future.next : future.nearest,
                        false};
}

HeldKeyframePtr KeyframeRing::newest(int cascade) const {
    const std::scoped_lock lock(mutex_);
    const Cascade* ring = find(cascade);
    HeldKeyframePtr newest;
    if (ring)
        for (const auto& [held, passes] : ring->by_arrival)
            if (!newest || held->keyframe().time_us > newest->keyframe().time_us)
                newest = held;
    return newest;
}

std::optional<std::pair<TimeUs, TimeUs>> KeyframeRing::held(int cascade, std::uint32_t epoch,
                                                            TimeUs time_us, TimeUs interval_us,
                                                            sea::FieldSet fields) const {
    const std::scoped_lock lock(mutex_);
    std::map<TimeUs, TimeUs> apart_us; // that the next one may be, by time
    if (const Cascade* ring = find(cascade))
        for (const auto& [held, passes] : ring->by_arrival)
            if (held->keyframe().epoch == epoch && held->fields().contains(fields))
                apart_us[held->keyframe().time_us] =
                    std::max(interval_us, held->coarser().interval_us);
    std::optional<std::pair<TimeUs, TimeUs>> span;
    for (const auto& [at_us, next_us] : apart_us) {
        const bool follows =
            span && at_us - span->second <= std::max(next_us, apart_us.at(span->second));
        if (span && !follows && at_us > time_us)
            break;
        span = std::pair(follows ? span->first : at_us, at_us);
    }
    return span;
}

bool KeyframeRing::holds(const sea::SplineMap* spline) const {
    const std::scoped_lock lock(mutex_);
    return std::ranges::any_of(cascades_, [&](const Cascade& cascade) {
        return std::ranges::any_of(cascade.by_arrival, [&](const Held& held) {
            return held.keyframe->has_spline() && held.keyframe->spline().get() == spline;
        });
    });
}

void KeyframeRing::clear() {
    const std::scoped_lock lock(mutex_);
    ++changes_;
    cascades_.clear();
}

void KeyframeRing::keep_only(const std::function<bool(const sea::Keyframe&)>& stays) {
    const std::scoped_lock lock(mutex_);
    ++changes_;
    for (Cascade& cascade : cascades_)
        std::erase_if(cascade.by_arrival, [&](const Held& held) {
            const bool goes = !stays(held.keyframe->keyframe());
            cascade.bytes -= goes ? held.keyframe->bytes() : 0;
            return goes;
        });
}

std::size_t KeyframeRing::size(int cascade) const {
    const std::scoped_lock lock(mutex_);
    const Cascade* ring = find(cascade);
    return ring ? ring->by_arrival.size() : 0;
}

std::size_t KeyframeRing::bytes(int cascade) const {
    const std::scoped_lock lock(mutex_);
    const Cascade* ring = find(cascade);
    return ring ? ring->bytes : 0;
}

} // namespace seaway::client
