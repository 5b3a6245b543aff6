// SPDX-License-Identifier: Apache-2.0
#include "client/view/sky/transmittance.h"

#include <algorithm>
#include <cmath>

namespace seaway::client {

namespace {

constexpr int table_steps = 24;
constexpr double gauss_nodes[] = {0.21132486540518713, 0.78867513459481287};

/// Distance from a point to the tangent of the sea's sphere through it.
double horizon_m(const Atmosphere& air, double radius_m) {
    const double edge = air.planet_radius_m;
    return std::sqrt(std::max(radius_m * radius_m - edge * edge, 0.0));
}

double top_radius_m(const Atmosphere& air) {
    return air.planet_radius_m + air.thickness_m;
}

} // namespace

glm::dvec3 optical_depth(const Air& air, const Ray& ray, double distance_m, int steps) {
    // Steps are short where the ray is lowest, which is where the air is dense.
    const double lowest_m = std::clamp(-ray.radius_m * ray.cosine, 0.0, distance_m);
    glm::dvec3 depth(0);
    for (const double end_m : {0.0, distance_m}) {
        const double span_m = end_m - lowest_m;
        if (span_m == 0)
            continue;
        for (int i = 0; i < steps; ++i)
            for (const double node : gauss_nodes) { // two a step: exact for cubics
                const double root = (i + node) / steps;
                const double step_m = std::abs(span_m) * root / steps; // half of ds = 2 root droot
                const double at_m = height_after_m(air, ray, lowest_m + span_m * root * root);
                depth += step_m * air.at(at_m).extinction_per_m;
            }
    }
    return depth;
}

TransmittanceTable::TransmittanceTable(const Air& air, ThreadPool& pool)
    : air_(air), depth_(static_cast<std::size_t>(width * height)) {
    const double farthest = horizon_m(air, top_radius_m(air));
    for_rows(pool, height, [&](int y) {
        const double rho = farthest * y / (height - 1);
        const double r = std::sqrt(rho * rho + air.planet_radius_m * air.planet_radius_m);
        const double shortest_m = top_radius_m(air) - r, longest_m = rho + farthest;
        for (int x = 0; x < width; ++x) {
            const double d = shortest_m + (longest_m - shortest_m) * x / (width - 1);
            const double cosine =
                d == 0 ? 1 : (farthest * farthest - rho * rho - d * d) / (2 * r * d);
            const Ray ray{r, std::clamp(cosine, -1.0, 1.0)};
            depth_[static_cast<std::size_t>(y * width + x)] =
                glm::vec3(optical_depth(air, ray, d, table_steps));
        }
    });
}

glm::dvec3 TransmittanceTable::to_space(double height_m, double zenith_cosine) const {
    const double r = air_.planet_radius_m + std::clamp(height_m, 0.0, air_.thickness_m);
    const double farthest = horizon_m(air_, top_radius_m(air_));
    const double rho = horizon_m(air_, r);
    const double cosine = std::max(zenith_cosine, -rho / r); // not below the horizon
    const double top = top_radius_m(air_);
    const double d =
        -r * cosine + std::sqrt(std::max(r * r * (cosine * cosine - 1) + top * top, 0.0));
    const double shortest_m = top - r, longest_m = rho + farthest;
    const double across = std::clamp((d - shortest_m) / (longest_m - shortest_m), 0.0, 1.0);
    const double x = across * (width - 1), y = rho / farthest * (height - 1);
    const int x0 = std::min(static_cast<int>(x), width - 2);
    const int y0 = std::min(static_cast<int>(y), height - 2);
    const auto fx = static_cast<float>(x - x0), fy = static_cast<float>(y - y0);
    const glm::vec3* below = &depth_[static_cast<std::size_t>(y0 * width + x0)];
    const glm::vec3* above = below + width;
    const glm::vec3 depth =
        glm::mix(glm::mix(below[0], below[1], fx), glm::mix(above[0], above[1], fx), fy);
    return glm::exp(-glm::dvec3(depth));
}

glm::dvec3 TransmittanceTable::to_disc(double height_m, double zenith_cosine,
                                       double radius_rad) const {
    const double r = air_.planet_radius_m + std::max(height_m, 0.0);
    const double sine = air_.planet_radius_m / r;
    const double horizon_cosine = -std::sqrt(std::max(1 - sine * sine, 0.0));
    // The angle above the horizon is nearly this difference over the sine of the horizon's zenith angle.
    const double above = (zenith_cosine - horizon_cosine) / (sine * radius_rad);
    const double t = std::clamp(0.5 + 0.5 * above, 0.0, 1.0);
    if (t == 0)
        return glm::dvec3(0);
    return t * to_space(height_m, zenith_cosine);
}

} // namespace seaway::client
