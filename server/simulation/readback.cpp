// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/readback.h"

#include <algorithm>

namespace seaway::server {

std::vector<float> rounding_bounds(const sea::ErrorBudget& budget, sea::FieldSet fields,
                                   int cascade, Readback readback) {
    if (readback == Readback::exact)
        return {};
    const sea::CascadeBudget& own = budget.cascades[static_cast<std::size_t>(cascade)];
    // Rates are sent the finer the fewer keyframes there are.
    std::vector<float> bounds = sea::codec_bounds(budget, fields, cascade, budget.codec_error_m,
                                                  own.size, std::max(own.every_max, 1));
    for (float& bound : bounds)
        bound *= static_cast<float>(rounding_share);
    if (!std::ranges::all_of(bounds, [](float bound) { return bound > 0; }))
        return {};
    return bounds;
}

} // namespace seaway::server
