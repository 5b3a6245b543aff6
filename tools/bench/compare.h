// SPDX-License-Identifier: Apache-2.0
// seaway-bench compare: two devices on one scene, in one line: do they make the same sea, and what does
// a keyframe cost on each.
#pragma once

#include <string>

#include "base/result.h"
#include "tools/bench/usual_scene.h"

namespace seaway::bench {

struct CompareOptions {
    std::string scene = usual_scene();
    std::string first = "llvmpipe"; ///< a device as --device takes it
    std::string second = "native";
    int rounds = 20; ///< keyframes of every cascade that are timed on each, in turns
};

/// Prints the largest difference of any map, as a share of four times the map's rms (heights: of Hs),
/// and the median milliseconds of a keyframe of all cascades with all fields.
Result<void> run_compare(const CompareOptions& options);

} // namespace seaway::bench
