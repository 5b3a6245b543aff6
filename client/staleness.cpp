// SPDX-License-Identifier: Apache-2.0
#include "client/staleness.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sea/basics/glide.h"
#include "sea/surface/budget/error_budget.h"

namespace seaway::client {

double stale_error_m(const SeaState& state, sea::TimeUs heard_us, sea::TimeUs time_us) {
    sea::TimeUs interval_us = 0;
    for (const protocol::CascadeInfo& cascade : state.cascades)
        interval_us = std::max(interval_us, cascade.interval_us);
    const sea::TimeUs first_us = heard_us + interval_us + change_told_ahead_us;
    const double share = sea::glide_share(time_us, first_us, first_us + sea::glide_us_min);
    const double difference_m = std::numbers::sqrt2 * state.realised.hs_m / 4 * share;
    const double moved = std::max(state.choppiness_x, state.choppiness_y) * state.rms_slope;
    return sea::bound_sigmas * difference_m * (1 + moved);
}

} // namespace seaway::client
