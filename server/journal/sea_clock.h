// SPDX-License-Identifier: Apache-2.0
// The sea's clock: how long ago, by UTC, the sea's epoch was, and which time of the sea it is. So a server that was restarted goes on at the time at
// which it would be, and servers with one epoch agree as well as their clocks do.
//
// Time never goes backwards, but where a pace was heard of late (follow()), and never jumps, but for one case: it runs with the steady clock of the machine
// and is pulled towards UTC by at most one part in 2500: less than what a clock that follows it takes for drift (base/clock_filter.h). Where UTC is far ahead (the machine slept, or its clock was set)
// the sea follows at once.
//
// How fast the sea runs is another matter (sea/basics/pace.h): what is kept by UTC is the time since the epoch, and
// sea time follows from it.
//
// Thread-safe.
#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "base/local_clock.h"
#include "sea/basics/pace.h"
#include "sea/basics/time.h"

namespace seaway::server {

/// One look at the clock.
struct SeaMoment {
    sea::TimeUs now_us;     ///< sea time
    sea::TimeUs elapsed_us; ///< since the epoch; the same, of a sea that has always run at pace 1
    int pace_permille;
    /// How far the time since the epoch is behind what UTC says; ahead of it: negative. Zero, but after the machine's clock was set.
    sea::TimeUs behind_us;
    std::int64_t epoch_utc_us; ///< instant of sea time 0, since 1970-01-01T00:00:00Z
    /// How far `now_us` is ahead of what the paces say: it stands until they have come there, a pace having been heard of too late.
    sea::TimeUs ahead_us = 0;
    /// By how much it has leapt to where UTC was, all leaps since it began together.
    sea::TimeUs leapt_us = 0;
};

/// "2026-11-22T23:17:09.000250Z", of the years 0 to 9999; others as microseconds.
std::string utc_text(std::int64_t utc_us);

class SeaClock {
  public:
    using Microseconds = std::function<std::int64_t()>;

    /// Pulled by one part in this many of the time that passes.
    static constexpr sea::TimeUs pull_parts = 2500;
    /// Further behind than this is caught up with at once.
    static constexpr sea::TimeUs leap_us = 10'000'000;

    /// `utc`: since 1970-01-01T00:00:00Z; `steady`: never set, from anywhere. Those of the machine if not given.
    explicit SeaClock(std::int64_t epoch_utc_us, Microseconds utc = utc_now_us,
                      Microseconds steady = local_now_us, sea::Paces paces = {});

    /// From its moment on. Where that is past, sea time stands until the new pace has come to where it is (SeaMoment::ahead_us),
    /// or goes back to where that is, if it is far (Paces::are_far_behind): there all clients are.
    void follow(const sea::Pace& pace);
    /// What would hold from a moment on at this pace, from where the sea is by then, and has not been beyond.
    sea::Pace next_pace(sea::TimeUs from_us, int permille);
    /// The pace that holds, and those to come.
    std::vector<sea::Pace> paces();

    /// How long it is until that time, by the machine's clock; none: as long as the sea stands.
    std::optional<sea::TimeUs> wait_us(sea::TimeUs sea_us);
    /// As often as clocks do the sea runs, now or once a pace that was announced holds; 1 at least.
    double hurry();
    /// The sea time that passes at most while so much does.
    sea::TimeUs hurried(sea::TimeUs us);

    SeaMoment moment();
    sea::TimeUs now_us() { return moment().now_us; }

    static std::int64_t utc_now_us();

  private:
    SeaMoment locked_moment();

    const std::int64_t epoch_utc_us_;
    const Microseconds utc_;
    const Microseconds steady_;
    std::mutex mutex_; ///< of what follows
    std::int64_t steady_us_;
    sea::TimeUs elapsed_us_;
    sea::Paces paces_;
    sea::TimeUs shown_us_;
    sea::TimeUs unspent_us_ = 0; ///< time that has passed and not come to a microsecond of pull
    sea::TimeUs leapt_us_ = 0;
};

} // namespace seaway::server
