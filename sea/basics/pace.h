// SPDX-License-Identifier: Apache-2.0
// Pace: how fast the sea runs. Sea time follows the time that has passed since the sea's epoch, by UTC; at pace 1 the
// one is the other. A pace holds from a moment on and sea time goes on from where it was: slower, faster, or, at 0, not
// at all. Server and clients hold the same paces, so they agree on the sea's time at every moment.
//
//     Paces paces;
//     paces.add(paces.next(moment_us, 500));          // half as fast from then on
//     TimeUs time_us = paces.sea_time(elapsed_us);
//
// Values; for one thread.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "sea/basics/time.h"

namespace seaway::sea {

/// Times a pace, which 64 bits do not hold.
__extension__ using WideUs = __int128;

/// In thousandths, whole numbers: what passes is exact wherever it is computed.
inline constexpr int pace_unit = 1000;
/// A keyframe of a sea that runs so much faster has a tenth of the time.
inline constexpr int pace_permille_max = 10 * pace_unit;

struct Pace {
    TimeUs from_us = 0; ///< time since the epoch
    TimeUs sea_us = 0;  ///< sea time at that moment
    int permille = pace_unit;

    /// Of moments from from_us on; rounded down. A sea that has come to the end of all times stands.
    TimeUs sea_time(TimeUs elapsed_us) const {
        const WideUs ran_us = (WideUs{elapsed_us} - from_us) * permille / pace_unit;
        return static_cast<TimeUs>(std::clamp<WideUs>(sea_us + ran_us, -time_us_max, time_us_max));
    }
    bool operator==(const Pace&) const = default;
};

/// One look at the sea's clock.
struct SeaTime {
    /// Of a sea that has always run at pace 1.
    SeaTime(TimeUs time_us) : sea_us(time_us), elapsed_us(time_us) {}
    SeaTime(TimeUs sea_us_, TimeUs elapsed_us_) : sea_us(sea_us_), elapsed_us(elapsed_us_) {}

    TimeUs sea_us;
    TimeUs elapsed_us; ///< since the epoch
    /// For how long whoever says this has not been sure of its sea: others may have changed it.
    TimeUs unsure_us = 0;
};
/// Paces that are held: the one that holds, and more to come than a server promises.
inline constexpr std::size_t paces_max = 16;

class Paces {
  public:
    /// Takes over from those that were to come after its beginning. Of more than paces_max the first is forgotten.
    void add(const Pace& pace) {
        std::erase_if(paces_, [&](const Pace& held) { return held.from_us >= pace.from_us; });
        paces_.push_back(pace);
        if (paces_.size() > paces_max)
            paces_.erase(paces_.begin());
    }
    /// Goes on from where the sea is by then.
    Pace next(TimeUs from_us, int permille) const { return {from_us, sea_time(from_us), permille}; }

    TimeUs sea_time(TimeUs elapsed_us) const { return at(elapsed_us).sea_time(elapsed_us); }
    /// The one that holds at a moment.
    Pace at(TimeUs elapsed_us) const {
        Pace found{elapsed_us, elapsed_us};
        for (const Pace& pace : paces_)
            if (pace.from_us <= elapsed_us)
                found = pace;
        return found;
    }
    /// The fastest from a moment on, of those that are known.
    int fastest_permille(TimeUs elapsed_us) const {
        int fastest = at(elapsed_us).permille;
        for (const Pace& pace : paces_)
            if (pace.from_us > elapsed_us)
                fastest = std::max(fastest, pace.permille);
        return fastest;
    }
    /// How much more sea time than clocks' passes where it is fastest, at least 1: what is to be in time lies so much further
    /// ahead.
    double hurry(TimeUs elapsed_us) const {
        return std::max(fastest_permille(elapsed_us), pace_unit) / static_cast<double>(pace_unit);
    }
    /// Is the sea so far behind what was shown of it, since a pace was heard of late, that waiting does not do? A second is
    /// waited for, and of a sea that stands a tenth of one let be.
    bool are_far_behind(TimeUs shown_us, TimeUs elapsed_us) const {
        constexpr TimeUs made_up_within_us = 1'000'000, let_be_us = 100'000;
        return shown_us > sea_time(elapsed_us + made_up_within_us) + let_be_us;
    }
    /// The moment, not before `elapsed_us`, from which on it is that time; none: never.
    std::optional<TimeUs> moment_of(TimeUs sea_us, TimeUs elapsed_us) const;

    bool empty() const { return paces_.empty(); }
    /// In order of time. The first of all moments are at pace 1.
    const std::vector<Pace>& all() const { return paces_; }
    /// Those before the one that holds at a moment are of no more use.
    void forget_before(TimeUs elapsed_us) {
        while (paces_.size() > 1 && paces_[1].from_us <= elapsed_us)
            paces_.erase(paces_.begin());
    }

  private:
    std::vector<Pace> paces_;
};

inline std::optional<TimeUs> Paces::moment_of(TimeUs sea_us, TimeUs elapsed_us) const {
    if (sea_us > time_us_max)
        return std::nullopt;
    Pace pace = at(elapsed_us);
    for (std::size_t next = 0;; ++next) {
        while (next < paces_.size() && paces_[next].from_us <= elapsed_us)
            ++next;
        const WideUs missing_us = WideUs{sea_us} - pace.sea_time(elapsed_us);
        if (missing_us <= 0)
            return elapsed_us;
        const bool last = next >= paces_.size();
        // About, and then to the microsecond: sea_time() rounds down.
        const WideUs about_us =
            pace.permille > 0
                ? elapsed_us + (missing_us * pace_unit + pace.permille - 1) / pace.permille
                : WideUs{time_us_max} + 1;
        if (about_us <= time_us_max) {
            auto reached_us = static_cast<TimeUs>(about_us);
            while (pace.sea_time(reached_us) < sea_us)
                ++reached_us;
            while (reached_us > elapsed_us && pace.sea_time(reached_us - 1) >= sea_us)
                --reached_us;
            if (last || reached_us <= paces_[next].from_us)
                return reached_us;
        } else if (last) {
            return std::nullopt;
        }
        pace = paces_[next];
        elapsed_us = pace.from_us;
    }
}

} // namespace seaway::sea
