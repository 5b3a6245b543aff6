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

double sun_cosine_after(double radius_m, const glm::dvec3& direction, const glm::dvec3& to_sun,
                        double distance_m) {
    const glm::dvec3 place = glm::dvec3(0, 0, radius_m) + distance_m * direction;
    return glm::dot(place, to_sun) / glm::length(place);
}

AirLight integrate(const AirTables& t, double height_m, const glm::dvec3& direction,
                   const glm::dvec3& to_sun, double distance_m, int steps, bool once) {
    const Ray ray = ray_from(t.air, height_m, direction.z);
    const double cosine = glm::dot(direction, to_sun);
    const double rayleigh = rayleigh_phase(cosine);
    const double aerosol = aerosol_phase(t.air.aerosol_asymmetry, cosine);
    AirLight sum{glm::dvec3(0), glm::dvec3(1)};
    const double lowest_m = std::clamp(-ray.radius_m * ray.cosine, 0.0, distance_m);
    walk(lowest_m, distance_m, steps, [&](double at_m, double step_m) {
        const double here_m = height_after_m(t.air, ray, at_m);
        const double sun = sun_cosine_after(ray.radius_m, direction, to_sun, at_m);
        const Medium medium = t.air.at(here_m);
        glm::dvec3 source = t.transmittance.to_disc(here_m, sun, disc_radius_rad) *
                            (medium.rayleigh_per_m * rayleigh + medium.aerosol_per_m * aerosol);
        if (!once)
            source += t.multiple.at(here_m, sun) * (medium.rayleigh_per_m + medium.aerosol_per_m);
        glm::dvec3 through;
        const glm::dvec3 length = over_step(medium.extinction_per_m, step_m, through);
        sum.radiance += sum.transmittance * source * length;
        sum.transmittance *= through;
    });
    return sum;
}

/// Signed square root and back: rows are dense where the sun stands near the horizon.
double packed(double cosine) {
    return 0.5 + 0.5 * std::copysign(std::sqrt(std::abs(cosine)), cosine);
}
double unpacked(double x) {
    const double root = 2 * x - 1;
    return root * std::abs(root);
}

} // namespace

Transfer transfer_at(const Air& air, const TransmittanceTable& transmittance, double height_m,
                     double sun_cosine) {
    const glm::dvec3 to_sun(std::sqrt(std::max(1 - sun_cosine * sun_cosine, 0.0)), 0, sun_cosine);
    constexpr int n = directions_a_side;
    Transfer sum{glm::dvec3(0), glm::dvec3(0), glm::dvec3(0), glm::dvec3(0)};
    for (int i = 0; i < n * n; ++i) {
        const int ring = i / n;
        const double z = 1 - 2 * (ring + 0.5) / n; // equal solid angles
        const double turn = 2 * pi * (i % n + 0.5) / n, level = std::sqrt(1 - z * z);
        const glm::dvec3 direction(level * std::cos(turn), level * std::sin(turn), z);
        const Ray ray = ray_from(air, height_m, z);
        const double distance_m = length_m(air, ray);
        glm::dvec3 seen(1);
        const double lowest_m = std::clamp(-ray.radius_m * z, 0.0, distance_m);
        walk(lowest_m, distance_m, transfer_steps, [&](double at_m, double step_m) {
            const double here_m = height_after_m(air, ray, at_m);
            const double sun = sun_cosine_after(ray.radius_m, direction, to_sun, at_m);
            const Medium medium = air.at(here_m);
            glm::dvec3 through;
            const glm::dvec3 length = over_step(medium.extinction_per_m, step_m, through);
            const glm::dvec3 scattering_per_m = medium.rayleigh_per_m + medium.aerosol_per_m;
            const glm::dvec3 scattered = seen * length * scattering_per_m;
            sum.scattered += scattered;
            sum.absorbed +=
                seen * length * glm::max(medium.extinction_per_m - scattering_per_m, 0.0);
            sum.lit += scattered * transmittance.to_disc(here_m, sun, disc_radius_rad) / (4 * pi);
            seen *= through;
        });
        sum.passed += seen;
        if (meets_sea(air, ray)) {
            const double sun = sun_cosine_after(ray.radius_m, direction, to_sun, distance_m);
            sum.lit += seen * transmittance.to_disc(0, sun, disc_radius_rad) * std::max(sun, 0.0) *
                       air.ground_albedo / pi;
        }
    }
    const double share = 1.0 / (n * n);
    return {sum.lit * share, sum.scattered * share, sum.absorbed * share, sum.passed * share};
}

MultipleScattering::MultipleScattering(const Air& air, const TransmittanceTable& transmittance,
                                       ThreadPool& pool)
    : thickness_m_(air.thickness_m), table_(static_cast<std::size_t>(size * size)) {
    const glm::dvec3 dense = two_stream_share(depth_of_air(air));
    const auto sun_cosine = [](int x) { return unpacked(static_cast<double>(x) / (size - 1)); };
    std::vector<std::optional<TwoStream>> streams(size);
    if (dense != glm::dvec3(0))
        for_rows(pool, size, [&](int x) {
            streams[static_cast<std::size_t>(x)].emplace(air, transmittance, sun_cosine(x));
        });
    for_rows(pool, size, [&](int y) {
        const double root = static_cast<double>(y) / (size - 1);
        const double height_m = root * root * thickness_m_;
        for (int x = 0; x < size; ++x) {
            const Transfer t = transfer_at(air, transmittance, height_m, sun_cosine(x));
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

AirLight air_light(const AirTables& tables, double height_m, const glm::dvec3& direction,
                   const glm::dvec3& to_sun, double distance_m, int steps) {
    return integrate(tables, height_m, direction, to_sun, distance_m, steps, false);
}

AirLight single_scattering(const AirTables& tables, double height_m, const glm::dvec3& direction,
                           const glm::dvec3& to_sun, double distance_m, int steps) {
    return integrate(tables, height_m, direction, to_sun, distance_m, steps, true);
}

} // namespace seaway::client
