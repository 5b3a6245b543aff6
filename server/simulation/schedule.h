// SPDX-License-Identifier: Apache-2.0
// Schedule: which keyframes are due when. Arithmetic on times alone, without thread, lock, clock or
// device. A keyframe of a cascade lies at a whole multiple of its interval and is due interval +
// publish_lead_us before its own time, so that the two around now are always out. Where one sea follows another,
// the stream has the keyframes around that moment of both. Who takes fewer keyframes has a stream of his own of every
// n-th of them, each of which is due n intervals ahead.
//
// A Schedule remembers how far each stream has come; it is for one thread.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "sea/surface/budget/error_budget.h"
#include "sea/surface/budget/spending.h"
#include "server/device/synthesizer.h"
#include "server/host/subscriptions.h"
#include "server/simulation/effect_plan.h"
#include "server/simulation/sea_course.h"

namespace seaway::server {

using sea::publish_lead_us;
/// A keyframe that is later than this is left out for a newer one.
inline constexpr sea::TimeUs catch_up_us = 500'000;

/// A sea that follows is made by who tells of it, on a thread that has no stream to serve (World::announce_due). If it is
/// not there so long before it begins, the schedule makes it. Longer than two intervals of any stream and the lead.
inline constexpr sea::TimeUs made_ahead_us = 6'000'000;

/// Start of the keyframe interval that holds the time; also for times before the epoch.
sea::TimeUs interval_start(sea::TimeUs time_us, sea::TimeUs interval_us);

/// The first time from time_us on at which keyframes of all these intervals lie; time_us itself where they meet less often
/// than every meeting_us_max. A sea that changes at such a time needs no keyframe beside those that are due.
inline constexpr sea::TimeUs meeting_us_max = 2'000'000;
sea::TimeUs next_meeting(sea::TimeUs time_us, std::span<const sea::TimeUs> intervals_us);

/// The two keyframes of each wanted cascade around each time, each of them once, cascade by
/// cascade, in order of time; of the sea that runs at the time. Times must be in_time_range().
std::vector<KeyframeRequest> keyframes_around(const SeaCourse& course,
                                              std::span<const sea::TimeUs> times_us,
                                              const Demand& demand);

/// The same where `sea_of` says which sea is taken to run at a time, by its epoch, and whose intervals it has.
struct SeaOfTime {
    std::uint32_t epoch;
    RunningSeaPtr intervals;
};
std::vector<KeyframeRequest> keyframes_around(const std::function<SeaOfTime(sea::TimeUs)>& sea_of,
                                              std::span<const sea::TimeUs> times_us,
                                              const Demand& demand);

/// Bit n: rate_rungs_hz[n].
using RateSet = std::bitset<rate_rungs_hz.size()>;

class Schedule {
  public:
    explicit Schedule(const SeaCourse& course);

    /// The lead, and what is too late, in sea time: `hurry` times as much where the sea runs faster than clocks do.
    void hurry(double hurry) {
        lead_us_ = static_cast<sea::TimeUs>(hurry * static_cast<double>(publish_lead_us));
        catch_up_us_ = static_cast<sea::TimeUs>(hurry * static_cast<double>(catch_up_us));
        made_ahead_us_ = static_cast<sea::TimeUs>(hurry * static_cast<double>(made_ahead_us));
    }

    struct Due {
        std::vector<KeyframeRequest> keyframes; ///< to be published now, oldest of each cascade
        /// Of each: for those who take keyframes at most at one of these rates.
        std::vector<RateSet> rates;

        void add(const KeyframeRequest& keyframe, std::size_t rate);
        std::uint64_t left_out = 0; ///< too late to be of use, and skipped
    };
    /// What the streams need next. To be called again until nothing is due.
    Due take_due(const EffectPlan& plan, sea::TimeUs now_us);

    /// When something will be due; none while nobody wants anything.
    std::optional<sea::TimeUs> next_due_us(const EffectPlan& plan) const;

    /// The keyframe that a cascade's stream of all keyframes has come to, or would start with now.
    sea::TimeUs next_us(int cascade, sea::TimeUs now_us) const;

    /// What a new subscriber needs: from the keyframe before now to where the stream has come, or
    /// will start from.
    std::vector<KeyframeRequest> current(const Demand& demand, sea::TimeUs now_us) const;

  private:
    /// A keyframe of a cascade's stream.
    struct Place {
        RunningSeaPtr sea;
        sea::TimeUs interval_us;
        sea::TimeUs time_us;

        /// Before this, by the lead.
        sea::TimeUs interval_begins_us() const { return time_us - interval_us; }
    };
    sea::TimeUs due_us(const Place& place) const { return place.interval_begins_us() - lead_us_; }
    /// The last that a stream has had: of the sea that it is in, and of the one that follows, whose first keyframes
    /// come before the last ones of the other. Both are due at their own times.
    struct Stream {
        Place main;
        std::optional<Place> following = {};
    };
    /// Which stream: of a cascade, for those who take keyframes at most at a rate.
    struct Lane {
        std::size_t cascade;
        std::size_t rate = 0; ///< of rate_rungs_hz
    };
    /// The keyframe of this sea at or before a time.
    static Place place(RunningSeaPtr sea, Lane lane, sea::TimeUs time_us);
    Place around(Lane lane, sea::TimeUs now_us) const;
    /// What is wanted of a keyframe by all who take it.
    static sea::FieldSet fields_of(const CascadePlan& plan, Lane lane, const Place& place);
    void take_due(const CascadePlan& plan, Lane lane, sea::TimeUs now_us, Due& due);
    /// A stream as if it had come to the keyframe before the last one that is due: a first subscriber fetches what comes
    /// before.
    Stream started(Lane lane, sea::TimeUs now_us) const;
    /// What comes next, the first that is due, and the stream as it is then.
    std::pair<Place, Stream> next(const Stream& stream, Lane lane) const;
    std::optional<Place> next_of_main(const Stream& stream) const;
    /// None yet where its sea would have to be made and `main` has long to go.
    std::optional<Place> next_of_following(const Stream& stream, Lane lane,
                                           const std::optional<Place>& main) const;
    const std::optional<Stream>& running(Lane lane) const {
        return streams_[lane.cascade][lane.rate];
    }
    /// Where sea time has gone back (SeaClock::follow) it begins anew.
    Stream stream(Lane lane, sea::TimeUs now_us) const {
        return running(lane) && now_us >= seen_us_ ? *running(lane) : started(lane, now_us);
    }

    const SeaCourse& course_;
    sea::TimeUs lead_us_ = publish_lead_us;
    sea::TimeUs catch_up_us_ = catch_up_us;
    sea::TimeUs made_ahead_us_ = made_ahead_us;
    sea::TimeUs seen_us_ = -sea::time_us_max; ///< at the last take_due()
    /// While they run: of each cascade one a rate.
    std::vector<std::array<std::optional<Stream>, rate_rungs_hz.size()>> streams_;
};

} // namespace seaway::server
