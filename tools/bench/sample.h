// SPDX-License-Identifier: Apache-2.0
// `seaway-bench sample`: what answers from maps that are held cost on one thread, by how many are asked for at once, whether
// they share a time, and what of them is wanted. docs/performance/points.md shows it.
#pragma once

#include <string>

#include "base/result.h"
#include "tools/bench/usual_scene.h"

namespace seaway::bench {

struct SampleOptions {
    std::string scene = usual_scene();
    double seconds = 1;          ///< that each row is measured for
    int points = 0;              ///< rows of so many at once alone; 0: all rows
    std::string kernel = "best"; ///< or portable
};

/// Prints a row a way of asking: median and 99 % of the CPU time that a batch takes, divided by its
/// points, and points a second. Single points are timed sixteen at a time. Places are scattered
/// over 20 km and new in each batch, as its time is. "Drifting" is a place that moves by centimetres while no time passes. A
/// hull's point makes way, at a new time each step; with a probe it is looked for where it was found before.
Result<void> run_sample(const SampleOptions& options);

} // namespace seaway::bench
