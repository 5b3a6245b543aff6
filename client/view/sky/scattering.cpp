// SPDX-License-Identifier: Apache-2.0
#include "client/view/sky/scattering.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "client/view/sky/two_stream.h"

namespace seaway::client {

namespace {

using std::numbers::pi;
constexpr int directions_a_side = 8; // 64 directions, as Hillaire 2020
constexpr int transfer_steps = 20;

/// Of light scattered once; of the rest too unless `once`.
glm::dvec3 radiance_along(const AirTables& t, const AirWay& way, double to_sun_cosine,
                          double sun_cosine, bool once) {
    const double rayleigh = rayleigh_phase(to_sun_cosine);
    const double aerosol = aerosol_phase(t.air.aerosol_asymmetry, to_sun_cosine);
    glm::dvec3 sum(0);
    for (const AirStep& step : way.steps) {
        const double sun = way.sun_cosine(step, sun_cosine, to_sun_cosine);
        sum += step.light.to_disc(sun, disc_radius_rad) *
               (step.rayleigh * rayleigh + step.aerosol * aerosol);
        if (!once)
            sum += t.multiple.at(step.height_m, sun) * step.scattered();
    }
    return sum;
}

AirLight integrate(const AirTables& t, double height_m, const glm::dvec3& direction,
                   const glm::dvec3& to_sun, double distance_m, int steps, bool once) {
    const AirWay way = way_through(t.air, t.transmittance, ray_from(t.air, height_m, direction.z),
                                   distance_m, steps);
    return {radiance_along(t, way, glm::dot(direction, to_sun), to_sun.z, once), way.passed};
}

/// Signed square root and back: rows are dense where the sun stands near the horizon.
double packed(double cosine) {
    return 0.5 + 0.5 * std::copysign(std::sqrt(std::abs(cosine)), cosine);
}
double unpacked(double x) {
    const double root = 2 * x - 1;
    return root * std::abs(root);
}

/// What a ring of directions shows of a sun, scattered once or by the sea: the mean around it.
glm::dvec3 lit_around(const Air& air, const TransmittanceTable& transmittance, const AirWay& way,
                      double sun_cosine) {
    // The other half of the ring is the mirror image.
    constexpr int half = directions_a_side / 2;
    const double z = way.ray.cosine;
    const double level =
        std::sqrt(1 - z * z) * std::sqrt(std::max(1 - sun_cosine * sun_cosine, 0.0));
    const bool sea = meets_sea(air, way.ray);
    const TransmittanceAt light_at_sea = transmittance.at(0);
    const double end_radius_m = radius_after_m(way.ray, way.length_m);
    glm::dvec3 sum(0);
    for (int i = 0; i < half; ++i) {
        const double to_ray = z * sun_cosine + level * std::cos(pi * (i + 0.5) / half);
        for (const AirStep& step : way.steps)
            sum += step.scattered() / (4 * pi) *
                   step.light.to_disc(way.sun_cosine(step, sun_cosine, to_ray), disc_radius_rad);
        if (sea) {
            const double sun =
                (way.ray.radius_m * sun_cosine + way.length_m * to_ray) / end_radius_m;
            sum += way.passed * light_at_sea.to_disc(sun, disc_radius_rad) * std::max(sun, 0.0) *
                   air.ground_albedo / pi;
        }
    }
    return sum / static_cast<double>(half);
}

} // namespace

std::vector<Transfer> transfers_at(const Air& air, const TransmittanceTable& transmittance,
                                   double height_m, const std::vector<double>& sun_cosines) {
    constexpr int n = directions_a_side;
    const double share = 1.0 / n; // of a ring: equal solid angles
    Transfer way_alone{};
    std::vector<glm::dvec3> lit(sun_cosines.size(), glm::dvec3(0));
    for (int ring = 0; ring < n; ++ring) {
        const double z = 1 - 2 * (ring + 0.5) / n;
        const Ray ray = ray_from(air, height_m, z);
        const AirWay way = way_through(air, transmittance, ray, length_m(air, ray), transfer_steps);
        for (const AirStep& step : way.steps) {
            way_alone.scattered += share * step.scattered();
            way_alone.absorbed += share * step.absorbed;
        }
        way_alone.passed += share * way.passed;
        for (std::size_t i = 0; i < lit.size(); ++i)
            lit[i] += share * lit_around(air, transmittance, way, sun_cosines[i]);
    }
    std::vector<Transfer> out(sun_cosines.size(), way_alone);
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i].lit = lit[i];
    return out;
}

