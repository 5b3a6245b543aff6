// SPDX-License-Identifier: Apache-2.0
// ClockFilter: the sea time of another process, from questions and answers: of a server on its clients, of its peers on a server.
//
// Each answer is a look at the difference between the other's sea time and the local monotonic clock: it was no more than
// the answer says less when it was asked for, and no less than that less when it came. Queueing only ever lengthens a trip, so
// over the looks of a minute the least of the one and the most of the other come near the shortest way there and the shortest way
// back, each by itself, whether or not one question ever had both; the estimate lies in their middle. Between looks the
// difference is a line, whose slope is the drift: the one that leaves most room between the two (Moon, Skelly and Towsley 1999, "Estimation
// and removal of clock skew from network delay measurements", take the edge of one of them). A look that is old widens by what a clock wanders from
// its line (RFC 5905, PHI).
//
// No clock runs off faster than `rate_off_max`,
// so looks also bound what the difference is now; where the line leaves what all of them allow, its end counts.
// Looks that exclude each other show that a clock was set, or ran off faster: then the last one alone counts.
// What is shown follows that estimate by slewing, at most half a per cent fast or slow, and never runs backwards.
//
// Pure: local time is given in, in microseconds of any monotonic clock. For one thread.
#pragma once

#include <cstdint>
#include <deque>

namespace seaway {

/// Microseconds of a local monotonic clock.
using LocalUs = std::int64_t;

struct ClockStatus {
    double offset_us = 0;      ///< estimated sea time less local time, now
    double drift_ppm = 0;      ///< how much faster than the local clock the sea runs
    double slew_us = 0;        ///< what is shown still has to make up
    LocalUs round_trip_us = 0; ///< shortest of the window
    /// Bound on the error of the estimate: how far it is from the further end of what all looks of the window allow. Of one look
    /// half its round trip, which no ping can tell from an asymmetric path, and what a clock may have run off since.
    double error_us = 0;
    int samples = 0; ///< in the window
};

class ClockFilter {
  public:
    static constexpr LocalUs window_us = 60'000'000;
    static constexpr std::size_t samples_max = 256;
    static constexpr double slew_rate = 0.005;
    /// Larger differences are not slewed: forward at once, and after begin_anew() at twice the speed; backward at half of it.
    static constexpr double step_us = 250'000;
    /// Two clocks run apart by no more, as parts of one: a server pulls its sea time towards UTC by 0.4 ms a second (SeaClock), systems that
    /// correct their clocks do so by up to 0.5 (adjtime; ntpd; chrony where `maxslewrate 500` says so), and quartz is off by less than
    /// 0.1. Beyond that no bound holds, until the next look: chrony unless it is told, systemd-timesyncd where a clock was off by
    /// more than 4 ms.
    static constexpr double rate_off_max = 1.5e-3;

    /// A reply: sent and received in local time, and the sea time that the server wrote into it.
    /// A reply that came before it was sent is ignored.
    void add(LocalUs sent_us, LocalUs received_us, std::int64_t sea_time_us);

    /// Another server of the same time answers from now on: what was shown goes on from there, slewed. At least one
    /// add() follows before anything is read.
    void begin_anew() {
        window_.clear();
        anew_ = true;
    }

    bool synchronised() const { return !window_.empty(); }

    /// Sea time to show. Never less than at an earlier call, whatever is asked. Needs one sample.
    std::int64_t now(LocalUs local_us);

    ClockStatus status(LocalUs local_us) const;
    /// When status() knows most. Needs one sample.
    LocalUs looked_us() const { return heard_us_; }

  private:
    struct Sample {
        LocalUs sent_us;
        LocalUs round_trip_us;
        LocalUs ahead_us; ///< sea time of the answer less `sent_us`
        LocalUs middle_us() const { return sent_us + round_trip_us / 2; }
    };

    /// Offsets relative to base_us_ that looks leave, and when those were looked that leave no less and no more.
    struct Range {
        double least_us, most_us;
        LocalUs least_at_us, most_at_us;
        double middle_us() const { return 0.5 * (least_us + most_us); }
    };

    void heard();
    /// What all looks of the window leave at heard_us_, of clocks that run apart at `slope`, as a part, and off that by `off` at most.
    Range left(double slope, double off) const;
    double slope_of_most_room() const;
    Range allowed(LocalUs local_us) const;
    double target_offset_us(LocalUs local_us) const;

    std::deque<Sample> window_;
    LocalUs base_us_ = 0;  ///< near all offsets of the window
    LocalUs heard_us_ = 0; ///< the latest middle
    Range at_heard_ = {};  ///< what all looks of the window allow then
    LocalUs best_round_trip_us_ = 0;
    // The estimate: base + middle + slope (local - heard).
    double middle_us_ = 0;
    double slope_ = 0;

    bool anew_ = false; ///< until what is shown is near again
    bool shown_any_ = false;
    LocalUs shown_at_us_ = 0;
    double shown_offset_us_ = 0; ///< of what is shown, relative to base_us_
    std::int64_t shown_us_ = 0;
};

} // namespace seaway
