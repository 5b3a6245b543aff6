// SPDX-License-Identifier: Apache-2.0
// How a budget of accuracy is spent: which keyframe interval each cascade gets, and how much is left for
// coding, such that a second of sea is as cheap as it can be.
//
// Cost, in bits: a keyframe has keyframe_bits a grid point for computing it and making it ready, and what
// its six coded fields need, by the entropy of what the predictor leaves (Laplace's differences quantised
// to twice the bound: 1/2 log2 of 2 pi e times their variance in steps). Longer intervals make fewer
// keyframes and lose u^4; coarser bounds save half a bit for each doubling of their variance. Errors add in
// the square, so time and codec share one sum of variances.
//
// Intervals are shortened one at a time, where that costs least for what it gains: that order does not
// depend on the budget, so a looser one never gets a shorter interval. Every point on that way is priced
// with what it leaves to the codec, and the cheapest wins. What of it a cascade's tiles get is exact: the
// entropy of all is least where a cascade's variance goes as the rate of its grid points.
//
// Pure; thread-safe. Some tenths of a millisecond beside the losses of the intervals.
#pragma once

#include <span>
#include <vector>

#include "sea/surface/budget/cascade_waves.h"

namespace seaway::sea {

/// A keyframe is published this long of clocks before its interval begins, so that it is decoded in time: of a sea that runs
/// faster than clocks so many times as much sea time.
inline constexpr TimeUs publish_lead_us = 250'000;

/// Keyframe intervals to choose from, longest first: steps of a quarter or less.
inline constexpr TimeUs keyframe_intervals_us[] = {
    2'000'000, 1'600'000, 1'250'000, 1'000'000, 800'000, 640'000, 500'000, 400'000,
    320'000,   250'000,   200'000,   160'000,   125'000, 100'000, 80'000,  64'000,
    50'000,    40'000,    32'000,    25'000,    20'000,  16'000,  12'500,  10'000};

/// What computing a keyframe and making it ready to be sampled costs beside its bits, a grid point.
inline constexpr double keyframe_bits = 24.0;

/// Bound of a coded time rate, times the interval, over that of a value: near the best for the sum of
/// bits at a given loss between two keyframes, and the same for all.
inline constexpr double rate_over_value = 4.9;

/// Neither what keyframes miss of the strains of a sea nor what coding adds to them may be more than
/// this, fold_sigmas standard deviations each: a budget for heights that is loose would cost the slopes of
/// short waves, and leave open everywhere whether the surface folds.
inline constexpr double strain_error_max = 0.15;

struct Spending {
    std::vector<TimeUs> intervals_us; ///< one a cascade
    double codec_m2 = 0;              ///< variance of heights that is left to coding
    std::vector<double> codec_shares; ///< of codec_m2, one a cascade; they add up to 1
    double bits_per_s = 0;            ///< the cost
};

/// Time and codec together may lose `variance_m2` of heights, a displacement counted with
/// `sideways_weight`. Where the shortest intervals lose more, it is these and half of it for the codec.
Spending spend(std::span<const CascadeWaves> cascades, double variance_m2, double sideways_weight);

/// The same at given intervals, of which nothing is chosen.
Spending spend_at(std::span<const CascadeWaves> cascades, std::span<const TimeUs> intervals_us,
                  double variance_m2, double sideways_weight);

/// Bound of values that may lose `variance_m2` of heights between two keyframes, at worst, when those of
/// displacements have it too.
double value_bound_m(double variance_m2, double sideways_weight);

} // namespace seaway::sea
