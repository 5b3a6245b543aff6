// SPDX-License-Identifier: Apache-2.0
// Keyframe store: a bounded cache of keyframes and of their splines, oldest use first out. Those of the
// stream, which everybody asks about, do not go for those that somebody asks for: they have half of the
// room for themselves. What nobody has used for a while is let go (trim), of the stream later than of questions; maps go before
// their spline, from which alone points are answered, and as soon as it is there while nothing is streamed.
//
// Thread-safe. What is handed out stays valid after it has been dropped here.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <map>
#include <mutex>
#include <tuple>

#include "sea/surface/maps/keyframe.h"
#include "sea/surface/maps/spline_map.h"
#include "server/device/synthesizer.h"
#include "server/host/room.h"

namespace seaway::server {

struct StoreCounters {
    std::size_t keyframes = 0;
    std::size_t bytes = 0;
    std::uint64_t hits = 0;
    std::uint64_t misses = 0;
    std::size_t asked = 0; ///< of the keyframes: those that are not the stream's
};

class KeyframeStore {
  public:
    /// Holds what the room has bytes for.
    explicit KeyframeStore(std::shared_ptr<Room> room) : room_(std::move(room)) {}

    /// The keyframe if it is held with at least these fields, else null. `streamed`: it is one of the stream from now on.
    sea::KeyframePtr find(const KeyframeRequest& request, bool streamed = false);

    /// What is held of a keyframe, with whichever fields, or null; no use of it.
    sea::KeyframePtr held(const KeyframeRequest& request) const;

    /// What a point can be answered from, of at least these fields.
    struct Found {
        sea::SplineMapPtr spline;
        sea::KeyframePtr maps; ///< where there is no spline
    };
    Found find_for_points(const KeyframeRequest& request);
    /// Its spline if it is held and was made of at least these fields, with its maps or without, else null.
    sea::SplineMapPtr find_spline(const KeyframeRequest& request);
    /// That would find one; no use of it.
    bool splined(const KeyframeRequest& request) const;

    /// Replaces a keyframe of the same epoch, cascade and time, but for a spline that is held without its maps. One that is larger
    /// than the store is not kept.
    void insert(sea::KeyframePtr keyframe, bool streamed = false);

    /// Lets go of what has not been used since the call before the last one, and of maps that were not while their spline
    /// was; returns its bytes. Keyframes of the stream, and maps while there is one, stay for two calls more: who begins to
    /// subscribe has those around now.
    std::size_t trim();

    /// The keyframe's spline; kept beside it if the keyframe is held. `pause` as in sea::Pauses, with nothing locked.
    sea::SplineMapPtr spline(const sea::KeyframePtr& keyframe, sea::Pauses::Pause pause = nullptr);

    StoreCounters counters() const;

  private:
    using Key = std::tuple<std::uint32_t, int, sea::TimeUs>; ///< epoch, cascade, time
    struct Entry {
        sea::KeyframePtr keyframe; ///< null: its spline alone is held
        sea::SplineMapPtr spline;
        sea::FieldSet spline_fields; ///< that it was made of, at least
        std::list<Key>::iterator recency;
        bool streamed = false;
        std::uint64_t used = 0; ///< calls of trim() before its last use
        std::uint64_t maps_used = 0;
        Room::Place place = {};
        Room::Place spline_place = {};
    };

    static bool has_spline(const Entry& entry, sea::FieldSet fields) {
        return entry.spline != nullptr && entry.spline_fields.contains(fields);
    }
    static bool has_maps(const Entry& entry, sea::FieldSet fields) {
        return entry.keyframe != nullptr && entry.keyframe->fields.contains(fields);
    }
    void stream(Entry& entry);
    void touch(Entry& entry);
    void let_go_maps(Entry& entry);
    void count(const Entry& entry, std::size_t more);
    void uncount(const Entry& entry, std::size_t less);
    void drop(std::map<Key, Entry>::iterator entry);
    void shrink();
    std::list<Key>& recency_of(const Entry& entry) {
        return entry.streamed ? streamed_by_recency_ : by_recency_;
    }
    static std::size_t bytes(const Entry& entry);

    const std::shared_ptr<Room> room_;
    mutable std::mutex mutex_;
    std::map<Key, Entry> entries_;
    std::list<Key> by_recency_; ///< most recent first
    std::list<Key> streamed_by_recency_;
    std::size_t streamed_bytes_ = 0;
    std::uint64_t trims_ = 0;
    StoreCounters counters_;
};

} // namespace seaway::server
