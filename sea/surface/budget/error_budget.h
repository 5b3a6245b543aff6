// SPDX-License-Identifier: Apache-2.0
// One budget for the height, shared by all that costs accuracy: `accuracy.height_error_m` of a
// scene is divided among interpolation in time, interpolation in space, the codec and the inverse
// displacement. From it follow the keyframe interval of each cascade and the codec's bounds.
//
// Laws (reference: docs/physics.md, "Interpolation"): a wave of phase step u = omega * interval
// between keyframes is missed by 1 - cos(u/2) - (u/4) sin(u/2) ~ u^4/384 of its amplitude; one of
// q = k dx between grid points by 2 r / (1 + r), r = sum_{j != 0} (q / (q + 2 pi j))^4. Random
// waves add in the square; the stated bound is six standard deviations of the sum, which one point
// in 5e8 exceeds. What single precision costs is added to it. Stylised waves that are no modes count with a bound of their own
// (sea/surface/budget/sine_error.h). The codec's bound is hard.
//
// Pure functions; thread-safe. Cost: a few milliseconds a cascade, and what sine_error.h says.
#pragma once

#include <numbers>
#include <vector>

#include "sea/basics/field.h"
#include "sea/surface/surface.h"
#include "sea/waves/realization.h"

namespace seaway::sea {

/// Shares of the height budget; they add up to one.
struct BudgetShares {
    double time = 0.25;
    double space = 0.20;
    double codec = 0.45;
    double query = 0.10;
};

/// Keyframe intervals to choose from, longest first; each divides 2 s.
inline constexpr TimeUs keyframe_intervals_us[] = {2'000'000, 1'000'000, 500'000, 250'000, 200'000,
                                                   125'000,   100'000,   62'500,  50'000,  40'000,
                                                   25'000,    20'000,    12'500,  10'000};

/// What the keyframes of one cascade cost in accuracy.
struct CascadeBudget {
    TimeUs interval_us = 0;
    double time_rms_m = 0;  ///< of heights, at the worst moment between two keyframes
    double space_rms_m = 0; ///< of heights, at the worst place between grid points
    double spacing_m = 0;   ///< between them
};

struct ErrorBudget {
    double height_error_m = 0;
    BudgetShares shares;
    std::vector<CascadeBudget> cascades;
    /// Bound: six standard deviations of time and space together, and single precision.
    double interpolation_m = 0;
    double interpolation_displacement_m = 0; ///< likewise, of D: in shallow water more than that
    double interpolation_strain = 0;         ///< likewise, of grad D
    double rms_slope = 0;                    ///< of the realised sea, 1
    double rms_strain = 0;                   ///< of the divergence of D; in deep water rms_slope
    double displacement_reach_m = 0; ///< lambda |D| stays below this (six standard deviations)
    Choppiness choppiness;
};

/// An interval is chosen by what it costs of a height: directly, and by what it moves a point
/// sideways times the slope of steep places, which counts more on shallow water.
ErrorBudget plan_budget(const Realization& sea, double height_error_m);

/// How answers about this sea look for folds.
FoldSearch fold_search(const ErrorBudget& budget);

/// Error of heights on level water that a coded tile is held to: interpolation and the codec's
/// share. Above `height_error_m` where the grids are too coarse for what was asked, or where even
/// the shortest interval is too long.
double level_error_m(const ErrorBudget& budget);

/// Bound on the amplitude share that cubic Hermite misses between two keyframes at phase step
/// u = omega * interval >= 0: at every time between them and at every phase of the wave. Never falls
/// as u grows. Up to hermite_phase_max it is met, in the middle; beyond, keyframes know nothing of
/// the wave, and no interval is chosen there while there is a shorter one.
double hermite_error(double u);
inline constexpr double hermite_phase_max = 2.0 * std::numbers::pi;

/// Amplitude share that a cubic spline misses at phase step q = k dx, 0 .. pi.
double spline_error(double q);

/// Largest error of the derivative of a cubic spline at phase step q, as a share of q.
double spline_slope_error(double q);

/// What single precision costs a sampled value, from the transform to the sum over cascades, as a share
/// of four times the rms of its map: twice the largest that random points showed on any device.
inline constexpr double single_precision_share = 5e-7;

/// Bounds for the codec, one a field of `fields` in table order, in the field's unit, such that
/// tiles of all `cascade_count` cascades together cost at most `codec_error_m` of height. Fields
/// that no height depends on (slopes, strains, Jacobian, foam) get a fixed bound.
std::vector<float> codec_bounds(const ErrorBudget& budget, FieldSet fields, int cascade,
                                double codec_error_m);

/// The error of heights sampled from maps that were coded with `codec_error_m` (0: not coded).
MapError map_error(const ErrorBudget& budget, double codec_error_m);

/// Largest error of a value sampled between two coded keyframes of one cascade, in the unit of the
/// value, when the values carry errors up to `value_error` and their time rates up to `rate_error`.
/// What a client adds up over cascades from the bounds that its tiles state.
double sampled_codec_error(double value_error, double rate_error, double interval_s);

/// Of a gradient, per m, when the sampled value may be wrong by that much: samples `spacing_m` apart.
double sampled_slope_error(double sampled_error, double spacing_m);

} // namespace seaway::sea
