// SPDX-License-Identifier: Apache-2.0
#include "client/staleness.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "client/local_surface.h"
#include "sea/basics/glide.h"
#include "sea/surface/budget/error_budget.h"

namespace seaway::client {

namespace {

/// Of another sea, in the difference of its waves from those that are known.
double difference_share(const SeaState& state, sea::TimeUs heard_us, sea::TimeUs time_us) {
    const sea::TimeUs first_us = told_until_us(state, heard_us);
    return std::numbers::sqrt2 * sea::glide_share(time_us, first_us, first_us + sea::glide_us_min);
}

} // namespace

sea::TimeUs told_until_us(const SeaState& state, sea::TimeUs heard_us) {
    sea::TimeUs interval_us = 0;
    for (const protocol::CascadeInfo& cascade : state.cascades)
        interval_us = std::max(interval_us, cascade.interval_us);
    return heard_us + interval_us + change_told_ahead_us;
}

double stale_error_m(const SeaState& state, sea::TimeUs heard_us, sea::TimeUs time_us) {
    const double difference_m =
        difference_share(state, heard_us, time_us) * state.highest_hs_m(heard_us) / 4;
    const double moved = largest_choppiness(state).largest() * state.rms_slope;
    return sea::bound_sigmas * difference_m * (1 + moved);
}

double stale_displacement_error_m(const SeaState& state, sea::TimeUs heard_us,
                                  sea::TimeUs time_us) {
    return difference_share(state, heard_us, time_us) * state.displacement_reach_m;
}

} // namespace seaway::client
