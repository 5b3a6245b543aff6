// SPDX-License-Identifier: Apache-2.0
#include "client/view/sky/sky_parts.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "client/view/sky/air_between.h"

namespace seaway::client {

namespace {

using std::numbers::pi;

/// It is brighter where its layer is seen aslant. Between hydroxyl and sodium at 92 km and oxygen's lines and continuum
/// at 103 km (Mende 1993, Journal of Geophysical Research 98).
constexpr double airglow_height_m = 95e3;
constexpr double facet_slope = 0.2; // rms, of the sea that a reflection meets

/// Fresnel's reflectance of a rough sea: Schlick's with the mean of Bruneton, Neyret, Holzschuch 2010.
double sea_reflectance(double cosine) {
    return 0.02 + 0.98 * std::pow(1 - cosine, 5 * std::exp(-2.69 * facet_slope)) /
                      (1 + 22.7 * std::pow(facet_slope, 1.5));
}

glm::dvec3 glow(const AirTables& air, double height_m, const glm::dvec3& direction) {
    const double sine = (air.air.planet_radius_m + height_m) /
                        (air.air.planet_radius_m + airglow_height_m) *
                        std::sqrt(std::max(1 - direction.z * direction.z, 0.0));
    return airglow / std::sqrt(1 - sine * sine) *
           air.transmittance.to_space(height_m, std::max(direction.z, 0.0));
}

glm::dvec3 sample(const Lit& lit, const glm::dvec3& direction, const DomePlace& from_sun) {
    glm::dvec3 sum = lit.sun_strength * lit.sun->dome().sample(from_sun);
    if (lit.moon) {
        DomePlace place = lit.moon->dome().place(direction);
        place.from_horizon = from_sun.from_horizon;
        sum += lit.moon_strength * lit.moon->dome().sample(place);
    }
    return sum;
}

void append(std::vector<float>& out, const glm::vec3& colour) {
    out.insert(out.end(), {colour.r, colour.g, colour.b, 1});
}

/// Means of two by two.
std::vector<glm::vec3> halved(const std::vector<glm::vec3>& layer, int wide, int high) {
    const int columns = std::max(wide / 2, 1), rows = std::max(high / 2, 1);
    std::vector<glm::vec3> half(static_cast<std::size_t>(columns * rows));
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) {
            const auto at = [&](int px, int py) {
                return layer[static_cast<std::size_t>(std::min(py, high - 1) * wide +
                                                      std::min(px, wide - 1))];
            };
            half[static_cast<std::size_t>(y * columns + x)] =
                0.25f * (at(2 * x, 2 * y) + at(2 * x + 1, 2 * y) + at(2 * x, 2 * y + 1) +
                         at(2 * x + 1, 2 * y + 1));
        }
    return half;
}

} // namespace

glm::dvec3 level_irradiance(const Dome& dome) {
    constexpr int rings = 48, spokes = 96;
    glm::dvec3 sum(0);
    for (int i = 0; i < rings; ++i) {
        // Equal steps of the square of the sine: equal shares of a level plane's view.
        const double z = std::sqrt((i + 0.5) / rings), level = std::sqrt(1 - z * z);
        for (int j = 0; j < spokes; ++j) {
            const double turn = 2 * pi * (j + 0.5) / spokes;
            sum += dome.sample(glm::dvec3(level * std::cos(turn), level * std::sin(turn), z));
        }
    }
    return sum * (pi / (rings * spokes));
}

Dome clear_dome(const Lit& lit, const AirTables& air, const CloudLayer& clouds, bool below,
                ThreadPool& pool) {
    Dome out(shaders::sky_columns, shaders::sky_rows, lit.sun->dome().azimuth_rad(),
             lit.sun->dome().dip_rad());
    for_rows(pool, out.rows(), [&](int y) {
        const bool sky = y >= out.rows() / 2;
        for (int x = 0; x < out.columns(); ++x) {
            const glm::dvec3 direction = out.direction(x, y);
            DomePlace place = out.place(direction);
            place.from_horizon = std::copysign(place.from_horizon, sky ? 1 : -1);
            const glm::dvec3 value = sample(lit, direction, place);
            out.at(x, y) = glm::vec3(sky     ? value + glow(air, lit.sun->height_m(), direction)
                                     : below ? glm::mix(clouds.shaded, value, clouds.sunlit)
                                             : value);
        }
    });
    return out;
}

Dome with_clouds(Dome dome, const CloudLayer& layer, const std::vector<glm::vec2>& noise,
                 const AirTables& air, ThreadPool& pool) {
    if (layer.threshold > 1.5)
        return dome;
    const glm::dvec3 depth = depth_above(air, 0);
    for_rows(pool, dome.rows() / 2, [&](int half) {
        const int y = dome.rows() / 2 + half;
        for (int x = 0; x < dome.columns(); ++x) {
            const glm::dvec3 direction = dome.direction(x, y);
            const CloudSeen seen =
                clouds_seen(layer, noise, shaders::sky_columns, shaders::sky_rows, direction);
            const glm::dvec3 left = air_left(air.air, 0, seen.distance_m, direction.z);
            dome.at(x, y) = glm::vec3(
                behind_clouds(layer, seen, glm::dvec3(dome.at(x, y)), depth, left, direction.z));
        }
    });
    return dome;
}

void lay_sea(Dome& dome, const glm::dvec3& down_klx, ThreadPool& pool) {
    const Dome sky = dome;
    for_rows(pool, dome.rows() / 2, [&](int y) {
        for (int x = 0; x < dome.columns(); ++x) {
            const glm::dvec3 direction = dome.direction(x, y);
            // Facets that are seen lean towards the eye: they mirror what stands higher.
            const double raised = std::min(-direction.z + facet_slope, 1.0);
            const double level = std::sqrt(1 - raised * raised) /
                                 std::max(std::hypot(direction.x, direction.y), 1e-9);
            const glm::dvec3 mirrored(direction.x * level, direction.y * level, raised);
            const double fresnel = sea_reflectance(-direction.z);
            dome.at(x, y) = glm::vec3(fresnel * sky.sample(mirrored) +
                                      (1 - fresnel) * water_reflectance * down_klx / pi);
        }
    });
}

std::vector<float> picture_of(const BlurredDome& sea, const Dome& eye,
                              const std::vector<glm::vec2>& noise) {
    std::vector<float> out;
    std::vector<glm::vec3> clouds(noise.size());
    std::transform(noise.begin(), noise.end(), clouds.begin(),
                   [](const glm::vec2& n) { return glm::vec3(n.x, n.y, 0); });
    std::vector<glm::vec3> layers[] = {sea.sharp().texels(), eye.texels(), clouds};
    int columns = shaders::sky_columns, rows = shaders::sky_rows;
    for (int m = 0;; ++m) {
        for (const std::vector<glm::vec3>& layer : layers)
            for (const glm::vec3& texel : layer)
                append(out, texel);
        if (columns == 1 && rows == 1)
            return out;
        for (std::vector<glm::vec3>& layer : layers)
            layer = halved(layer, columns, rows);
        if (m + 1 < BlurredDome::levels)
            layers[0] = sea.level(m + 1);
        columns = std::max(columns / 2, 1);
        rows = std::max(rows / 2, 1);
    }
}

} // namespace seaway::client
