// SPDX-License-Identifier: Apache-2.0
// Coarser maps than a budget asks for, for those who take less: without the finest waves, on a smaller grid, or only
// every n-th keyframe. What that costs follows from the waves of the sea: those that are cut are missed everywhere and
// at any time, with their own variance; longer intervals miss by the law of Hermite (interpolation_laws.h). Cut waves also move
// points on slopes that they have themselves, which counts with cut_slope_sigmas of those slopes.
//
// Pure functions; thread-safe. Some ten nanoseconds a cascade.
#pragma once

#include <span>
#include <vector>

#include "sea/surface/budget/error_budget.h"

namespace seaway::sea {

/// A slope of cut waves that is steeper than so many standard deviations is not counted on where they move a point.
inline constexpr double cut_slope_sigmas = 2.0;

/// Maps of one cascade: a grid of `size` points a side (0: the budget's own, compact or not), every `every`-th keyframe.
struct CoarserMaps {
    int size = 0;  ///< else one of smaller_grids, for which CascadeBudget::can_be_cut
    int every = 1; ///< at most CascadeBudget::every_max

    bool coarser() const { return size != 0 || every > 1; }
};

/// The largest grid of at most `size_max` points that this cascade's maps can be cut to; 0: they stay as they are, because
/// all waves of a grid of `own_size` points fit, or because they cannot be cut.
int cut_size(const CascadeBudget& cascade, int own_size, int size_max);

/// How many intervals apart keyframes are at most when no more than `rate_hz` come: every_max at most.
int every_for(const CascadeBudget& cascade, double rate_hz);

/// What such maps miss.
CoarserLoss coarser_loss(const ErrorBudget& budget, int cascade, const CoarserMaps& maps);

/// level_error_m() of such maps, one a cascade.
double level_error_m(const ErrorBudget& budget, double codec_error_m,
                     std::span<const CoarserMaps> maps);

} // namespace seaway::sea
