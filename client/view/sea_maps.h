// SPDX-License-Identifier: Apache-2.0
// The maps that the shaders sample: the sea of one moment at the nodes of finer grids than the
// tiles', taken from the same splines that answer queries (sea/surface), with mip levels.
//
// Squares of slope are averaged beside slopes: the difference is the variance that a filtered
// lookup has lost, which the shading turns into roughness (LEAN maps, Olano and Baker 2010).
#pragma once

#include <vector>

#include "client/view/sea_frame.h"

namespace seaway::client {

/// What is known of the sea as a whole from its maps.
struct SeaStatistics {
    double significant_height_m = 0;  ///< 4 standard deviations of height
    double crest_m = 0;               ///< no height is above this: sum over cascades
    double reach_m = 0;               ///< no point is moved sideways further than this
    double slope_variance = 0;        ///< of all cascades, both axes
    double finest_slope_variance = 0; ///< of the last one
};

struct SeaMaps {
    int nodes = 0; ///< a side, a power of two
    int cascades = 0;
    // Each [mip][cascade][y][x][4]; channels as shaders/view/bindings.glsl.
    std::vector<float> displacement; ///< mip 0: coefficients of cubic B-splines; foam as it is
    std::vector<float> gradient;
    std::vector<float> moment;
    SeaStatistics statistics;
};

/// Nodes a side for these cascades: twice the finest grid, so that lookups that are linear between
/// nodes see at least 6 of them a wave; 64 .. 1024.
int map_nodes(const SeaFrame& frame);

/// About 0.1 us a node and cascade, shared by the machine's cores.
SeaMaps build_maps(const SeaFrame& frame);

} // namespace seaway::client
