// SPDX-License-Identifier: Apache-2.0
// `seaway-bench line`: where the bytes of one client go. Real keyframes of a scene, encoded as the server encodes
// them for one session, counted by cascade and field. docs/performance/line.md shows it.
#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "client/tile_limits.h"
#include "tools/bench/usual_scene.h"

namespace seaway::bench {

struct LineOptions {
    std::string scene = usual_scene();
    std::string device = "native"; ///< as --device takes it
    double error_m = 0.01;         ///< what the client asks for
    std::vector<std::string>
        ask;            ///< effects, as height,choppy; empty: what a sampling client takes
    int keyframes = 4;  ///< of each cascade
    bool whole = false; ///< for a client from before compact maps were
    bool alone = false; ///< for one that takes no differences to what came before
    client::TileLimits limits;
};

/// Where maps are predicted, of a stream that goes on: TileStream::leads keyframes before those that are counted are not, and what
/// it begins with, whole, is told apart. Prints a table: the grid a map is sent on, its keyframes a second, the codec's bound, bits a sample
/// and kbit/s, messages and their headers included; the CPU time of encoding them, and of what a compact client does.
Result<void> run_line(const LineOptions& options);

} // namespace seaway::bench
