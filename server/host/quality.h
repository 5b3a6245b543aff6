// SPDX-License-Identifier: Apache-2.0
// Quality rungs: the few codec bounds that tiles are encoded at, each on the maps' own grids and on the smallest
// that carry their waves ("compact", docs/protocol.md) or predicted there, and the same cut to smaller grids or of fewer keyframes, so that
// every keyframe is encoded once a rung and shared by all its subscribers. Pure functions; thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sea/surface/budget/coarser.h"
#include "sea/surface/budget/error_budget.h"

namespace seaway::server {

/// The number of a rung.
using Quality = std::uint16_t;

/// Codec error of each rung, in shares of the scene's codec budget. Rung 0 keeps the scene's
/// `height_error_m`; each further one saves about a bit a sample.
inline constexpr std::array<double, 5> codec_rungs{1.0, 2.0, 4.0, 8.0, 16.0};
/// Largest sides of maps, and highest rates of keyframes: the first is all there is.
inline constexpr std::array size_rungs{0, 256, 128, 64, 32};
inline constexpr std::array rate_rungs_hz{0.0, 8.0, 4.0, 2.0, 1.0};

/// Compact rungs follow those of whole grids, and those that are predicted follow these; those of smaller maps or fewer
/// keyframes come after all of them.
inline constexpr auto whole_rungs = static_cast<Quality>(3 * codec_rungs.size());
inline constexpr auto quality_rungs =
    static_cast<Quality>(whole_rungs * size_rungs.size() * rate_rungs_hz.size());

/// Of those, that somebody has at a time: each is encoded for itself, so that crowds of odd wishes cost no more than so
/// many.
inline constexpr std::size_t coarser_rungs_max = 8;
/// Of those, that sessions of one address have when another one of it may begin one.
inline constexpr std::size_t coarser_rungs_of_address_max = 4;

/// One of each.
struct Rung {
    std::size_t codec = 0;
    bool compact = false;
    bool predicted =
        false; ///< and compact: keyframes as differences to what follows from earlier ones
    std::size_t size = 0; ///< of size_rungs
    std::size_t rate = 0; ///< of rate_rungs_hz
};

inline constexpr Quality number_of(const Rung& rung) {
    const std::size_t form = rung.predicted ? 2 : rung.compact ? 1 : 0;
    return static_cast<Quality>(rung.codec + codec_rungs.size() * form +
                                whole_rungs * (rung.size + size_rungs.size() * rung.rate));
}
inline constexpr Rung rung_of(Quality quality) {
    const std::size_t form = quality / codec_rungs.size() % 3;
    const std::size_t coarser = quality / whole_rungs;
    return {quality % codec_rungs.size(), form >= 1, form == 2, coarser % size_rungs.size(),
            coarser / size_rungs.size()};
}

/// Smaller maps or fewer keyframes than all there is.
inline constexpr bool is_coarser(Quality quality) {
    return quality >= whole_rungs;
}

/// Grid points a side that linear maps of a rung are sent with.
inline int sent_size(const sea::CascadeBudget& cascade, const Rung& rung) {
    const int own = rung.compact ? cascade.compact_size : cascade.size;
    const int smaller = sea::cut_size(cascade, own, size_rungs[rung.size]);
    return smaller == 0 ? own : smaller;
}

/// What maps of a rung are beside what the budget has of this cascade.
inline sea::CoarserMaps coarser_maps(const sea::CascadeBudget& cascade, const Rung& rung) {
    // A smaller grid that still carries all waves cuts none.
    const int size = sent_size(cascade, rung);
    return {.size = size < cascade.compact_size ? size : 0,
            .every = sea::every_for(cascade, rate_rungs_hz[rung.rate])};
}

/// What tiles of this rung may cost of a height, m (ErrorBudget::codec_error_m).
inline double codec_error_m(const sea::ErrorBudget& budget, Quality quality) {
    return codec_rungs[quality % codec_rungs.size()] * budget.codec_error_m;
}

/// Are any of its maps sent on another grid than their own?
inline bool is_regridded(const sea::ErrorBudget& budget, const Rung& rung) {
    for (const sea::CascadeBudget& cascade : budget.cascades)
        if (sent_size(cascade, rung) < cascade.size)
            return true;
    return rung.compact;
}

/// Bound on a height from tiles of this rung, all parts together, on level water, m. Of those of `cascades`, a bit each, maps
/// may be coarser; the others, which nobody wants of it, are as fine as the sea has them, coded alike.
inline double height_error_m(const sea::ErrorBudget& budget, Quality quality,
                             std::uint32_t cascades = sea::all_cascades) {
    const Rung rung = rung_of(quality);
    std::vector<sea::CoarserMaps> maps;
    for (std::size_t c = 0; c < budget.cascades.size(); ++c)
        maps.push_back((cascades >> c & 1u) != 0 ? coarser_maps(budget.cascades[c], rung)
                                                 : sea::CoarserMaps{});
    return level_error_m(budget, codec_error_m(budget, quality), maps) +
           (is_regridded(budget, rung) ? compact_error_m(budget) : 0.0);
}

} // namespace seaway::server
