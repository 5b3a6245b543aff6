// SPDX-License-Identifier: Apache-2.0
// How a sea glides over to another: the share of the new one at each time, the same for amplitudes, choppiness and foam,
// and for servers and clients. Smootherstep (Perlin 2002): no jump in value, slope or curvature. Pure; thread-safe.
#pragma once

#include <algorithm>

#include "sea/basics/time.h"

namespace seaway::sea {

/// The shortest and the longest time that a glide may take: below, amplitudes would change within the periods of the
/// waves.
inline constexpr TimeUs glide_us_min = 10'000'000;
inline constexpr TimeUs glide_us_max = TimeUs{30} * 86'400 * 1'000'000;

namespace detail {

/// Of the time from start to end, how much has passed.
inline double passed_share(TimeUs time_us, TimeUs start_us, TimeUs end_us) {
    if (time_us >= end_us)
        return 1.0;
    return time_us <= start_us
               ? 0.0
               : static_cast<double>(time_us - start_us) / static_cast<double>(end_us - start_us);
}

} // namespace detail

/// x^3 (10 - 15 x + 6 x^2), x the share of the time that has passed: 0 before the start, 1 after the end. Never more, where that
/// polynomial rounds to 1 + 1e-15 in the last thousandth of the way: the inverse of a depth that glides to infinity would be
/// less than nothing.
inline double glide_share(TimeUs time_us, TimeUs start_us, TimeUs end_us) {
    const double x = detail::passed_share(time_us, start_us, end_us);
    return std::min(1.0, x * x * x * (10.0 + x * (-15.0 + 6.0 * x)));
}

/// Its rate, 1/s: 30 x^2 (1 - x)^2 over the duration.
inline double glide_rate(TimeUs time_us, TimeUs start_us, TimeUs end_us) {
    const double x = detail::passed_share(time_us, start_us, end_us);
    if (x <= 0.0 || x >= 1.0)
        return 0.0;
    return 30.0 * x * x * (1.0 - x) * (1.0 - x) / seconds_from_us(end_us - start_us);
}

/// What a value that glides from `a` to `b` has come to.
inline double glided(double a, double b, double share) {
    return a + share * (b - a);
}

/// A depth glides by its inverse: deep water is none, and coth(kd) moves without a jump.
inline double glided_depth_m(double a_m, double b_m, double share) {
    return a_m == b_m ? a_m : 1.0 / glided(1.0 / a_m, 1.0 / b_m, share);
}

} // namespace seaway::sea
