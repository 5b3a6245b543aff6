// SPDX-License-Identifier: Apache-2.0
// Keyframe ring: the keyframes that a client holds, a bounded number a cascade, and the pair of
// them around a time, which is what a sampler or a renderer works from.
//
// Of a stream it holds what is ahead and what the look-back needs, of that the nearest where there is no room for all; of what
// was asked for, as much as there is room for: the one that came first is dropped first. Neither makes room for the other. A keyframe that has been sampled is held as its
// spline alone.
//
// Thread-safe. Readers get shared pointers to immutable keyframes: what they hold stays whole while the ring moves on.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "sea/surface/map_error.h"
#include "sea/surface/maps/keyframe.h"
#include "sea/surface/maps/spline_map.h"

namespace seaway::client {

/// A keyframe as it came over the wire. Immutable; share it by pointer.
class HeldKeyframe {
  public:
    using FieldErrors = std::array<float, sea::field_count>;

    /// How maps came that were made of others, on the way.
    struct Compact {
        int size = 0;          ///< of the grid on which linear maps came; 0: on their own
        sea::FieldSet follows; ///< made of height and its rate, whose errors they have
        double gain = 0.5;     ///< their variance over that of what they were made of (sea::Orbits)
        sea::CoarserLoss coarser = {}; ///< what they miss beside what the sea says
        sea::CodedNoise noise = {};    ///< what coding left of heights, where the server says
    };

    /// `errors`: the bound that the encoder met, [field], in the field's unit; 0 where absent.
    HeldKeyframe(sea::Keyframe keyframe, const FieldErrors& errors, const Compact& compact);
    HeldKeyframe(sea::Keyframe keyframe, const FieldErrors& errors)
        : HeldKeyframe(std::move(keyframe), errors, Compact{}) {}

    /// The same, its spline made, without the maps that a spline stands for: half the memory. Itself where it cannot
    /// be sampled.
    static std::shared_ptr<const HeldKeyframe>
    as_spline(const std::shared_ptr<const HeldKeyframe>& whole);

    /// What came. keyframe() holds the values of all of it, unless this was made as_spline().
    sea::FieldSet fields() const { return fields_; }
    const sea::Keyframe& keyframe() const { return *keyframe_; }
    const sea::KeyframePtr& keyframe_ptr() const { return keyframe_; }
    float error(sea::Field field) const { return errors_[static_cast<std::size_t>(field)]; }

    /// Were linear maps coded on a smaller grid?
    bool compact() const { return compact_.size > 0; }
    /// What it misses beside what the sea says of its maps.
    const sea::CoarserLoss& coarser() const { return compact_.coarser; }
    const sea::CodedNoise& noise() const { return compact_.noise; }
    /// Between the samples that were coded.
    double coded_spacing_m() const {
        return keyframe_->length_m / (compact() ? compact_.size : keyframe_->size);
    }
    /// Standard deviation of what coding made of a linear map, in the field's unit.
    double coded_rms(sea::Field field) const;
    /// Was it made of heights?
    bool follows(sea::Field field) const { return compact_.follows.contains(field); }

    /// Can heights be sampled from it? Needs height and its time rate.
    bool can_be_sampled() const;

    /// Made ready for sampling at the first call (about 3 ms at 256 x 256), then shared.
    /// can_be_sampled() must hold. Thread-safe.
    sea::SplineMapPtr spline() const;
    bool has_spline() const { return splined_; }
    /// Are the maps that the spline stands for there as well?
    bool has_maps() const { return keyframe_->fields == fields_; }

    /// Memory with its spline, whether that is made or not.
    std::size_t bytes() const;
    /// The same of one that is still to come, whole.
    static std::size_t bytes_of(sea::FieldSet fields, int size);

  private:
    sea::KeyframePtr keyframe_;
    sea::FieldSet fields_;
    FieldErrors errors_;
    Compact compact_;
    double compact_share_; ///< of the coded variance that is left
    mutable std::once_flag spline_once_;
    mutable sea::SplineMapPtr spline_;
    mutable std::atomic<bool> splined_ = false;
};
using HeldKeyframePtr = std::shared_ptr<const HeldKeyframe>;

/// The keyframes of one cascade around a time, before <= time < after; both the same at the very time of the last one. Where the
/// time is not covered, the nearest one and the one that it has an interval with on its other side, from which the sea runs on
/// (sea/surface/maps/hermite.h); both the same where it has none.
struct KeyframePair {
    HeldKeyframePtr before;
    HeldKeyframePtr after;
    /// The time lies between them and they are no further apart than the cascade's interval, or than one of them says
    /// that keyframes come, so that the stated interpolation error holds.
    bool covers = false;
};

struct RingLimits {
    /// Of those that were asked for; and of those that pass by, where what a server sends ahead at the shortest intervals has
    /// room, and the usual look-back.
    std::size_t keyframes_per_cascade = 48;
    /// Likewise, splines included. At least `keyframes_per_cascade_min` are held all the same, and of a stream what is sent
    /// ahead.
    std::size_t bytes_per_cascade = 192u * 1024 * 1024;
    /// Keyframes that can be sampled are held as splines (HeldKeyframe::as_spline), made as they come in: for who
    /// samples or draws every one of them and reads no raw map of it.
    bool as_splines = false;
    /// Of keyframes that pass by: those which no time needs that lies less than this before now are dropped.
    sea::TimeUs look_back_us = look_back_usual_us;
    static constexpr sea::TimeUs look_back_usual_us = 250'000;
    /// And those that lie further ahead than any server sends a stream: they came with somebody's fetch.
    static constexpr sea::TimeUs ahead_max_us = 10'000'000;
    static constexpr std::size_t keyframes_per_cascade_min = 4;
    static constexpr std::size_t passing_per_cascade_min = 2; ///< whatever their times are
    /// Of what is sent ahead there is no more than so much, whoever sends it.
    static constexpr std::size_t ahead_bytes_max = 1024u * 1024 * 1024;

