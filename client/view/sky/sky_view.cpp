// SPDX-License-Identifier: Apache-2.0
#include "client/view/sky/sky_view.h"

#include <algorithm>
#include <cmath>

#include "client/view/sky/air_between.h"

namespace seaway::client {

SkyView::SkyView(const AirTables& tables, double height_m, const glm::dvec3& to_sun,
                 ThreadPool& pool)
    : height_m_(std::max(height_m, height_min_m)),
      dome_(columns, rows, std::atan2(to_sun.y, to_sun.x), dip_rad(tables.air, height_m_)) {
    for_rows(pool, rows, [&](int row) {
        const bool sky = row >= rows / 2;
        // The rows at the horizon are to lie on their own side of it, whatever is rounded.
        const double z = dome_.direction(0, row).z + (sky ? 1e-9 : -1e-9);
        const Ray ray = ray_from(tables.air, height_m_, z);
        const double distance_m = length_m(tables.air, ray);
        const AirWay way =
            way_through(tables.air, tables.transmittance, ray, distance_m, view_steps);
        glm::dvec3 scale(1);
        if (!sky)
            scale /=
                glm::max(1.0 - air_left(tables.air, height_m_, distance_m, z), glm::dvec3(1e-12));
        for (int x = 0; x < columns / 2; ++x) {
            const double to_sun_cosine = glm::dot(dome_.direction(x, row), to_sun);
            const glm::dvec3 value =
                scale * sunlight_klx(air_radiance(tables, way, to_sun_cosine, to_sun.z));
            dome_.at(x, row) = dome_.at(columns - 1 - x, row) = glm::vec3(value);
        }
    });
}

double height_on_ladder_m(double height_m) {
    const double lowest = SkyView::height_min_m;
    const double rung = std::log(1.04);
    return lowest *
           std::exp(rung * std::round(std::log(std::max(height_m, lowest) / lowest) / rung));
}

} // namespace seaway::client
