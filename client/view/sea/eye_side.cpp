// SPDX-License-Identifier: Apache-2.0
#include "client/view/sea/eye_side.h"

#include <algorithm>

namespace seaway::client {

namespace {

/// Crests lie within so many significant heights.
constexpr double crest_heights_max = 2;

double water_height_m(const SeaFrame& frame, const Camera& camera) {
    if (frame.water_m)
        return frame.water_m(camera.x_m, camera.y_m);
    std::vector<sea::SplinePair> pairs;
    for (const CascadeFrame& cascade : frame.cascades)
        pairs.push_back(cascade.keyframes);
    const sea::Surface surface(std::move(pairs), frame.choppiness, {.reach_m = frame.reach_m}, {});
    return surface.answer({camera.x_m, camera.y_m, frame.time_us}).height_m;
}

} // namespace

EyeSide eye_side(const SeaFrame& frame, const Camera& camera) {
    EyeSide eye{.z_m = camera.z_m};
    if (camera.z_m > crest_heights_max * frame.significant_height_m + eye_clearance_m)
        return eye;
    const double height_m = water_height_m(frame, camera);
    eye.under = camera.z_m < height_m;
    eye.z_m = eye.under ? std::min(camera.z_m, height_m - eye_clearance_m)
                        : std::max(camera.z_m, height_m + eye_clearance_m);
    eye.depth_m = eye.under ? height_m - eye.z_m : 0;
    return eye;
}

} // namespace seaway::client
