// SPDX-License-Identifier: Apache-2.0
#include "client/held/keyframe_ring.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "base/check.h"
#include "protocol/limits.h"
#include "sea/surface/budget/error_budget.h"
#include "sea/surface/maps/regrid.h"

namespace seaway::client {

using sea::Field;
using sea::TimeUs;

namespace {

constexpr sea::FieldSet sampled_fields{Field::height, Field::height_rate};

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
        if (sea::surface_fields.contains({field}))
            continue;
        rest.fields.insert(field);
        const std::span<const float> plane = from.plane(field);
        rest.values.insert(rest.values.end(), plane.begin(), plane.end());
    }
    const auto made =
        std::make_shared<HeldKeyframe>(std::move(rest), whole->errors_, whole->compact_);
    made->fields_ = whole->fields_;
    std::call_once(made->spline_once_, [&] { made->spline_ = whole->spline(); });
    return made;
}

sea::SplineMapPtr HeldKeyframe::spline() const {
    std::call_once(spline_once_,
                   [this] { spline_ = std::make_shared<const sea::SplineMap>(*keyframe_); });
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

void KeyframeRing::insert(HeldKeyframePtr keyframe) {
    if (limits_.as_splines)
        keyframe = HeldKeyframe::as_spline(keyframe);
    const sea::Keyframe& fresh = keyframe->keyframe();
    SEAWAY_CHECK(fresh.cascade >= 0 && fresh.cascade < protocol::limits::cascades_max,
                 "the cascade of a keyframe is checked when its tiles are read");
    const auto index = static_cast<std::size_t>(fresh.cascade);
    const std::scoped_lock lock(mutex_);
    if (cascades_.size() <= index)
        cascades_.resize(index + 1);
    Cascade& cascade = cascades_[index];
    const auto same = std::find_if(cascade.by_arrival.begin(), cascade.by_arrival.end(),
                                   [&](const HeldKeyframePtr& held) {
                                       return held->keyframe().time_us == fresh.time_us &&
                                              held->keyframe().epoch == fresh.epoch;
                                   });
    if (same != cascade.by_arrival.end()) {
        const sea::FieldSet held = (*same)->fields();
        if (held.contains(keyframe->fields()) && held != keyframe->fields())
            return;
        cascade.bytes -= (*same)->bytes();
        cascade.by_arrival.erase(same);
    }
    cascade.bytes += keyframe->bytes();
    cascade.by_arrival.push_back(std::move(keyframe));
    make_room(cascade, fresh.time_us);
}

void KeyframeRing::make_room(Cascade& cascade, TimeUs now_us) {
    const auto drop = [&](std::deque<HeldKeyframePtr>::iterator at) {
        cascade.bytes -= (*at)->bytes();
        return cascade.by_arrival.erase(at);
    };
    for (auto at = cascade.by_arrival.begin();
         at != cascade.by_arrival.end() &&
         cascade.by_arrival.size() > RingLimits::keyframes_per_cascade_min;)
        at = std::abs(now_us - (*at)->keyframe().time_us) > limits_.reach_us ? drop(at) : at + 1;
    while (cascade.by_arrival.size() > limits_.keyframes_per_cascade ||
           (cascade.bytes > limits_.bytes_per_cascade &&
            cascade.by_arrival.size() > RingLimits::keyframes_per_cascade_min))
        drop(cascade.by_arrival.begin());
}

const KeyframeRing::Cascade* KeyframeRing::find(int cascade) const {
    const auto index = static_cast<std::size_t>(cascade);
    return cascade >= 0 && index < cascades_.size() ? &cascades_[index] : nullptr;
}

std::optional<KeyframePair> KeyframeRing::around(int cascade, std::uint32_t epoch, TimeUs time_us,
                                                 TimeUs interval_us, sea::FieldSet fields) const {
    const std::scoped_lock lock(mutex_);
    const Cascade* ring = find(cascade);
    if (!ring)
        return std::nullopt;
    KeyframePair pair;
    const sea::Keyframe* newest = nullptr;
    for (auto at = ring->by_arrival.rbegin(); at != ring->by_arrival.rend(); ++at) {
        const HeldKeyframePtr& held = *at;
        const sea::Keyframe& keyframe = held->keyframe();
        if (keyframe.epoch != epoch || !held->fields().contains(fields))
            continue;
        // A server that uses the number of an epoch again, long after, has other maps for it.
        newest = newest ? newest : &keyframe;
        if (keyframe.size != newest->size || keyframe.length_m != newest->length_m)
            continue;
        if (keyframe.time_us <= time_us &&
            (!pair.before || keyframe.time_us > pair.before->keyframe().time_us))
            pair.before = held;
        if (keyframe.time_us > time_us &&
            (!pair.after || keyframe.time_us < pair.after->keyframe().time_us))
            pair.after = held;
    }
    if (!pair.before && !pair.after)
        return std::nullopt;
    const auto apart_us = [](const HeldKeyframePtr& held) {
        return held ? held->coarser().interval_us : 0;
    };
    interval_us = std::max({interval_us, apart_us(pair.before), apart_us(pair.after)});
    pair.covers = pair.before && pair.after &&
                  pair.after->keyframe().time_us - pair.before->keyframe().time_us <= interval_us;
    if (pair.covers)
        return pair;
    if (!pair.before)
        pair.before = pair.after;
    else if (!pair.after || pair.before->keyframe().time_us == time_us)
        pair.after = pair.before;
    pair.covers = pair.after == pair.before && pair.before->keyframe().time_us == time_us;
    return pair;
}

HeldKeyframePtr KeyframeRing::newest(int cascade) const {
    const std::scoped_lock lock(mutex_);
    const Cascade* ring = find(cascade);
    HeldKeyframePtr newest;
    if (ring)
        for (const HeldKeyframePtr& held : ring->by_arrival)
            if (!newest || held->keyframe().time_us > newest->keyframe().time_us)
                newest = held;
    return newest;
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
