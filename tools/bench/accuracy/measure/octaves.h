// SPDX-License-Identifier: Apache-2.0
// Energy and phase octave by octave of wavenumber: what a configuration shows of each wave, sampled on a
// grid twice as fine as its maps and transformed, against the wave itself. At moments spread evenly over an
// interval between keyframes, each cascade over its own: at a keyframe nothing is missed in time, half way most is.
//
// For one thread; about 1.5 s for three cascades of 256.
#pragma once

#include <vector>

#include "base/result.h"
#include "tools/bench/accuracy/seas/configured_sea.h"

namespace seaway::bench {

/// How far into an interval: 0.1, 0.3 .. 0.9 of it. By these the mean of what Hermite misses, (s (1 - s))^4, is right to
/// 0.2 %.
inline constexpr int octave_moments = 5;

struct Octave {
    double k_radpm = 0;          ///< its lower end, a power of two
    double variance_m2 = 0;      ///< of the waves that the truth has there, mean of the moments
    double energy_error_pct = 0; ///< of what is shown, against it, over all moments
    double energy_error_worst_pct = 0; ///< of the moment that is furthest off
    double phase_error_rad = 0;        ///< of what is shown: root mean square by energy
};

/// In the intervals that `time_us` lies in; the sea goes there. Empty for a sea without maps.
Result<std::vector<Octave>> octaves(ConfiguredSea& sea, sea::TimeUs time_us);

} // namespace seaway::bench
