// SPDX-License-Identifier: Apache-2.0
// Quality rungs: the few codec bounds that tiles are encoded at, each on the maps' own grids and on the smallest
// that carry their waves ("compact", docs/protocol.md), so that every keyframe is encoded
// once a rung and shared by all its subscribers. Pure functions; thread-safe.
#pragma once

#include <array>
#include <cstdint>

#include "sea/surface/budget/error_budget.h"

namespace seaway::server {

/// Codec error of each rung, in shares of the scene's codec budget. Rung 0 keeps the scene's
/// `height_error_m`; each further one saves about a bit a sample.
inline constexpr std::array<double, 5> codec_rungs{1.0, 2.0, 4.0, 8.0, 16.0};
/// Compact rungs follow those of whole grids.
inline constexpr auto quality_rungs = static_cast<std::uint8_t>(2 * codec_rungs.size());

inline constexpr bool is_compact(std::uint8_t quality) {
    return quality >= codec_rungs.size();
}

/// What tiles of this rung may cost of a height, m (ErrorBudget::codec_error_m).
inline double codec_error_m(const sea::ErrorBudget& budget, std::uint8_t quality) {
    return codec_rungs[quality % codec_rungs.size()] * budget.codec_error_m;
}

/// Bound on a height from tiles of this rung, all parts together, on level water, m.
inline double height_error_m(const sea::ErrorBudget& budget, std::uint8_t quality) {
    return level_error_m(budget, codec_error_m(budget, quality)) +
           (is_compact(quality) ? compact_error_m(budget) : 0.0);
}

/// The cheapest rung that keeps the wanted bound; the best one if none does or 0 was asked.
inline std::uint8_t quality_for(const sea::ErrorBudget& budget, double wanted_error_m,
                                bool compact) {
    const auto first = static_cast<std::uint8_t>(compact ? codec_rungs.size() : 0);
    const auto end = static_cast<std::uint8_t>(first + codec_rungs.size());
    std::uint8_t quality = first;
    for (std::uint8_t rung = first; rung < end; ++rung)
        if (height_error_m(budget, rung) <= wanted_error_m)
            quality = rung;
    return quality;
}

} // namespace seaway::server
