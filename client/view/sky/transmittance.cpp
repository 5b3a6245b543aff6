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

TransmittanceAt::TransmittanceAt(const TransmittanceTable& table, double height_m)
    : top_radius_m_(top_radius_m(table.air_)) {
    const Air& air = table.air_;
    radius_m_ = air.planet_radius_m + std::clamp(height_m, 0.0, air.thickness_m);
    const double farthest = horizon_m(air, top_radius_m_), rho = horizon_m(air, radius_m_);
    lowest_cosine_ = -rho / radius_m_;
    shortest_m_ = top_radius_m_ - radius_m_;
    longest_m_ = rho + farthest;
    const double y = rho / farthest * (TransmittanceTable::height - 1);
    const int row = std::min(static_cast<int>(y), TransmittanceTable::height - 2);
    below_ = &table.depth_[static_cast<std::size_t>(row * TransmittanceTable::width)];
    above_ = static_cast<float>(y - row);
    horizon_sine_ = air.planet_radius_m / (air.planet_radius_m + std::max(height_m, 0.0));
    horizon_cosine_ = -std::sqrt(std::max(1 - horizon_sine_ * horizon_sine_, 0.0));
}

glm::dvec3 TransmittanceAt::to_space(double zenith_cosine) const {
    constexpr int width = TransmittanceTable::width;
    const double r = radius_m_, top = top_radius_m_;
    const double cosine = std::max(zenith_cosine, lowest_cosine_); // not below the horizon
    const double d =
        -r * cosine + std::sqrt(std::max(r * r * (cosine * cosine - 1) + top * top, 0.0));
    const double across = std::clamp((d - shortest_m_) / (longest_m_ - shortest_m_), 0.0, 1.0);
    const double x = across * (width - 1);
    const int column = std::min(static_cast<int>(x), width - 2);
    const auto fx = static_cast<float>(x - column);
    const glm::vec3* low = below_ + column;
    const glm::vec3* high = low + width;
    const glm::vec3 depth =
        glm::mix(glm::mix(low[0], low[1], fx), glm::mix(high[0], high[1], fx), above_);
    return glm::exp(-glm::dvec3(depth));
}

glm::dvec3 TransmittanceAt::to_disc(double zenith_cosine, double radius_rad) const {
    // The angle above the horizon is nearly this difference over the sine of the horizon's zenith angle.
    const double above = (zenith_cosine - horizon_cosine_) / (horizon_sine_ * radius_rad);
    const double t = std::clamp(0.5 + 0.5 * above, 0.0, 1.0);
    if (t == 0)
        return glm::dvec3(0);
    return t * to_space(zenith_cosine);
}

glm::dvec3 TransmittanceTable::to_space(double height_m, double zenith_cosine) const {
    return at(height_m).to_space(zenith_cosine);
}

glm::dvec3 TransmittanceTable::to_disc(double height_m, double zenith_cosine,
                                       double radius_rad) const {
    return at(height_m).to_disc(zenith_cosine, radius_rad);
}

} // namespace seaway::client
