// SPDX-License-Identifier: Apache-2.0
// How much work a picture is worth: one table row a level. What each costs: docs/performance/drawing.md.
#pragma once

#include <array>
#include <string_view>

#include "base/result.h"

namespace seaway::client {

struct Quality {
    std::string_view name;
    std::string_view meaning;
    double cell_pixels;  ///< side of the mesh's far cells
    int samples;         ///< a pixel, of the geometry: 1 or 4
    int probes;          ///< of a pixel's strip along the line of sight, at most
    int nodes_a_point;   ///< of the gradients' maps: DeviceSeaOptions
    bool between_levels; ///< lookups are linear between levels of maps, else from the nearest
    double scale;        ///< pixels that are drawn over pixels that are shown, a side
    int bloom_pixels; ///< of the picture a texel of the finest bloom, a side: 4 or 2; 0: no bloom
    int spray_slots;  ///< plumes of spray a cell of its grid (client/view/sea/spray.h); 0: no spray

    bool operator==(const Quality&) const = default;
};

inline constexpr std::array<Quality, 4> quality_table{{
    {"low", "two cores without a GPU at 10 frames a second", 10, 1, 1, 1, false, 0.5, 0, 0},
    {"default", "two cores without a GPU at 4 frames a second", 6.4, 1, 2, 1, false, 0.8, 4, 2},
    {"high", "stills and GPUs", 2.5, 4, 5, 2, true, 1, 2, 8},
    {"film", "stills that are looked at closely", 1.5, 4, 9, 2, true, 1, 2, 16},
}};

// Places in the table.
inline constexpr std::size_t quality_low = 0, quality_default = 1, quality_high = 2;

/// The error lists the names.
Result<Quality> parse_quality(std::string_view name);

} // namespace seaway::client
