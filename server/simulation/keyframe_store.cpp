// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/keyframe_store.h"

namespace seaway::server {

namespace {

/// A keyframe of the stream is wanted by who begins to subscribe, as long as it is one of the two around now.
constexpr std::uint64_t streamed_trims = 2;

/// Those that its spline is made of.
sea::FieldSet fields_splined(const sea::Keyframe& keyframe) {
    return keyframe.fields & sea::surface_fields;
}

/// Of a request or of a keyframe.
template <class Of>
std::tuple<std::uint32_t, int, sea::TimeUs> key_of(const Of& of) {
    return {of.epoch, of.cascade, of.time_us};
}

} // namespace

sea::KeyframePtr KeyframeStore::find(const KeyframeRequest& request, bool streamed) {
    const std::scoped_lock lock(mutex_);
    const auto found = entries_.find(key_of(request));
    if (found == entries_.end() || !has_maps(found->second, request.fields)) {
        ++counters_.misses;
        return nullptr;
    }
    Entry& entry = found->second;
    ++counters_.hits;
    if (streamed)
        stream(entry);
    touch(entry);
    entry.maps_used = trims_;
    return entry.keyframe;
}

sea::KeyframePtr KeyframeStore::held(const KeyframeRequest& request) const {
    const std::scoped_lock lock(mutex_);
    const auto found = entries_.find(key_of(request));
    return found == entries_.end() ? nullptr : found->second.keyframe;
}

KeyframeStore::Found KeyframeStore::find_for_points(const KeyframeRequest& request) {
    const std::scoped_lock lock(mutex_);
    const auto found = entries_.find(key_of(request));
    if (found == entries_.end())
        return {};
    Entry& entry = found->second;
    const bool splined = has_spline(entry, request.fields);
    if (!splined && !has_maps(entry, request.fields))
        return {};
    ++counters_.hits;
    touch(entry);
    if (splined)
        return {entry.spline, nullptr};
    entry.maps_used = trims_;
    return {nullptr, entry.keyframe};
}

sea::SplineMapPtr KeyframeStore::find_spline(const KeyframeRequest& request) {
    return splined(request) ? find_for_points(request).spline : nullptr;
}

bool KeyframeStore::splined(const KeyframeRequest& request) const {
    const std::scoped_lock lock(mutex_);
    const auto found = entries_.find(key_of(request));
    return found != entries_.end() && has_spline(found->second, request.fields);
}

void KeyframeStore::insert(sea::KeyframePtr keyframe, bool streamed) {
    const std::scoped_lock lock(mutex_);
    const Key key = key_of(*keyframe);
    Entry entry{.keyframe = std::move(keyframe), .spline = nullptr, .recency = {}};
    if (const auto held = entries_.find(key); held != entries_.end()) {
        Entry& before = held->second;
        streamed = streamed || before.streamed;
        if (before.keyframe == nullptr && has_spline(before, fields_splined(*entry.keyframe))) {
            // The same again, for who wants the maps.
            entry.spline = before.spline;
            entry.spline_fields = before.spline_fields;
            entry.spline_place = before.spline_place;
        }
        drop(held);
    }
    entry.streamed = streamed;
    entry.used = entry.maps_used = trims_;
    // All that may find no memory, and then what is a part of each other.
    entry.place = room_->take_anyway(entry.keyframe->bytes());
    const std::size_t more = bytes(entry);
    std::list<Key> newest{key};
    Entry& added = entries_.emplace(key, std::move(entry)).first->second;
    std::list<Key>& recency = recency_of(added);
    recency.splice(recency.begin(), newest);
    added.recency = recency.begin();
    count(added, more);
    shrink();
}

void KeyframeStore::stream(Entry& entry) {
    if (entry.streamed)
        return;
    streamed_by_recency_.splice(streamed_by_recency_.begin(), by_recency_, entry.recency);
    entry.streamed = true;
    streamed_bytes_ += bytes(entry);
}

void KeyframeStore::count(const Entry& entry, std::size_t more) {
    counters_.bytes += more;
    streamed_bytes_ += entry.streamed ? more : 0;
}

void KeyframeStore::uncount(const Entry& entry, std::size_t less) {
    counters_.bytes -= less;
    streamed_bytes_ -= entry.streamed ? less : 0;
}

void KeyframeStore::let_go_maps(Entry& entry) {
    uncount(entry, entry.keyframe->bytes());
    entry.keyframe = nullptr;
    entry.place = nullptr;
}

void KeyframeStore::drop(std::map<Key, Entry>::iterator entry) {
    uncount(entry->second, bytes(entry->second));
    recency_of(entry->second).erase(entry->second.recency);
    entries_.erase(entry);
}

std::size_t KeyframeStore::trim() {
    const std::scoped_lock lock(mutex_);
    const std::size_t before = counters_.bytes;
    const std::uint64_t for_maps = streamed_bytes_ > 0 ? streamed_trims : 0;
    for (auto at = entries_.begin(); at != entries_.end();) {
        const auto here = at++;
        Entry& entry = here->second;
        if (entry.used + (entry.streamed ? streamed_trims : 0) < trims_)
            drop(here);
        else if (entry.keyframe && entry.spline && entry.maps_used + for_maps < trims_)
            let_go_maps(entry);
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
        if (found != entries_.end() && found->second.keyframe == keyframe &&
            has_spline(found->second, fields_splined(*keyframe))) {
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
        found->second.spline_fields = fields_splined(*keyframe);
        count(found->second, spline->bytes());
        touch(found->second);
        if (streamed_bytes_ == 0) // else the stream may be about to want it
            let_go_maps(found->second);
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
    return (entry.keyframe ? entry.keyframe->bytes() : 0) +
           (entry.spline ? entry.spline->bytes() : 0);
}

} // namespace seaway::server
