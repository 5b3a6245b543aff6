// SPDX-License-Identifier: Apache-2.0
// `seaway-bench effects`: what every effect and every cascade of a scene costs on a device, alone
// and on top of the rest.
#pragma once

#include <string>

#include "base/result.h"

namespace seaway::bench {

struct EffectsOptions {
    std::string scene = "scenes/north_sea_gale.toml";
    std::string device = "auto"; ///< auto | native | index or part of a name
    std::string out = "out/bench";
    int rounds = 40;
};

/// Prints a table; writes effects.csv and effects.png into `out`.
Result<void> run_effects(const EffectsOptions& options);

} // namespace seaway::bench
