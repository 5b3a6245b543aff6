// SPDX-License-Identifier: Apache-2.0
// Probe: what a sea is at one undisplaced place and time, told beforehand, so that whoever rebuilds the sea
// can see whether it is the same one (sea/waves/probes.h).
#pragma once

#include "sea/basics/time.h"

namespace seaway::sea {

struct Probe {
    double x_m; ///< undisplaced place
    double y_m;
    TimeUs time_us;
    double height_m;         ///< eta there, all cascades summed
    double displacement_x_m; ///< D there, at choppiness 1
    double displacement_y_m;
    bool operator==(const Probe&) const = default;
};

/// Of one sea.
inline constexpr int probe_count = 16;

/// How far a sea that was rebuilt from the same numbers, in double precision, may be from its probes, m: nine
/// tenths are for other last places of sines, roots and frequencies. Another sea is a million times further off.
inline constexpr double probe_error_m = 1e-6;

} // namespace seaway::sea
