// SPDX-License-Identifier: Apache-2.0
// How far two keyframes of the same cascade and time are apart. Pure.
#pragma once

#include <string_view>

#include "sea/surface/maps/keyframe.h"

namespace seaway::bench {

struct MapDifference {
    double share =
        0; ///< of four times the rms, the larger of both; infinite where one is no number
    std::string_view field = "none";
};

/// The largest over all maps of `a`, which `b` has too.
MapDifference largest_difference(const sea::Keyframe& a, const sea::Keyframe& b);

} // namespace seaway::bench
