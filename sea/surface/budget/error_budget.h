// SPDX-License-Identifier: Apache-2.0
// One budget for the height, shared by all that costs accuracy: `accuracy.height_error_m` of a scene
// is the bound that answers state at the worst time and place on level water, from tiles as well. What
// grids miss is given by the scene; what is left is spent on keyframe intervals and the codec such that a
// second of sea is as cheap as it can be (sea/surface/budget/spending.h).
//
// Everything that is missed counts as a variance and adds up as one: waves, cascades, fields and causes
// are independent. A bound is five standard deviations (sea/surface/map_error.h), to which single
// precision is added. Stylised waves that are no modes count with a bound of their own
// (sea/surface/budget/sine_error.h).
//
// Pure functions; thread-safe. Cost: a few milliseconds a cascade, and what sine_error.h says.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "sea/basics/field.h"
#include "sea/surface/budget/cascade_waves.h"
#include "sea/surface/budget/interpolation_laws.h"
#include "sea/surface/budget/spending.h"
#include "sea/surface/inverse.h"
#include "sea/surface/map_error.h"
#include "sea/waves/realization.h"

namespace seaway::sea {

/// The share of the budget that the inverse may leave as a residual sideways, where the surface is as
/// steep as it is high.
inline constexpr double inverse_share = 0.02;

/// The grids that maps can be cut to (sea/surface/budget/coarser.h), largest first: even, and quick to transform.
inline constexpr std::array smaller_grids{256, 128, 64, 32};
/// Keyframes may be left out as long as one of so many is left, and as long as they tell of the waves.
inline constexpr int every_most = 8;

/// What the keyframes of one cascade cost in accuracy.
struct CascadeBudget {
    TimeUs interval_us = 0;
    CascadeLoss loss;       ///< between keyframes and grid points; nothing is coded
    double codec_share = 0; ///< of the variance that coding may cost; they add up to 1
    double spacing_m = 0;   ///< between grid points
    int size = 0;           ///< grid points a side
    /// The grid at which compact tiles send its linear maps: the smallest that carries its waves, or its own.
    int compact_size = 0;
    double compact_share =
        1; ///< of the variance of coding that is left of it on the cascade's own grid
    /// Of what maps may be coarser than that: cut to one of smaller_grids each, and with every n-th keyframe alone, at
    /// n - 1, as long as these tell of the waves.
    double follows_gain =
        0; ///< likewise of that, in displacements that follow from heights (CascadeWaves)
    struct Cut {
        CutWaves waves;
        double follows_gain = 0;
    };
    struct Slow {
        double time_m = 0;
        double displacement_time_m = 0;
        double strain = 0; ///< rms
    };
    std::array<Cut, smaller_grids.size()> cuts{};
    std::array<Slow, every_most> slow{};
    bool can_be_cut = false;
    int every_max = 1;
    bool stylised = false; ///< some of its waves are no modes: they move nothing sideways
};

struct ErrorBudget {
    double height_error_m = 0;
    std::vector<CascadeBudget> cascades;
    /// What coded tiles are allowed to cost of a height, all cascades together and at the worst moment:
    /// bound_sigmas standard deviations, at typical slopes.
    double codec_error_m = 0;
    double single_precision_m = 0;              ///< part of every bound on a height
    double single_precision_displacement_m = 0; ///< likewise of D
    /// Bounds at the worst time and place, single precision included.
    double interpolation_m = 0;
    double interpolation_displacement_m = 0; ///< of D: in shallow water more than that
    double interpolation_strain = 0;         ///< of grad D, fold_sigmas standard deviations
    double rms_slope = 0;                    ///< of the realised sea, 1
    /// Displacements of all cascades follow from heights, where these come compact: they need not be sent.
    bool displacement_follows = false;
    /// Of the divergence of D; in deep water rms_slope. At least folds_searched_above times the strain of
    /// all waves together whose phases were given.
    double rms_strain = 0;
    double curvature_per_m = 0;      ///< of the surface at choppiness 0, at most
    double displacement_reach_m = 0; ///< lambda |D| stays below this (six standard deviations)
    double bits_per_s = 0;           ///< what spending.h prices a second of this at
    Choppiness choppiness;
};

/// Displacements follow from heights where that makes no more noise of them than heights have: not where water is shallow for
/// most waves.
inline constexpr double follows_gain_max = 1.0;

/// An interval is chosen by what it costs of a height: directly, and by what it moves a point
/// sideways times the typical slope.
ErrorBudget plan_budget(const Realization& sea, double height_error_m);

/// Intervals are given, one a cascade; what is left of the budget goes to the codec, a sixteenth of its
/// variance at least. `glide`: of a sea that glides so, whose waves are at most these.
ErrorBudget plan_budget(const Realization& sea, double height_error_m,
                        std::span<const TimeUs> intervals_us, const DepthGlide& glide = {});

/// How answers about this sea look for folds.
FoldSearch fold_search(const ErrorBudget& budget);

/// Residual that the inverse may leave, m.
double inverse_tolerance_m(double height_error_m);

/// Bound that heights from tiles state on level water at the worst time and place, when coding may cost
/// `codec_error_m` (budget.codec_error_m: the best quality). Above `height_error_m` where the grids are too
/// coarse for what was asked, or where even the shortest interval is too long.
double level_error_m(const ErrorBudget& budget, double codec_error_m);

/// Bounds for the codec, one a field of `fields` in table order, in the field's unit, such that
/// tiles of all cascades together cost `codec_error_m` of height (as ErrorBudget::codec_error_m). Fields
/// that no height depends on (slopes, strains, Jacobian, foam) get a fixed bound. Bounds are of samples that are
/// sent: those of compact tiles may be wider, for what a client brings them to its own grid with leaves noise
/// in waves that nobody has.
std::vector<float> codec_bounds(const ErrorBudget& budget, FieldSet fields, int cascade,
                                double codec_error_m, bool compact = false);

/// The same of maps that are sent on a grid of `sent_size` points a side, which may be their own, when only every
/// `every`-th keyframe is sent.
std::vector<float> codec_bounds(const ErrorBudget& budget, FieldSet fields, int cascade,
                                double codec_error_m, int sent_size, int every);

/// What compact tiles may cost of a height beside that: single precision on the way to the smaller grid and back.
double compact_error_m(const ErrorBudget& budget);

/// The error of heights sampled from maps that were coded with `codec_error_m` (0: not coded).
MapError map_error(const ErrorBudget& budget, double codec_error_m);

/// Standard deviation of values that were rounded to within a bound: they lie anywhere in it.
double rounded_rms(double bound);

/// What coding costs of the gradient of lambda D: a bound (fold_sigmas), from the variances that
/// coded_strain_variance() gives for each cascade.
double coded_strain_bound(const Choppiness& choppiness, double variance);
/// `loss` is of lambda D. `spacing_m` of the samples that were coded; `compact`: they were brought to another grid.
double coded_strain_variance(const MapLoss& loss, double interval_s, double spacing_m,
                             bool compact = false);

} // namespace seaway::sea
