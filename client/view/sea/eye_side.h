// SPDX-License-Identifier: Apache-2.0
// On which side of the sea's surface an eye is, by the height of the water above or below it: in a trough an eye may be in
// the air below the mean sea, in a crest under water above it. Pure; thread-safe; some microseconds near the surface.
#pragma once

#include "client/view/camera.h"
#include "client/view/sea/sea_frame.h"

namespace seaway::client {

/// No eye is drawn from nearer to the surface: triangles nearer than 0.1 m are cut off.
inline constexpr double eye_clearance_m = 0.15;

struct EyeSide {
    bool under = false;
    double depth_m = 0; ///< of the eye below the water's surface; above it 0
    double z_m =
        0; ///< where it is drawn from: the camera's height, or as near to the surface as may be
};

EyeSide eye_side(const SeaFrame& frame, const Camera& camera);

} // namespace seaway::client
