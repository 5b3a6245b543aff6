// SPDX-License-Identifier: Apache-2.0
// Quality rungs: the few codec bounds that tiles are encoded at, so that every keyframe is encoded
// once a rung and shared by all its subscribers. Pure functions; thread-safe.
#pragma once

#include <array>
#include <cstdint>

#include "sea/surface/budget/error_budget.h"

namespace seaway::server {

/// Codec error of each rung, in shares of the scene's codec budget. Rung 0 keeps the scene's
/// `height_error_m`; each further one saves about two bits a sample.
inline constexpr std::array<double, 3> quality_rungs{1.0, 4.0, 16.0};

/// What tiles of this rung may cost of a height, m (ErrorBudget::codec_error_m).
inline double codec_error_m(const sea::ErrorBudget& budget, std::uint8_t quality) {
    return quality_rungs[quality] * budget.codec_error_m;
}

/// Bound on a height from tiles of this rung, all parts together, on level water, m.
inline double height_error_m(const sea::ErrorBudget& budget, std::uint8_t quality) {
    return level_error_m(budget, codec_error_m(budget, quality));
}

/// The cheapest rung that keeps the wanted bound; the best one if none does or 0 was asked.
inline std::uint8_t quality_for(const sea::ErrorBudget& budget, double wanted_error_m) {
    constexpr auto rungs = static_cast<std::uint8_t>(quality_rungs.size());
    std::uint8_t quality = 0;
    for (std::uint8_t rung = 1; rung < rungs; ++rung)
        if (height_error_m(budget, rung) <= wanted_error_m)
            quality = rung;
    return quality;
}

} // namespace seaway::server
