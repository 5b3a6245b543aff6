// SPDX-License-Identifier: Apache-2.0
// Cubic Hermite interpolation between two keyframes, once for everything that samples maps. Pure.
#pragma once

#include "sea/basics/time.h"

namespace seaway::sea {

/// Weights of (value before, rate before, value after, rate after): `value` mixes the value at a
/// time, `rate` its time derivative.
struct HermiteWeights {
    double value[4];
    double rate[4];
};

/// A time outside the span extrapolates the cubic. Where both keyframes are the same map, the value
/// is carried on by its rate.
inline HermiteWeights hermite_weights(TimeUs before_us, TimeUs after_us, TimeUs time_us) {
    const double span_s = seconds_from_us(after_us - before_us);
    if (span_s <= 0)
        return {{1, seconds_from_us(time_us - before_us), 0, 0}, {0, 1, 0, 0}};
    const double s = seconds_from_us(time_us - before_us) / span_s;
    const double r = 1 - s;
    return {{r * r * (1 + 2 * s), s * r * r * span_s, s * s * (1 + 2 * r), -s * s * r * span_s},
            {-6 * s * r / span_s, r * (1 - 3 * s), 6 * s * r / span_s, s * (1 - 3 * r)}};
}

} // namespace seaway::sea
