// SPDX-License-Identifier: Apache-2.0
// The waves of a configuration: all of those that it is held to, and those that it uses.
// Pure functions; thread-safe.
#pragma once

#include "base/result.h"
#include "sea/scene/scene.h"
#include "sea/surface/budget/error_budget.h"
#include "sea/waves/realization.h"
#include "tools/bench/accuracy/seas/configuration.h"

namespace seaway::bench {

struct Waves {
    sea::SeaState state;      ///< with the configuration's choppiness
    sea::RealizationPtr all;  ///< what the truth sums: no wave is left out
    sea::RealizationPtr used; ///< what the configuration computes, on its grids
    sea::ErrorBudget budget;  ///< with the configuration's intervals
};

/// Errors: cascades that realize() refuses.
Result<Waves> configured_waves(const sea::Scene& scene, const Configuration& configuration);

/// The budget of a sea as the configuration asks, with its intervals.
sea::ErrorBudget budget_of(const sea::Realization& sea, const Configuration& configuration);

/// The same modes on grids with `factor` times as many points a side.
sea::Realization oversampled(const sea::Realization& sea, int factor);

/// Only the pairs k, -k that carry most, `count` of them.
sea::Realization largest_modes(const sea::Realization& sea, int count);

/// Only |k| < k_max.
sea::Realization up_to(const sea::Realization& sea, double k_max_radpm);

/// A sea that at time 0 is what a program that computes phases by this rule takes the other one for
/// at time_us. It does not move.
sea::Realization as_seen_at(const sea::Realization& sea, sea::TimeUs time_us, PhaseRule rule);

/// Phase of a wave at a time as the rule computes it, rad; any multiple of 2 pi apart.
double phase_by_rule(sea::Rate rate, sea::TimeUs time_us, PhaseRule rule);

/// Calls f(mode index, |k|, variance in m2, omega in rad/s) for every mode of a cascade that carries
/// anything.
template <class F>
void for_each_wave(const sea::CascadeModes& cascade, const F& f) {
    const int size = cascade.spec.size;
    const double step = cascade.spec.wavenumber_step_radpm();
    for (std::size_t i = 0; i < cascade.h0.size(); ++i) {
        const double variance = 2.0 * std::norm(cascade.h0[i]);
        if (!(variance > 0))
            continue;
        const int ix = static_cast<int>(i) % size, iy = static_cast<int>(i) / size;
        const double kx = step * sea::signed_index(ix, size);
        const double ky = step * sea::signed_index(iy, size);
        f(i, kx, ky, variance, sea::omega_from_rate(cascade.rate[i]));
    }
}

/// Sum of the variances of all waves, m2.
double variance_of(const sea::Realization& sea);

} // namespace seaway::bench
