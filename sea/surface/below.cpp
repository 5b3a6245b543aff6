// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/below.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace seaway::sea {

std::optional<double> still_z_m(double z_m, double surface_m, double depth_m) {
    const double below_m = z_m - surface_m;
    if (!(below_m <= 0 && z_m >= -depth_m && surface_m > -depth_m))
        return std::nullopt;
    return std::isinf(depth_m) ? below_m : below_m * (depth_m / (depth_m + surface_m));
}

Answer water_at(const QueryPoint& point, double z_m, const InverseOptions& options,
                const DirectSum::Moment& moment, WaterBelow& water, double* area) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    Vec2 place{};
    Answer answer = surface_at({std::isfinite(z_m) ? point.x_m : nan, point.y_m, point.time_us},
                               options, moment, &place, area);
    water = {};
    if (answer.flags & answer_invalid) {
        water = {{nan, nan, nan}, nan};
        return answer;
    }
    const Realization& sea = moment.sea();
    const double depth_m = sea.cascades.empty() ? deep_water_m : sea.cascades.front().depth_m;
    // Who asks about the surface as it was answered, or the floor, is not told that it is dry.
    const double near_m = options.tolerance_m + answer.error_m;
    const bool reaches = z_m <= answer.height_m + near_m && z_m >= -depth_m - near_m;
    const std::optional<double> still =
        still_z_m(reaches ? std::max(std::min(z_m, answer.height_m), -depth_m) : z_m,
                  answer.height_m, depth_m);
    if (!still) {
        answer.flags |= answer_dry;
        return answer;
    }
    const WaterMotion motion = moment.motion(place.x, place.y, *still);
    for (int axis = 0; axis < 3; ++axis)
        water.velocity_mps[axis] = motion.velocity_mps[axis];
    water.pressure_m2ps2 = motion.pressure_m2ps2;
    return answer;
}

} // namespace seaway::sea
