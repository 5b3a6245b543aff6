// SPDX-License-Identifier: Apache-2.0
#include "client/view/sky/air_between.h"

#include <algorithm>
#include <cmath>

namespace seaway::client {

glm::dvec3 air_left(const Air& air, double height_m, double distance_m, double direction_z) {
    // Gauss and Legendre's nodes and weights on 0 .. 1.
    constexpr double nodes[] = {0.0694318442, 0.3300094782, 0.6699905218, 0.9305681558};
    constexpr double weights[] = {0.1739274226, 0.3260725774, 0.3260725774, 0.1739274226};
    const double curvature = 0.5 / air.planet_radius_m;
    double rayleigh = 0, aerosol = 0;
    for (int i = 0; i < 4; ++i) {
        // From the lower end: distances grow with the square of the node.
        const double share = nodes[i] * nodes[i];
        const double t = distance_m * (direction_z < 0 ? 1 - share : share);
        const double h = std::max(
            height_m + t * (direction_z + curvature * t * (1 - direction_z * direction_z)), 0.0);
        rayleigh += 2 * nodes[i] * weights[i] * std::exp(-h / air.rayleigh_scale_m);
        aerosol += 2 * nodes[i] * weights[i] * std::exp(-h / air.aerosol_scale_m);
    }
    return glm::exp(-distance_m *
                    (rayleigh * air.rayleigh_rgb_per_m() + aerosol * air.aerosol_rgb_per_m()));
}

} // namespace seaway::client
