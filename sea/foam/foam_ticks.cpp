// SPDX-License-Identifier: Apache-2.0
#include "sea/foam/foam_ticks.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"

namespace seaway::sea {

namespace {

/// The largest multiple of `step` that is not above `value`.
TimeUs multiple_at_or_below(TimeUs value, TimeUs step) {
    const TimeUs rest = value % step;
    return value - (rest < 0 ? rest + step : rest);
}

} // namespace

TimeUs FoamTicks::at_or_before(TimeUs time_us) const {
    const TimeUs loop_start_us = loop_us > 0 ? multiple_at_or_below(time_us, loop_us) : 0;
    return loop_start_us + multiple_at_or_below(time_us - loop_start_us, tick_us);
}

TimeUs FoamTicks::after(TimeUs tick) const {
    if (loop_us == 0)
        return tick + tick_us;
    const TimeUs next_loop_us = multiple_at_or_below(tick, loop_us) + loop_us;
    return std::min(tick + tick_us, next_loop_us);
}

TimeUs FoamTicks::start_for(TimeUs tick) const {
    return periodic ? tick - loop_us : at_or_before(tick - memory_us);
}

FoamTicks foam_ticks(double decay_s, TimeUs interval_us, TimeUs loop_us) {
    SEAWAY_CHECK(interval_us > 0 && decay_s >= 0 && loop_us >= 0, "foam ticks need an interval");
    FoamTicks ticks;
    ticks.loop_us = loop_us;
    ticks.tick_us = interval_us * ((foam_tick_min_us + interval_us - 1) / interval_us);
    const double longest_s = seconds_from_us(ticks.tick_us) * foam_ticks_max / foam_memory_decays;
    ticks.decay_s = std::min(decay_s, longest_s);
    ticks.memory_us = std::max(us_from_seconds(foam_memory_decays * ticks.decay_s), ticks.tick_us);
    ticks.periodic = loop_us > 0 && loop_us <= ticks.memory_us && decay_s > 0;
    if (ticks.periodic)
        ticks.memory_us = loop_us;
    if (decay_s > ticks.decay_s) {
        // A loop holds no more independent moments than it is long, two decay times being one.
        const double enough_s =
            loop_us > 0 ? std::max(0.5 * seconds_from_us(loop_us), ticks.decay_s) : decay_s;
        ticks.departure = std::sqrt(ticks.decay_s / std::min(decay_s, enough_s));
    }
    return ticks;
}

} // namespace seaway::sea
