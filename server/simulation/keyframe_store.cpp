// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/keyframe_store.h"

namespace seaway::server {

namespace {

/// Of a request or of a keyframe.
template <class Of>
std::tuple<std::uint32_t, int, sea::TimeUs> key_of(const Of& of) {
    return {of.epoch, of.cascade, of.time_us};
}

} // namespace

sea::KeyframePtr KeyframeStore::find(const KeyframeRequest& request) {
    const std::scoped_lock lock(mutex_);
    const auto found = entries_.find(key_of(request));
    if (found == entries_.end() || !found->second.keyframe->fields.contains(request.fields)) {
        ++counters_.misses;
        return nullptr;
    }
    ++counters_.hits;
    touch(found->second);
    return found->second.keyframe;
}

sea::KeyframePtr KeyframeStore::held(const KeyframeRequest& request) const {
    const std::scoped_lock lock(mutex_);
    const auto found = entries_.find(key_of(request));
    return found == entries_.end() ? nullptr : found->second.keyframe;
}

bool KeyframeStore::splined(const KeyframeRequest& request) const {
    const std::scoped_lock lock(mutex_);
    const auto found = entries_.find(key_of(request));
    return found != entries_.end() && found->second.spline != nullptr;
}

void KeyframeStore::insert(sea::KeyframePtr keyframe, bool streamed) {
    const std::scoped_lock lock(mutex_);
    const Key key = key_of(*keyframe);
    if (const auto held = entries_.find(key); held != entries_.end()) {
        streamed = streamed || held->second.streamed;
        drop(held);
    }
    Entry entry{.keyframe = std::move(keyframe), .spline = nullptr, .recency = {}};
    entry.streamed = streamed;
    entry.used = trims_;
    // All that may find no memory, and then what is a part of each other.
    const std::size_t more = bytes(entry);
    entry.place = room_->take_anyway(more);
    std::list<Key> newest{key};
    Entry& added = entries_.emplace(key, std::move(entry)).first->second;
    std::list<Key>& recency = recency_of(added);
    recency.splice(recency.begin(), newest);
    added.recency = recency.begin();
    count(added, more);
    shrink();
}

void KeyframeStore::count(const Entry& entry, std::size_t more) {
    counters_.bytes += more;
    streamed_bytes_ += entry.streamed ? more : 0;
}

void KeyframeStore::drop(std::map<Key, Entry>::iterator entry) {
    const std::size_t freed = bytes(entry->second);
    counters_.bytes -= freed;
    streamed_bytes_ -= entry->second.streamed ? freed : 0;
    recency_of(entry->second).erase(entry->second.recency);
    entries_.erase(entry);
}

std::size_t KeyframeStore::trim() {
    const std::scoped_lock lock(mutex_);
    const std::size_t before = counters_.bytes;
    for (auto at = entries_.begin(); at != entries_.end();) {
        const auto entry = at++;
        if (entry->second.used < trims_)
            drop(entry);
    }
    ++trims_;
    return before - counters_.bytes;
}

sea::SplineMapPtr KeyframeStore::spline(const sea::KeyframePtr& keyframe,
                                        sea::Pauses::Pause pause) {
    const Key key = key_of(*keyframe);
    {
        const std::scoped_lock lock(mutex_);
        const auto found = entries_.find(key);
        if (found != entries_.end() && found->second.keyframe == keyframe && found->second.spline) {
            touch(found->second);
            return found->second.spline;
        }
    }
    auto spline = std::make_shared<const sea::SplineMap>(*keyframe, pause);
    const std::scoped_lock lock(mutex_);
    const auto found = entries_.find(key);
    if (found != entries_.end() && found->second.keyframe == keyframe && !found->second.spline) {
        found->second.spline_place = room_->take_anyway(spline->bytes());
        found->second.spline = spline;
        count(found->second, spline->bytes());
        touch(found->second);
        shrink();
    }
    return spline;
}

StoreCounters KeyframeStore::counters() const {
    const std::scoped_lock lock(mutex_);
    StoreCounters counters = counters_;
    counters.keyframes = entries_.size();
    counters.asked = by_recency_.size();
    return counters;
}

void KeyframeStore::touch(Entry& entry) {
    std::list<Key>& recency = recency_of(entry);
    recency.splice(recency.begin(), recency, entry.recency);
    entry.used = trims_;
}

void KeyframeStore::shrink() {
    while (counters_.bytes > room_->bytes_max()) {
        const bool streamed = by_recency_.empty() || (2 * streamed_bytes_ > room_->bytes_max() &&
                                                      !streamed_by_recency_.empty());
        drop(entries_.find(streamed ? streamed_by_recency_.back() : by_recency_.back()));
    }
}

std::size_t KeyframeStore::bytes(const Entry& entry) {
    return entry.keyframe->bytes() + (entry.spline ? entry.spline->bytes() : 0);
}

} // namespace seaway::server
