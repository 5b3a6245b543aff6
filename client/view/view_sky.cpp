// SPDX-License-Identifier: Apache-2.0
#include "client/view/view_sky.h"

#include <algorithm>
#include <cmath>

#include "client/view/look_file.h"

namespace seaway::client {

namespace {

Eye eye_of(const Look& look, const Camera& camera, sea::TimeUs time_us) {
    return {.height_m = std::max(camera.z_m, 0.0), // under water it is the sky of the surface
            .east_m = camera.x_m,
            .north_m = camera.y_m,
            .cloud_drift_m = look.clouds.drift_mps * sea::seconds_from_us(time_us)};
}

} // namespace

Heavens heavens_of(const Look& look, sea::TimeUs time_us) {
    constexpr double step_s = 30, day_s = 86400;
    if (!look.place)
        return heavens_at_hour(look.hour);
    const double time_s = std::round(sea::seconds_from_us(time_us) / step_s) * step_s;
    return heavens_at({look.place->when.days_j2000 + time_s / day_s}, look.place->latitude_deg,
                      look.place->longitude_deg);
}

Result<Sky> sky_of_frame(SkyMaker& maker, const Look& look, const Camera& camera,
                         sea::TimeUs time_us) {
    return maker.make(look, heavens_of(look, time_us), eye_of(look, camera, time_us));
}

Sky sky_of_frame(SkyFeed& feed, const Look& look, const Camera& camera, sea::TimeUs time_us) {
    return feed.at(look, heavens_of(look, time_us), eye_of(look, camera, time_us));
}

Display display_by_light(const Look& look, const Sky& sky, DebugView view,
                         double significant_height_m) {
    return {view, exposure_of(look, exposure_by_light(sky.white_radiance())), significant_height_m,
            look.bloom};
}

} // namespace seaway::client
