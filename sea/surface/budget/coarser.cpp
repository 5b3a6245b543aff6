// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/budget/coarser.h"
#include "sea/surface/budget/interpolation_laws.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"

namespace seaway::sea {

namespace {

/// So that a rate that is met exactly is met.
constexpr double rate_slack = 1e-9;

const CascadeBudget::Cut& cut_of(const CascadeBudget& cascade, int size) {
    const auto at = std::ranges::find(smaller_grids, size);
    SEAWAY_CHECK(at != smaller_grids.end() && cascade.can_be_cut, "maps are cut to smaller grids");
    return cascade.cuts[static_cast<std::size_t>(at - smaller_grids.begin())];
}

} // namespace

int cut_size(const CascadeBudget& cascade, int own_size, int size_max) {
    if (size_max == 0 || own_size <= size_max || !cascade.can_be_cut)
        return 0;
    for (const int size : smaller_grids) // largest first
        if (size <= size_max)
            return size < own_size ? size : 0;
    return 0;
}

int every_for(const CascadeBudget& cascade, double rate_hz) {
    if (!(rate_hz > 0))
        return 1;
    const double intervals = 1.0 / (rate_hz * seconds_from_us(cascade.interval_us));
    return static_cast<int>(
        std::clamp(std::ceil(intervals - rate_slack), 1.0, static_cast<double>(cascade.every_max)));
}

CoarserLoss coarser_loss(const ErrorBudget& budget, int cascade, const CoarserMaps& maps) {
    const CascadeBudget& own = budget.cascades[static_cast<std::size_t>(cascade)];
    SEAWAY_CHECK(maps.every >= 1 && maps.every <= own.every_max,
                 "keyframes so far apart say nothing of the waves");
    if (!maps.coarser())
        return {};
    const CascadeBudget::Slow& slow = own.slow[static_cast<std::size_t>(maps.every - 1)];
    CoarserLoss loss{.interval_us = maps.every * own.interval_us,
                     .time_m = slow.time_m,
                     .displacement_time_m = slow.displacement_time_m};
    const double slow_strain = maps.every > 1 ? slow.strain : 0.0;
    const CutWaves cut = maps.size == 0 ? CutWaves{} : cut_of(own, maps.size).waves;
    const double sideways =
        budget.choppiness.largest() * cut_slope_sigmas * std::min(1.0, cut.slope);
    loss.cut_m = std::hypot(cut.height_m, sideways * cut.displacement_m);
    loss.displacement_cut_m = cut.displacement_m;
    loss.strain = fold_sigmas * std::hypot(slow_strain, cut.strain);
    return loss;
}

double level_error_m(const ErrorBudget& budget, double codec_error_m,
                     std::span<const CoarserMaps> maps) {
    double more_m2 = 0;
    for (std::size_t c = 0; c < maps.size(); ++c) {
        if (!maps[c].coarser())
            continue;
        const CoarserLoss loss = coarser_loss(budget, static_cast<int>(c), maps[c]);
        more_m2 += square(loss.time_m) - square(budget.cascades[c].loss.height.time_m) +
                   square(loss.cut_m);
    }
    const double whole_m = level_error_m(budget, codec_error_m);
    if (!(more_m2 > 0))
        return whole_m;
    return std::hypot(whole_m - budget.single_precision_m, bound_sigmas * std::sqrt(more_m2)) +
           budget.single_precision_m;
}

} // namespace seaway::sea
