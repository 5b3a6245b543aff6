// SPDX-License-Identifier: Apache-2.0
// Keyframe store: a bounded cache of keyframes and of their splines, oldest use first out. Those of the
// stream, which everybody asks about, do not go for those that somebody asks for: they have half of the
// room for themselves. What nobody has used for a while is let go (trim).
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

    /// The keyframe if it is held with at least these fields, else null.
    sea::KeyframePtr find(const KeyframeRequest& request);

    /// What is held of a keyframe, with whichever fields, or null; no use of it.
    sea::KeyframePtr held(const KeyframeRequest& request) const;

    /// The same, and its spline is held too.
    bool splined(const KeyframeRequest& request) const;

    /// Replaces a keyframe of the same epoch, cascade and time. One that is larger than the store is not
    /// kept.
    void insert(sea::KeyframePtr keyframe, bool streamed = false);

    /// Lets go of what has not been used since the call before the last one; returns its bytes.
    std::size_t trim();

    /// The keyframe's spline; kept beside it for as long as the keyframe is held. `pause` as in sea::Pauses, with nothing locked.
    sea::SplineMapPtr spline(const sea::KeyframePtr& keyframe, sea::Pauses::Pause pause = nullptr);

    StoreCounters counters() const;

  private:
    using Key = std::tuple<std::uint32_t, int, sea::TimeUs>; ///< epoch, cascade, time
    struct Entry {
        sea::KeyframePtr keyframe;
        sea::SplineMapPtr spline;
        std::list<Key>::iterator recency;
        bool streamed = false;
        std::uint64_t used = 0; ///< calls of trim() before its last use
        Room::Place place = {};
        Room::Place spline_place = {};
    };

    void touch(Entry& entry);
    void count(const Entry& entry, std::size_t more);
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
