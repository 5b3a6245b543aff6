// SPDX-License-Identifier: Apache-2.0
// What all answers of a Surface at one time have in common. For surface.cpp and what it is made of.
#pragma once

#include <array>
#include <cmath>

#include "sea/surface/surface_sheets.h"

namespace seaway::sea {

struct Surface::AtTime {
    TimeUs time_us;
    SurfaceSheets sheets;
    std::array<PointWeights, surface_pairs_max> weights;
    struct Loss {
        MapLoss::AtTime height;
        MapLoss::AtTime displacement;
        double cells_a_metre;
    };
    std::array<Loss, surface_pairs_max> losses;
    std::uint32_t flags;

    AtTime(const Surface& surface, TimeUs time);
};

/// Bound on a height at a place that is `between(cascade)` its samples, where a point that moves sideways by a metre rises by
/// `sideways`.
template <class Real, class BetweenOf>
[[gnu::always_inline]] inline Real
Surface::height_bound_m(const BetweenOf& between, const AtTime& then, const Real& sideways) const {
    Real variance_m2 = Real{};
    for (std::size_t c = 0; c < error_.cascades.size(); ++c) {
        const AtTime::Loss& loss = then.losses[c];
        const Between<Real> here = between(c);
        variance_m2 += loss.height.variance_m2(here.east, here.north) +
                       sideways * sideways * loss.displacement.variance_m2(here.east, here.north);
    }
    return bound_sigmas * root(variance_m2) + error_.height_bound_m +
           sideways * error_.displacement_bound_m;
}

/// The same in parts, but for what the inverse leaves.
template <class BetweenOf>
ErrorTerms Surface::terms_of(const BetweenOf& between, const AtTime& then, double sideways) const {
    double time_m2 = 0, space_m2 = 0, coded_m2 = 0;
    for (std::size_t c = 0; c < error_.cascades.size(); ++c) {
        const MapLoss::AtTime &height = then.losses[c].height, &moved = then.losses[c].displacement;
        const Between<double> here = between(c);
        const double moved2 = sideways * sideways;
        time_m2 += height.time_m2 + moved2 * moved.time_m2;
        space_m2 += height.space_variance_m2(here.east, here.north) +
                    moved2 * moved.space_variance_m2(here.east, here.north);
        coded_m2 += height.coded_variance_m2(here.east, here.north) +
                    moved2 * moved.coded_variance_m2(here.east, here.north);
    }
    return {.codec_m = bound_sigmas * std::sqrt(coded_m2),
            .time_m = bound_sigmas * std::sqrt(time_m2),
            .space_m = bound_sigmas * std::sqrt(space_m2),
            .rounding_m = error_.height_bound_m + sideways * error_.displacement_bound_m};
}

} // namespace seaway::sea
