// SPDX-License-Identifier: Apache-2.0
// `seaway-bench device`: what a device takes for the maps of all tiles of a scene, by size and list of fields, with foam and
// without; what it takes to copy them out, to encode them and to start; and beside each row what as many bytes take at
// best, measured in the same round by a copy kernel (on the native device: by stores of all threads). docs/performance/maps.md
// shows it.
#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "tools/bench/usual_scene.h"

namespace seaway::bench {

struct DeviceOptions {
    std::string scene = usual_scene();
    std::string device = "auto"; ///< auto | native | index or part of a name
    std::vector<int> sizes{128, 256, 512};
    int rounds = 15;
    std::string out = "out/bench";
    bool retune = false; ///< measure the designs of kernels anew, and remember the fastest
};

/// Prints a table; writes device.csv into `out`. A row has
///     what       maps; copied: the same, copied out of device memory as on a discrete GPU; rounded: likewise, as 16 bits;
///                foam: a tick of all tiles; readback: as many bytes as all maps have, out of device memory; fftw: as many
///                transforms as a row of maps, by that library where it is there; bandwidth; arithmetic; encode; start
///     size       points a side
///     fields     height | eight | all | all and foam | strains | foam; of a readback: floats | 16 bits; of a start: cold |
///                warm
///     device_ms  by the device's clock where it has one, else of the submission; medians
///     wall_ms    until keyframes are there
///     megabytes  of the maps
///     best_ms    that as many bytes take, moved and nothing else; bandwidth is that of 64 MB
///     best_pct   best_ms of device_ms: for maps that fit into a cache what the cache gives
///     memory_pct what as many bytes take at the bandwidth of memory, of device_ms
///     gflop_per_s of the transforms, counted as 2.5 N log2 N each, of N points; of `arithmetic` what a kernel of nothing but
///                products and sums comes to
///     arithmetic_pct that, of the latter
/// Cold is without a driver's cache of kernels on disk, where the driver is one of Mesa or NVIDIA; warm is with what an
/// earlier start has left there. Which design of kernels is the fastest is known to both.
Result<void> run_device(const DeviceOptions& options);

} // namespace seaway::bench
