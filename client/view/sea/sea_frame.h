// SPDX-License-Identifier: Apache-2.0
// SeaFrame: all that the renderer wants to know of the sea at one moment. A value.
#pragma once

#include <vector>

#include "sea/basics/cascade.h"
#include "sea/basics/dispersion.h"
#include "sea/basics/water_type.h"
#include "sea/surface/maps/keyframe.h"
#include "sea/surface/surface.h"
#include "sea/waves/realization.h"

namespace seaway::client {

struct CascadeFrame {
    sea::CascadeSpec spec;
    sea::Band band;
    sea::SplinePair keyframes; ///< around the time
    /// Keyframes of these times with Field::foam; null where the scene has no foam.
    sea::KeyframePtr foam_before{};
    sea::KeyframePtr foam_after{};
};

struct SeaFrame {
    sea::TimeUs time_us = 0;
    std::vector<CascadeFrame> cascades; ///< longest tile first; 1 .. shaders::view_cascades_max
    sea::Choppiness choppiness;
    // Of the sea state, so that nothing that is built from them changes from frame to frame.
    double significant_height_m = 1;
    double mean_from_deg = 0;     ///< bearing that waves come from
    double reach_m = 1;           ///< no point is moved sideways further, choppiness included
    double foam_threshold = 0.45; ///< Jacobian below which a crest breaks
    double foam_mean = 0;         ///< mean coverage by what has broken (docs/foam.md); 0: no foam
    double depth_m = sea::deep_water_m; ///< still
    sea::Water water;
    /// What these keyframes cost in accuracy, as answers state it.
    sea::MapError error{};
};

} // namespace seaway::client
