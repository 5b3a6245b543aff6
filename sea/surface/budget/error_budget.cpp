// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/budget/error_budget.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "sea/surface/budget/cascade_waves.h"
#include "sea/surface/budget/interpolation_laws.h"
#include "sea/surface/maps/regrid.h"

namespace seaway::sea {

namespace {

/// Bounds for maps that no height depends on: fine enough for shading and foam.
constexpr float slope_error = 0.002f;
constexpr float jacobian_error = 0.004f;

/// Where grids miss more than was asked, intervals and codec still get this share of the variance asked
/// for: what they could add to that stays small beside it.
constexpr double spent_at_least = 1.0 / 16.0;

/// Smaller grids are worth so much of the budget to single precision, and no more.
constexpr double compact_error_share = 0.01;

/// What a metre sideways costs of a height at typical slopes.
double sideways_weight(const ErrorBudget& budget) {
    return budget.choppiness.largest() * std::min(1.0, budget.rms_slope);
}

/// All but the intervals and what follows from them.
ErrorBudget outline(const Realization& sea, std::span<const CascadeWaves> cascades,
                    double height_error_m) {
    ErrorBudget budget;
    budget.height_error_m = height_error_m;
    budget.choppiness = sea.choppiness;
    WaveSum slope, strain, displacement, curvature;
    for (const CascadeWaves& waves : cascades) {
        slope.add(waves.height().gradient, 1.0);
        strain.add(waves.displacement().gradient, 1.0);
        displacement.add(waves.displacement().whole, 1.0);
        curvature.add(waves.curvature(), 1.0);
        budget.single_precision_m += waves.height().single_m;
        budget.single_precision_displacement_m += waves.displacement().single_m;
    }
    budget.rms_slope = std::sqrt(slope.mean_square_m2());
    budget.curvature_per_m = bound_sigmas * std::sqrt(curvature.variance_m2(bound_sigmas));
    // Waves that may agree fold the sea where their strains add up to one.
    budget.rms_strain = std::sqrt(strain.variance_m2(1.0 / folds_searched_above));
    budget.displacement_reach_m =
        fold_sigmas * std::sqrt(displacement.variance_m2(fold_sigmas)) * sea.choppiness.largest();
    return budget;
}

/// The variance that time and codec may share.
double left_to_spend(const ErrorBudget& budget, std::span<const CascadeWaves> cascades) {
    const double weight = sideways_weight(budget);
    const double beside_m = budget.single_precision_m +
                            weight * budget.single_precision_displacement_m +
                            inverse_share * budget.height_error_m;
    const double asked_m2 = square(
        std::max(budget.height_error_m - beside_m, 0.5 * budget.height_error_m) / bound_sigmas);
    double missed_m2 = 0;
    for (const CascadeWaves& waves : cascades)
        missed_m2 +=
            waves.height().east_m2 + waves.height().north_m2 +
            square(weight) * (waves.displacement().east_m2 + waves.displacement().north_m2);
    return std::max(asked_m2 - missed_m2, spent_at_least * asked_m2);
}

/// What coarser maps of these waves miss.
void note_coarser(CascadeBudget& cascade, const CascadeWaves& waves) {
    cascade.can_be_cut = waves.can_be_cut();
    for (std::size_t n = 0; n < smaller_grids.size() && cascade.can_be_cut; ++n)
        if (smaller_grids[n] < cascade.size)
            cascade.cuts[n] = {waves.cut(smaller_grids[n]), waves.follows_gain(smaller_grids[n])};
    for (int every = 1; every <= every_most; ++every) {
        const TimeUs interval_us = every * cascade.interval_us;
        if (every > 1 && !waves.told_by(interval_us))
            break;
        const CascadeWaves::SlowLoss slow = waves.slow_loss(cascade.interval_us, interval_us);
        cascade.slow[static_cast<std::size_t>(every - 1)] = {slow.height_m, slow.displacement_m,
                                                             waves.time_strain_rms(interval_us)};
        cascade.every_max = every;
    }
}

void settle(ErrorBudget& budget, std::span<const CascadeWaves> cascades, const Spending& spending) {
    double height_m2 = 0, displacement_m2 = 0, strain2 = 0, single_strain = 0;
    std::size_t following = 0;
    for (std::size_t c = 0; c < cascades.size(); ++c) {
        const CascadeWaves& waves = cascades[c];
        const TimeUs interval_us = spending.intervals_us[c];
        budget.cascades.push_back({interval_us, waves.loss(interval_us), spending.codec_shares[c],
                                   waves.spacing_m(), waves.size(), waves.size()});
        if (compact_error_m(budget) <= compact_error_share * budget.height_error_m &&
            waves.compact_size() < waves.size()) {
            budget.cascades.back().compact_size = waves.compact_size();
            budget.cascades.back().compact_share = disc_share(waves.compact_size());
            budget.cascades.back().follows_gain = waves.follows_gain();
            following += waves.follows_gain() <= follows_gain_max ? 1u : 0u;
        }
        note_coarser(budget.cascades.back(), waves);
        budget.cascades.back().stylised = waves.has_stylised();
        const CascadeLoss& loss = budget.cascades.back().loss;
        height_m2 += loss.height.interpolation_variance_m2();
        displacement_m2 += loss.displacement.interpolation_variance_m2();
        strain2 += square(waves.strain_rms(interval_us));
        single_strain += waves.strain().single_m;
    }
    budget.displacement_follows = following == cascades.size();
    budget.codec_error_m = bound_sigmas * std::sqrt(spending.codec_m2);
    budget.interpolation_m = bound_sigmas * std::sqrt(height_m2) + budget.single_precision_m;
    budget.interpolation_displacement_m =
        bound_sigmas * std::sqrt(displacement_m2) + budget.single_precision_displacement_m;
    budget.interpolation_strain = fold_sigmas * std::sqrt(strain2) + single_strain;
    budget.bits_per_s = spending.bits_per_s;
}

std::vector<CascadeWaves> waves_of(const Realization& sea, const DepthGlide& glide = {}) {
    std::vector<CascadeWaves> all;
    all.reserve(sea.cascades.size());
    const auto given = static_cast<int>(std::ranges::count_if(sea.cascades, has_given));
    for (const CascadeModes& modes : sea.cascades)
        all.emplace_back(modes, glide, given);
    return all;
}

/// Bound of a coded value of this cascade.
double coded_value_bound_m(const ErrorBudget& budget, const CascadeBudget& cascade,
                           double codec_error_m) {
    return value_bound_m(square(codec_error_m / bound_sigmas) * cascade.codec_share,
                         sideways_weight(budget));
}

} // namespace

ErrorBudget plan_budget(const Realization& sea, double height_error_m) {
    const std::vector<CascadeWaves> cascades = waves_of(sea);
    ErrorBudget budget = outline(sea, cascades, height_error_m);
    settle(budget, cascades,
           spend(cascades, left_to_spend(budget, cascades), sideways_weight(budget)));
    return budget;
}

ErrorBudget plan_budget(const Realization& sea, double height_error_m,
                        std::span<const TimeUs> intervals_us, const DepthGlide& glide) {
    const std::vector<CascadeWaves> cascades = waves_of(sea, glide);
    ErrorBudget budget = outline(sea, cascades, height_error_m);
    const double weight = sideways_weight(budget);
    const double all_m2 = left_to_spend(budget, cascades);
    double codec_m2 = all_m2;
    for (std::size_t c = 0; c < cascades.size(); ++c)
        codec_m2 -= cascades[c].time_costs_m2(intervals_us[c], weight);
    settle(budget, cascades,
           spend_at(cascades, intervals_us, std::max(codec_m2, spent_at_least * all_m2), weight));
    return budget;
}

double inverse_tolerance_m(double height_error_m) {
    return std::max(inverse_share * height_error_m, 1e-7);
}

double level_error_m(const ErrorBudget& budget, double codec_error_m) {
    double variance_m2 =
        square(codec_error_m / bound_sigmas) / (1.0 + square(sideways_weight(budget)));
    for (const CascadeBudget& cascade : budget.cascades)
        variance_m2 += cascade.loss.height.interpolation_variance_m2();
    return bound_sigmas * std::sqrt(variance_m2) + budget.single_precision_m;
}

double compact_error_m(const ErrorBudget& budget) {
    return regrid_over_single * budget.single_precision_m;
}

FoldSearch fold_search(const ErrorBudget& budget) {
    return fold_search(budget.displacement_reach_m, budget.choppiness, budget.rms_strain);
}

std::vector<float> codec_bounds(const ErrorBudget& budget, FieldSet fields, int cascade,
                                double codec_error_m, bool compact) {
    const CascadeBudget& own = budget.cascades[static_cast<std::size_t>(cascade)];
    return codec_bounds(budget, fields, cascade, codec_error_m,
                        compact ? own.compact_size : own.size, 1);
}

std::vector<float> codec_bounds(const ErrorBudget& budget, FieldSet fields, int cascade,
                                double codec_error_m, int sent_size, int every) {
    const CascadeBudget& own = budget.cascades[static_cast<std::size_t>(cascade)];
    const double share = sent_size == own.size           ? 1.0
                         : sent_size == own.compact_size ? own.compact_share
                                                         : disc_share(sent_size);
    const double value_m = coded_value_bound_m(budget, own, codec_error_m) / std::sqrt(share);
    const double interval_s = seconds_from_us(every * own.interval_us);
    std::vector<float> bounds;
    for (const Field field : fields) {
        const FieldInfo& row = info(field);
        if (surface_fields.contains(field))
            bounds.push_back(static_cast<float>(
                row.time_rate ? rate_over_value * value_m / interval_s : value_m));
        else
            bounds.push_back(is_linear(field) ? slope_error : jacobian_error);
    }
    return bounds;
}

double rounded_rms(double bound) {
    return bound * std::numbers::inv_sqrt3;
}

double coded_strain_variance(const MapLoss& loss, double interval_s, double spacing_m,
                             bool compact) {
    MapLoss coded;
    coded.value_m = loss.value_m;
    coded.rate_mps = loss.rate_mps;
    return coded.largest_variance_m2(interval_s) *
           (compact ? disc_slope_variance_gain : spline_slope_variance_gain) / square(spacing_m);
}

double coded_strain_bound(const Choppiness& choppiness, double variance) {
    // The larger eigenvalue of a symmetric matrix: at most the root of the sum of its squares.
    return choppiness.largest() * fold_sigmas * std::numbers::sqrt2 * std::sqrt(variance);
}

MapError map_error(const ErrorBudget& budget, double codec_error_m) {
    MapError error{.cascades = {},
                   .height_bound_m = budget.single_precision_m,
                   .displacement_bound_m = budget.single_precision_displacement_m,
                   .strain_bound = budget.interpolation_strain,
                   .rms_slope = budget.rms_slope,
                   .curvature_per_m = budget.curvature_per_m};
    double coded_strain2 = 0;
    for (const CascadeBudget& cascade : budget.cascades) {
        CascadeLoss& loss = error.cascades.emplace_back(cascade.loss);
        if (!(codec_error_m > 0))
            continue;
        const double interval_s = seconds_from_us(cascade.interval_us);
        const double value_m = rounded_rms(coded_value_bound_m(budget, cascade, codec_error_m));
        for (MapLoss* map : {&loss.height, &loss.displacement}) {
            map->value_m = value_m;
            map->rate_mps = rate_over_value * value_m / interval_s;
        }
        coded_strain2 += coded_strain_variance(loss.displacement, interval_s, cascade.spacing_m);
    }
    error.codec_strain_bound = coded_strain_bound(budget.choppiness, coded_strain2);
    return error;
}

} // namespace seaway::sea
