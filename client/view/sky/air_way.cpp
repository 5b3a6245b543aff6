// SPDX-License-Identifier: Apache-2.0
#include "client/view/sky/air_way.h"

#include <algorithm>
#include <cmath>

namespace seaway::client {

namespace {

/// Calls visit(distance, step) along a ray: short steps where it is lowest.
template <class Visit>
void walk(double lowest_m, double distance_m, int steps, const Visit& visit) {
    // Towards the lowest point steps get shorter, from there on longer.
    if (lowest_m > 0)
        for (int i = steps; i > 0; --i) {
            const double far = static_cast<double>(i) / steps, near = (i - 1.0) / steps;
            visit(lowest_m * (1 - (far * far + near * near) / 2),
                  lowest_m * (far * far - near * near));
        }
    const double rest_m = distance_m - lowest_m;
    if (rest_m > 0)
        for (int i = 0; i < steps; ++i) {
            const double near = static_cast<double>(i) / steps, far = (i + 1.0) / steps;
            visit(lowest_m + rest_m * (far * far + near * near) / 2,
                  rest_m * (far * far - near * near));
        }
}

/// Integral of light over a step of constant medium, seen through it (Hillaire 2015).
glm::dvec3 over_step(const glm::dvec3& extinction_per_m, double step_m, glm::dvec3& through) {
    through = glm::exp(-extinction_per_m * step_m);
    glm::dvec3 length;
    for (int c = 0; c < 3; ++c)
        length[c] =
            extinction_per_m[c] * step_m > 1e-9 ? (1 - through[c]) / extinction_per_m[c] : step_m;
    return length;
}

} // namespace

AirWay way_through(const Air& air, const TransmittanceTable& transmittance, const Ray& ray,
                   double distance_m, int steps) {
    AirWay way{ray, distance_m, {}, glm::dvec3(1)};
    way.steps.reserve(2 * static_cast<std::size_t>(steps));
    const double lowest_m = std::clamp(-ray.radius_m * ray.cosine, 0.0, distance_m);
    walk(lowest_m, distance_m, steps, [&](double at_m, double step_m) {
        const double height_m = height_after_m(air, ray, at_m);
        const Medium medium = air.at(height_m);
        glm::dvec3 through;
        const glm::dvec3 seen_m = way.passed * over_step(medium.extinction_per_m, step_m, through);
        const glm::dvec3 scattering_per_m = medium.rayleigh_per_m + medium.aerosol_per_m;
        way.steps.push_back(
            {.at_m = at_m,
             .height_m = height_m,
             .radius_m = radius_after_m(ray, at_m),
             .rayleigh = seen_m * medium.rayleigh_per_m,
             .aerosol = seen_m * medium.aerosol_per_m,
             .absorbed = seen_m * glm::max(medium.extinction_per_m - scattering_per_m, 0.0),
             .light = transmittance.at(height_m)});
        way.passed *= through;
    });
    return way;
}

} // namespace seaway::client
