// SPDX-License-Identifier: Apache-2.0
// SeaFrame: all that the renderer wants to know of the sea at one moment. A value.
#pragma once

#include <vector>

#include "sea/cascade.h"
#include "sea/realization.h"
#include "sea/surface/surface.h"

namespace seaway::client {

struct CascadeFrame {
    sea::CascadeSpec spec;
    sea::Band band;
    sea::SplinePair keyframes; ///< around the time
};

struct SeaFrame {
    sea::TimeUs time_us = 0;
    std::vector<CascadeFrame> cascades; ///< longest tile first; 1 .. shaders::view_cascades_max
    sea::Choppiness choppiness;
    double foam_threshold = 0.45; ///< Jacobian below which a crest is white
};

} // namespace seaway::client
