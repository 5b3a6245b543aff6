// SPDX-License-Identifier: Apache-2.0
// Cubic Hermite interpolation between two keyframes, once for everything that samples maps. Pure.
#pragma once

#include <cmath>

#include "sea/basics/time.h"

namespace seaway::sea {

/// Weights of (value before, rate before, value after, rate after): `value` mixes the value at a
/// time, `rate` its time derivative.
struct HermiteWeights {
    double value[4];
    double rate[4];
};

/// Beyond its keyframes a sea runs on for no more than this share of their interval, slower and slower, and then stands: a
/// cubic is right for a while, four intervals on it is ten times as high as the waves, and folds everywhere.
inline constexpr double hermite_beyond = 0.25;

/// How far a sea runs on, and how fast, `ahead` after its last keyframe: x / (1 + (x/b)^4)^(1/4), which is 0.1 within a
/// hundredth of itself, smooth, and never more than b.
struct RunsOn {
    double by;
    double pace;
};
inline RunsOn runs_on(double ahead, double most) {
    const double x = ahead / most;
    const double slower = 1.0 / (1.0 + x * x * x * x);
    const double root = std::sqrt(std::sqrt(slower));
    return {ahead * root, slower * root};
}

/// Of one map alone, whose interval is not known, s: what the shortest waves bear.
inline constexpr double hermite_beyond_alone_s = 0.05;

/// A time outside the span is one within hermite_beyond of it. Where both keyframes are the same map, the value is carried on by
/// its rate, for hermite_beyond_alone_s.
inline HermiteWeights hermite_weights(TimeUs before_us, TimeUs after_us, TimeUs time_us) {
    const double span_s = seconds_from_us(after_us - before_us);
    if (span_s <= 0) {
        const RunsOn on = runs_on(seconds_from_us(time_us - before_us), hermite_beyond_alone_s);
        return {{1, on.by, 0, 0}, {0, on.pace, 0, 0}};
    }
    double s = seconds_from_us(time_us - before_us) / span_s;
    double pace = 1;
    if (s < 0 || s > 1) {
        const double end = s < 0 ? 0.0 : 1.0;
        const RunsOn on = runs_on(s - end, hermite_beyond);
        s = end + on.by;
        pace = on.pace;
    }
    const double r = 1 - s;
    return {{r * r * (1 + 2 * s), s * r * r * span_s, s * s * (1 + 2 * r), -s * s * r * span_s},
            {-6 * s * r / span_s * pace, r * (1 - 3 * s) * pace, 6 * s * r / span_s * pace,
             s * (1 - 3 * r) * pace}};
}

} // namespace seaway::sea
