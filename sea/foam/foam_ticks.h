// SPDX-License-Identifier: Apache-2.0
// When a foam history ticks: on a grid of sea time that the sea alone decides, so that foam at a time
// is the same whoever asks, from where they come and in which steps.
//
// A tick is a whole number of keyframe intervals, at least foam_tick_min_us, and ticks lie at whole
// multiples of it. In a sea that loops they start anew with each loop, and its last tick may be short.
// Between two ticks foam is the earlier one's, advanced by the rest with the strains of the moment.
//
// How far back a history looks:
// - ten decay times; what was before counts for 4.5e-5 and is taken as average;
// - in a loop that is shorter than that, one loop: foam is then the periodic solution, exactly;
// - foam_ticks_max ticks at most. A decay time that needs more is walked as the longest that does not,
//   and the departure from the average is scaled by the root of the ratio of the two, for an average
//   over a time much longer than a wave scatters as one over its root.
//
// Pure values; thread-safe.
#pragma once

#include "sea/basics/time.h"

namespace seaway::sea {

/// Waves that break are as good as still for so long.
inline constexpr TimeUs foam_tick_min_us = 200'000;

inline constexpr double foam_memory_decays = 10.0;

/// Ticks of a start, or of a jump in time, at most.
inline constexpr int foam_ticks_max = 512;

struct FoamTicks {
    TimeUs tick_us = 0;
    TimeUs loop_us = 0;   ///< 0: no loop
    TimeUs memory_us = 0; ///< a start walks through so much; exactly loop_us where `periodic`
    bool periodic = false;
    double decay_s = 0; ///< of the history; shorter than the law's where that needs too many ticks
    double departure = 1; ///< factor on ratio - 1 of the history

    /// The latest tick that is not after t.
    TimeUs at_or_before(TimeUs time_us) const;
    /// The tick after a tick.
    TimeUs after(TimeUs tick) const;
    /// Where the walk to a tick starts.
    TimeUs start_for(TimeUs tick) const;
};

/// decay_s >= 0; interval_us > 0: of the cascade's keyframes.
FoamTicks foam_ticks(double decay_s, TimeUs interval_us, TimeUs loop_us);

} // namespace seaway::sea
