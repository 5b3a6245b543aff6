// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/foresight.h"

namespace seaway::server {

using sea::TimeUs;

std::optional<TimeUs> Foresight::asked(TimeUs time_us, TimeUs now_us) {
    if (time_us < now_us - about_us || time_us > now_us + about_us)
        return std::nullopt;
    const std::scoped_lock lock(mutex_);
    const std::optional<TimeUs> before_us = last_now_us_;
    last_now_us_ = now_us;
    if (!before_us || now_us <= *before_us || now_us > *before_us + about_us)
        return std::nullopt;
    const TimeUs goal_us = time_us + ahead_us;
    const bool leapt = ready_us_ > now_us + 2 * about_us; // the clock went back
    if (goal_us < ready_us_ && !leapt)
        return std::nullopt;
    ready_us_ = goal_us + step_us;
    return sea::in_time_range(goal_us) ? std::optional(goal_us) : std::nullopt;
}

} // namespace seaway::server
