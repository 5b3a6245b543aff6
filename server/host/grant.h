// SPDX-License-Identifier: Apache-2.0
// Grant: what of a wish for tiles can be had, at the cheapest rung that keeps it, and in what that is less. Pure
// function; thread-safe. Some microseconds.
#pragma once

#include <bitset>
#include <span>
#include <vector>

#include "sea/surface/budget/error_budget.h"
#include "server/host/quality.h"
#include "server/host/subscriptions.h"

namespace seaway::server {

/// `budgets`: of the seas that the grant is for, the one that runs first; its bounds hold in all of them. `offered`: the
/// fields that there are. `in_use`: rungs that others have, of which limits::coarser_rungs_max at most may be coarser.
/// Empty, with the reason in `why`, where nothing of the wish can be had; `busy`: as long as others have so many rungs.
Demand grant_of(const Demand& wish, std::span<const sea::ErrorBudget* const> budgets,
                sea::FieldSet offered, const std::bitset<quality_rungs>& in_use);

/// How maps of one cascade are sent at a rung.
struct RungMaps {
    std::vector<float> codec_error; ///< one a field, in table order
    int compact_size = 0;           ///< grid points a side of linear maps; 0: their own
    sea::CoarserLoss coarser;
    int every = 1;          ///< of so many keyframes one
    bool predicted = false; ///< where the sea has a law of waves
};
RungMaps maps_of(const sea::ErrorBudget& budget, int cascade, sea::FieldSet fields,
                 Quality quality);

/// What tiles of this rung leave out because it follows from what they hold.
sea::FieldSet follows_of(const sea::ErrorBudget& budget, sea::FieldSet offered, Quality quality);

} // namespace seaway::server
