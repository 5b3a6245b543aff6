// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/keyframe_store.h"

namespace seaway::server {

sea::KeyframePtr KeyframeStore::find(int cascade, sea::TimeUs time_us, sea::FieldSet fields) {
    const std::scoped_lock lock(mutex_);
    const auto found = entries_.find({cascade, time_us});
    if (found == entries_.end() || !found->second.keyframe->fields.contains(fields)) {
        ++counters_.misses;
        return nullptr;
    }
    ++counters_.hits;
    touch(found->second);
    return found->second.keyframe;
}

sea::KeyframePtr KeyframeStore::held(int cascade, sea::TimeUs time_us) const {
    const std::scoped_lock lock(mutex_);
    const auto found = entries_.find({cascade, time_us});
    return found == entries_.end() ? nullptr : found->second.keyframe;
}

bool KeyframeStore::splined(int cascade, sea::TimeUs time_us) const {
    const std::scoped_lock lock(mutex_);
    const auto found = entries_.find({cascade, time_us});
    return found != entries_.end() && found->second.spline != nullptr;
}

void KeyframeStore::insert(sea::KeyframePtr keyframe) {
    const std::scoped_lock lock(mutex_);
    const Key key{keyframe->cascade, keyframe->time_us};
    const auto [place, is_new] = entries_.try_emplace(key);
    Entry& entry = place->second;
    if (is_new) {
        by_recency_.push_front(key);
        entry.recency = by_recency_.begin();
    } else {
        counters_.bytes -= bytes(entry);
        touch(entry);
    }
    entry.keyframe = std::move(keyframe);
    entry.spline = nullptr;
    counters_.bytes += bytes(entry);
    shrink();
}

sea::SplineMapPtr KeyframeStore::spline(const sea::KeyframePtr& keyframe) {
    const Key key{keyframe->cascade, keyframe->time_us};
    {
        const std::scoped_lock lock(mutex_);
        const auto found = entries_.find(key);
        if (found != entries_.end() && found->second.keyframe == keyframe && found->second.spline) {
            touch(found->second);
            return found->second.spline;
        }
    }
    auto spline = std::make_shared<const sea::SplineMap>(*keyframe);
    const std::scoped_lock lock(mutex_);
    const auto found = entries_.find(key);
    if (found != entries_.end() && found->second.keyframe == keyframe && !found->second.spline) {
        found->second.spline = spline;
        counters_.bytes += spline->bytes();
        touch(found->second);
        shrink();
    }
    return spline;
}

StoreCounters KeyframeStore::counters() const {
    const std::scoped_lock lock(mutex_);
    StoreCounters counters = counters_;
    counters.keyframes = entries_.size();
    return counters;
}

void KeyframeStore::touch(Entry& entry) {
    by_recency_.splice(by_recency_.begin(), by_recency_, entry.recency);
}

void KeyframeStore::shrink() {
    while (counters_.bytes > bytes_max_) {
        const auto oldest = entries_.find(by_recency_.back());
        counters_.bytes -= bytes(oldest->second);
        entries_.erase(oldest);
        by_recency_.pop_back();
    }
}

std::size_t KeyframeStore::bytes(const Entry& entry) {
    return entry.keyframe->values.size() * sizeof(float) +
           (entry.spline ? entry.spline->bytes() : 0);
}

} // namespace seaway::server
