// SPDX-License-Identifier: Apache-2.0
#include "client/view/mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace seaway::client {

namespace {

constexpr double pi = std::numbers::pi;
constexpr double row_pixels = 0.4; ///< height of a far cell on the picture
/// Length of a cell in wave heights: the dominant waves are 15 to 30 heights long.
constexpr double cells_a_height = 2.5;

/// Largest angle between the forward direction and a ray that may meet the sea.
double half_span(const Camera& camera) {
    const double pitch = glm::radians(camera.pitch_deg);
    const double half_height =
        std::atan(std::tan(glm::radians(camera.view_deg) / 2) * camera.height / camera.width);
    if (pitch - half_height < -pi / 2 + 0.02)
        return pi; // straight down is in the picture
    double widest = 0;
    constexpr int steps = 64;
    for (int i = 0; i <= steps; ++i)
        for (const double side : {-1.0, 1.0}) {
            const double along = 2.0 * i / steps - 1;
            for (const glm::dvec3 ray : {camera.ray(side, along), camera.ray(along, side)}) {
                const double azimuth = std::atan2(ray.y, ray.x) - camera.azimuth_rad();
                widest = std::max(widest, std::abs(std::remainder(azimuth, 2 * pi)));
            }
        }
    return widest;
}

} // namespace

Mesh build_mesh(const Camera& camera, const SeaStatistics& sea, double finest_m,
                double cell_pixels) {
    Mesh mesh;
    const double reach = sea.reach_m + 1;
    const double half = half_span(camera);
    const bool circle = half > 0.45 * pi;
    const double cell_rad = cell_pixels * camera.pixel_rad();
    const double back = circle ? 0 : reach / std::sin(half);
    const double span = circle ? 2 * pi : 2 * half;
    mesh.columns =
        std::clamp(static_cast<int>(std::ceil(span / cell_rad)) + 1, 3, Mesh::columns_max);
    mesh.step_rad = span / (mesh.columns - 1);
    mesh.azimuth_rad = camera.azimuth_rad() - span / 2;
    mesh.apex_m =
        -back * glm::dvec2(std::cos(camera.azimuth_rad()), std::sin(camera.azimuth_rad()));

    const double height = std::max(camera.z_m, 1.0);
    const double clearance = std::max(camera.z_m - sea.crest_m, 0.5);
    // Beyond the horizon of the mean sea, crests still show.
    const double end = back + reach + std::sqrt(2 * earth_radius_m * height) +
                       std::sqrt(2 * earth_radius_m * sea.crest_m) + 100;
    const double pixel_rad = camera.pixel_rad();
    double r = 0.5;
    while (mesh.rows_m.size() + 1 < Mesh::rows_max && r < end) {
        mesh.rows_m.push_back(static_cast<float>(r));
        const double along = std::max(std::abs(r - back) - reach, 0.0);
        const double distance = std::hypot(along, clearance);
        // As seen on a level sea, but never coarser than the waves that stand out as crests.
        const double seen = row_pixels * pixel_rad * distance * distance / clearance;
        const double waves = distance * pixel_rad < sea.significant_height_m
                                 ? cells_a_height * sea.significant_height_m
                                 : distance * cell_rad;
        r += std::max({finest_m, std::min(seen, waves), row_pixels * pixel_rad * distance});
    }
    mesh.rows_m.push_back(static_cast<float>(end));
    return mesh;
}

std::vector<std::uint32_t> strip_indices(int columns, int rows) {
    std::vector<std::uint32_t> indices;
    indices.reserve(static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns - 1) * 6);
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column + 1 < columns; ++column) {
            const auto a = static_cast<std::uint32_t>(row * columns + column);
            const std::uint32_t b = a + 1;
            const std::uint32_t c = a + static_cast<std::uint32_t>(columns);
            const std::uint32_t d = c + 1;
            for (const std::uint32_t index : {a, b, c, b, d, c})
                indices.push_back(index);
        }
    return indices;
}

} // namespace seaway::client
