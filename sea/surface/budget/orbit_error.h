// SPDX-License-Identifier: Apache-2.0
// What keyframes miss of displacements while the depth glides: a wave of one height moves water sideways by coth(k d) of it, which
// changes by itself, and at orbit_kd_min with a kink. Pure; thread-safe.
#pragma once

#include "sea/basics/time.h"

namespace seaway::sea {

/// From one depth to another (sea/basics/glide.h); a steady sea has one.
struct DepthGlide {
    TimeUs us = 0; ///< how long it takes; 0: the sea is steady
    double from_m = 0;
    double to_m = 0;

    bool changes() const { return us > 0 && from_m != to_m; }
};

/// By so much Hermite's cubic is off coth(k d) at most, in keyframes that are so far apart and have its rate, wherever in the glide they lie. Cost: some
/// 1000 hyperbolic functions.
double orbit_error(double k_radpm, const DepthGlide& glide, TimeUs interval_us);

} // namespace seaway::sea
