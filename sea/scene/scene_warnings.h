// SPDX-License-Identifier: Apache-2.0
// What a user should know before trusting the picture: tiles too small for the peak, heights near
// breaking, energy that no cascade holds, growth that was clamped. Pure; thread-safe.
//
//     const Realization sea = *realize(scene);
//     const SeaSummary summary = summarize(scene.sea, sea);
//     const ErrorBudget budget = plan_budget(sea, scene.accuracy.height_error_m);
//     for (const std::string& warning : scene_warnings(scene, sea, summary, budget)) ...
#pragma once

#include <string>
#include <vector>

#include "sea/scene/scene.h"
#include "sea/surface/budget/error_budget.h"
#include "sea/waves/statistics/moments.h"

namespace seaway::sea {

/// One sentence each. The sea, its summary and its budget are those of the scene: they are what takes
/// long, and whoever warns has them for other uses.
std::vector<std::string> scene_warnings(const Scene& scene, const Realization& realization,
                                        const SeaSummary& summary, const ErrorBudget& budget);

} // namespace seaway::sea