    /// How many keyframes of so many bytes each are held of one cascade.
    std::size_t room(std::size_t keyframe_bytes) const;
    /// So many are sent ahead of now, those around it included, of a sea that runs `hurry` times as fast as clocks: a room for
    /// fewer would leave holes, since what has been dropped does not come again.
    static std::size_t sent_ahead(sea::TimeUs interval_us, double hurry);
    /// So many more may pass by than is usual, whatever their bytes: what a longer look-back needs.
    std::size_t more_passing(sea::TimeUs interval_us) const;
};

class KeyframeRing {
  public:
    explicit KeyframeRing(RingLimits limits = {}) : limits_(limits) {}

    /// Takes a keyframe. Of the same epoch, cascade and time those are replaced that hold no field besides, and one that
    /// holds more stays instead; where each holds what the other lacks, both are held.
    void insert(HeldKeyframePtr keyframe);
    /// The same of one that passes by: it goes once the present has left it behind. `now_us`: sea time; `interval_us`: between
    /// the keyframes of its cascade; `hurry`: how many times as fast as clocks the sea runs, at least 1.
    void insert_passing(HeldKeyframePtr keyframe, sea::TimeUs now_us, sea::TimeUs interval_us,
                        double hurry = 1.0);

    /// The keyframes around a time, of one epoch and with at least `fields`. Nothing if none is held.
    std::optional<KeyframePair> around(int cascade, std::uint32_t epoch, sea::TimeUs time_us,
                                       sea::TimeUs interval_us, sea::FieldSet fields) const;

    /// The newest keyframe in sea time; null if none is held.
    HeldKeyframePtr newest(int cascade) const;

    /// From when to when keyframes of an epoch with these fields cover every time: the last such stretch that has begun by this
    /// time, or the first there is. Nothing if none is held.
    std::optional<std::pair<sea::TimeUs, sea::TimeUs>> held(int cascade, std::uint32_t epoch,
                                                            sea::TimeUs time_us,
                                                            sea::TimeUs interval_us,
                                                            sea::FieldSet fields) const;

    void clear();
    /// Lets go of the others.
    void keep_only(const std::function<bool(const sea::Keyframe&)>& stays);

    /// Another number after every call that may have changed what is held.
    std::uint64_t changes() const { return changes_; }
    /// Is the keyframe of this spline held?
    bool holds(const sea::SplineMap* spline) const;

    std::size_t size(int cascade) const;
    /// What all held keyframes of a cascade count for, splines included.
    std::size_t bytes(int cascade) const;
    const RingLimits& limits() const { return limits_; }

  private:
    struct Held {
        HeldKeyframePtr keyframe;
        bool passes = false;
    };
    struct Cascade {
        std::deque<Held> by_arrival;
        std::size_t bytes = 0;
    };

    const Cascade* find(int cascade) const;
    /// mutex_ held. The cascade that took it; null: a better one is held.
    Cascade* take(Held held);
    struct Room {
        std::size_t keyframes;      ///< at most
        std::size_t whatever_bytes; ///< of these, however many bytes they take
    };
    /// Of those that were asked for.
    void make_room(Cascade& cascade);
    struct Span {
        sea::TimeUs from_us, to_us;
    };
    /// Of those that pass; of what lies around now and is sent ahead last of all.
    void make_room_around(Cascade& cascade, sea::TimeUs now_us, const Span& needed,
                          const Room& room);
    /// Drops those that pass, or those that do not, until there are few enough; of two `sooner` says which goes first.
    template <class Sooner>
    void drop(Cascade& cascade, bool passing, const Room& room, const Sooner& sooner);
    void let_pass(Cascade& cascade, sea::TimeUs now_us);
    void drop_maps_of_splines();

    const RingLimits limits_;
    mutable std::mutex mutex_;
    std::atomic<std::uint64_t> changes_ = 0; ///< written with mutex_ held
    std::vector<Cascade> cascades_;
};

} // namespace seaway::client
