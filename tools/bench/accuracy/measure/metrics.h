// SPDX-License-Identifier: Apache-2.0
// How far answers are from the truth, in the terms that users feel: metres and percent of Hs, crests,
// slopes, velocities, flicker. Intervals are 95 %, by resampling whole times: the points of one time are of one sea at one
// place between keyframes, and tell less than as many points of different times.
//
// Points where the true surface folds are left out: there the two may stand on different sheets. How many
// those are is a figure of its own, and so is how many answers are flagged as folded: at a fold, or so near
// one that the error of the maps leaves it open. Pure functions; thread-safe.
#pragma once

#include <algorithm>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sea/surface/answer.h"
#include "tools/bench/accuracy/truth/points.h"

namespace seaway::bench {

struct Figure {
    std::string metric;
    double value;
    double
        low; ///< of its 95 % interval, of times that were taken the least of all rounds; as `value` where nothing scatters
    double high;
};

inline Figure exact(std::string metric, double value) {
    return {std::move(metric), value, value, value};
}

/// Of the one of that name; 0 where there is none.
inline double value_of(std::span<const Figure> all, std::string_view metric) {
    const auto found =
        std::find_if(all.begin(), all.end(), [&](const Figure& f) { return f.metric == metric; });
    return found == all.end() ? 0.0 : found->value;
}

struct Sample {
    PointKind kind;
    int time;
    sea::Answer truth;
    sea::Answer answer;
};

/// rms_m, mean_m, p99_m          at points anywhere
/// max_m                         at all points
/// crest_m, crest_rms_m          mean (negative: crests too low) and rms on crests
/// steep_rms_m                   where the surface is squeezed most
/// rms_pct_hs, p99_pct_hs, max_pct_hs, crest_pct_hs   of 4 sqrt(m0)
/// slope_rms, normal_p99_deg     of the gradient, and the angle of the normal, anywhere
/// velocity_rms_mps              of all three parts, anywhere
/// folded_pct, flagged_pct       points left out; answers flagged as folded among the others
/// beyond_bound_pct, bound_over_p99   of what answers state as error_m; only where they state one
std::vector<Figure> figures(std::span<const Sample> samples, double hs_m);

/// Root mean square of the second difference of (answer - truth) over frames, m: what is seen as
/// flicker. [point][frame].
double flicker_m(std::span<const double> truth, std::span<const double> answers, int frames);

} // namespace seaway::bench