MultipleScattering::MultipleScattering(const Air& air, const TransmittanceTable& transmittance,
                                       ThreadPool& pool)
    : thickness_m_(air.thickness_m), table_(static_cast<std::size_t>(size * size)) {
    const glm::dvec3 dense = two_stream_share(depth_of_air(air));
    std::vector<double> sun_cosines;
    for (int x = 0; x < size; ++x)
        sun_cosines.push_back(unpacked(static_cast<double>(x) / (size - 1)));
    std::vector<std::optional<TwoStream>> streams(size);
    if (dense != glm::dvec3(0))
        for_rows(pool, size, [&](int x) {
            streams[static_cast<std::size_t>(x)].emplace(air, transmittance,
                                                         sun_cosines[static_cast<std::size_t>(x)]);
        });
    for_rows(pool, size, [&](int y) {
        const double root = static_cast<double>(y) / (size - 1);
        const double height_m = root * root * thickness_m_;
        const std::vector<Transfer> transfers =
            transfers_at(air, transmittance, height_m, sun_cosines);
        for (int x = 0; x < size; ++x) {
            const Transfer& t = transfers[static_cast<std::size_t>(x)];
            glm::dvec3& value = table_[static_cast<std::size_t>(y * size + x)];
            // What is not scattered again: summed, as the difference to 1 is lost to rounding.
            const glm::dvec3 lost = t.passed + t.absorbed;
            for (int c = 0; c < 3; ++c)
                value[c] = dense[c] < 1 ? t.lit[c] / lost[c] : 0;
            if (const auto& stream = streams[static_cast<std::size_t>(x)])
                value = glm::mix(value, stream->at(height_m), dense);
        }
    });
}

glm::dvec3 MultipleScattering::at(double height_m, double sun_cosine) const {
    const double x = packed(std::clamp(sun_cosine, -1.0, 1.0)) * (size - 1);
    const double y = std::sqrt(std::clamp(height_m / thickness_m_, 0.0, 1.0)) * (size - 1);
    const int x0 = std::min(static_cast<int>(x), size - 2);
    const int y0 = std::min(static_cast<int>(y), size - 2);
    const glm::dvec3* low = &table_[static_cast<std::size_t>(y0 * size + x0)];
    const glm::dvec3* high = low + size;
    return glm::mix(glm::mix(low[0], low[1], x - x0), glm::mix(high[0], high[1], x - x0), y - y0);
}

AirTables::AirTables(const Atmosphere& atmosphere, ThreadPool& pool)
    : air(atmosphere), transmittance(air, pool), multiple(air, transmittance, pool) {}

glm::dvec3 depth_above(const AirTables& tables, double height_m) {
    // Air that absorbs a part of the spectrum alone leaves a colour that no screen has: more than all of one of its
    // lights, or less than none of another. Skies are divided by what their air holds back, which is never nothing.
    constexpr double share_min = 1e-30, depth_min = 1e-4;
    const glm::dvec3 left = sunlight_klx(tables.transmittance.to_space(height_m, 1));
    const glm::dvec3 share = left / sunlight_klx(glm::dvec3(1));
    return glm::max(-glm::log(glm::max(share, share_min)), depth_min);
}

glm::dvec3 air_radiance(const AirTables& tables, const AirWay& way, double to_sun_cosine,
                        double sun_cosine) {
    return radiance_along(tables, way, to_sun_cosine, sun_cosine, false);
}

AirLight air_light(const AirTables& tables, double height_m, const glm::dvec3& direction,
                   const glm::dvec3& to_sun, double distance_m, int steps) {
    return integrate(tables, height_m, direction, to_sun, distance_m, steps, false);
}

AirLight single_scattering(const AirTables& tables, double height_m, const glm::dvec3& direction,
                           const glm::dvec3& to_sun, double distance_m, int steps) {
    return integrate(tables, height_m, direction, to_sun, distance_m, steps, true);
}

} // namespace seaway::client
