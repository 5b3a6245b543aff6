// SPDX-License-Identifier: Apache-2.0
#include "client/view/sea/mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace seaway::client {

namespace {

using std::numbers::pi;
/// Height of a far cell on the picture over its width: the sea is seen flat there.
constexpr double flat_cells = 0.16;
/// Length of a cell of 2.5 pixels in wave heights: the dominant waves are 15 to 30 heights long.
constexpr double cells_a_height = 2.5;
/// The clearest water, 0.02 a metre, leaves a thousandth of what is so far away.
constexpr double under_water_m = 350;
constexpr int block_columns = 16; ///< of cells whose vertices are drawn together
/// Crests and troughs lie within so many significant heights: six standard deviations.
constexpr double heights_a_crest = 1.5;

/// What of the directions to the sea the picture holds.
struct View {
    double half_span_rad; ///< largest angle sideways; pi: all around
    double lowest_rad;    ///< elevation
    double highest_rad;
};

View view_of(const Camera& camera) {
    const double pitch = glm::radians(camera.pitch_deg);
    const double half_height =
        std::atan(std::tan(glm::radians(camera.view_deg) / 2) * camera.height / camera.width);
    View view{0, pi / 2, -pi / 2};
    constexpr int steps = 64;
    for (int i = 0; i <= steps; ++i)
        for (const double side : {-1.0, 1.0}) {
            const double along = 2.0 * i / steps - 1;
            for (const glm::dvec3 ray : {camera.ray(side, along), camera.ray(along, side)}) {
                const double azimuth = std::atan2(ray.y, ray.x) - camera.azimuth_rad();
                const double elevation = std::atan2(ray.z, std::hypot(ray.x, ray.y));
                view.half_span_rad =
                    std::max(view.half_span_rad, std::abs(std::remainder(azimuth, 2 * pi)));
                view.lowest_rad = std::min(view.lowest_rad, elevation);
                view.highest_rad = std::max(view.highest_rad, elevation);
            }
        }
    if (pitch - half_height < -pi / 2 + 0.02) { // straight down is in the picture
        view.half_span_rad = pi;
        view.lowest_rad = -pi / 2;
    }
    return view;
}

/// Distances over the ground between which the picture shows sea.
struct Ground {
    double near_m; ///< below 0: behind the camera, moved forward
    double far_m;
};

Ground ground_of(const Camera& camera, const View& view, const SeaFrame& sea) {
    const double crest_m = heights_a_crest * sea.significant_height_m;
    const double reach_m = sea.reach_m + 1;
    const double steep = std::max(-view.lowest_rad, 1e-6);
    const double near_m =
        steep < pi / 2 ? std::max(camera.z_m - crest_m, 0.0) / std::tan(steep) - reach_m : -reach_m;
    // Beyond the horizon of the mean sea, crests still show.
    const double horizon_m = std::sqrt(2 * earth_radius_m * std::max(camera.z_m, 1.0)) +
                             std::sqrt(2 * earth_radius_m * crest_m) + 100;
    // Where the picture ends before it; the earth falls away by as much again at the most.
    const double flat = -view.highest_rad - 2 * horizon_dip_rad(camera.z_m);
    const double far_m = flat > 0 ? (camera.z_m + crest_m) / std::tan(flat) : horizon_m;
    return {near_m, std::min(far_m, horizon_m) + reach_m};
}

bool shows_no_sea(const Camera& camera, const View& view, const SeaFrame& sea) {
    return view.lowest_rad > 0 && camera.z_m > heights_a_crest * sea.significant_height_m;
}

/// Distance from a row to the next one.
class Spacing {
  public:
    Spacing(const Camera& camera, const SeaFrame& sea, double cell_pixels)
        : pixel_rad_(camera.pixel_rad()), cell_rad_(cell_pixels * pixel_rad_),
          height_m_(sea.significant_height_m), reach_m_(sea.reach_m + 1),
          clearance_m_(std::max(camera.z_m - sea.significant_height_m, 0.5)),
          wave_m_(cells_a_height * height_m_ * std::sqrt(cell_pixels / 2.5)),
          finest_m_(sea.cascades.empty() ? 0.1
                                         : sea.cascades.back().spec.spacing_m() / 2 *
                                               std::max(cell_pixels / 2.5, 1.0)) {}

    /// At this distance from the camera over the ground.
    double at(double ground_m) const {
        const double along = std::max(std::abs(ground_m) - reach_m_, 0.0);
        const double distance = std::hypot(along, clearance_m_);
        const double square = cell_rad_ * distance;
        // As seen on a level sea, but never coarser than the waves that stand out as crests.
        const double seen = flat_cells * square * distance / clearance_m_;
        const double waves = distance * pixel_rad_ < height_m_ ? wave_m_ : square;
        return std::max({finest_m_, std::min(seen, waves), flat_cells * square});
    }

  private:
    double pixel_rad_, cell_rad_, height_m_, reach_m_, clearance_m_, wave_m_, finest_m_;
};

Mesh mesh_of_cells(const Camera& camera, const SeaFrame& sea, double cell_pixels, double far_m) {
    Mesh mesh;
    const View view = view_of(camera);
    if (shows_no_sea(camera, view, sea))
        return mesh;
    const Ground ground = ground_of(camera, view, sea);
    const bool circle = view.half_span_rad > 0.45 * pi;
    const double half = circle ? pi : view.half_span_rad;
    const double back = circle ? 0 : (sea.reach_m + 1) / std::sin(half);
    mesh.columns =
        std::clamp(static_cast<int>(std::ceil(2 * half / (cell_pixels * camera.pixel_rad()))) + 1,
                   3, Mesh::columns_max);
    mesh.step_rad = 2 * half / (mesh.columns - 1);
    // Within a turn: it becomes a float.
    mesh.azimuth_rad = std::remainder(camera.azimuth_rad(), 2 * pi) - half;
    mesh.apex_m =
        -back * glm::dvec2(std::cos(camera.azimuth_rad()), std::sin(camera.azimuth_rad()));

    const Spacing spacing(camera, sea, cell_pixels);
    const double end = back + std::min(ground.far_m, far_m);
    double r = 0;
    if (ground.near_m > 0) // as far from the apex as the nearest corner of the picture
        r = std::sqrt(back * back + ground.near_m * ground.near_m +
                      2 * back * ground.near_m * (circle ? 1.0 : std::cos(half)));
    while (mesh.rows_m.size() + 1 < Mesh::rows_max && r < end) {
        mesh.rows_m.push_back(static_cast<float>(r));
        r += spacing.at(r - back);
    }
    mesh.rows_m.push_back(static_cast<float>(end));
    return mesh;
}

} // namespace

Mesh build_mesh(const Camera& camera, const SeaFrame& sea, double cell_pixels, bool under) {
    // The surface above an eye is the mirror image of that below an eye as far above it.
    Camera eye = camera;
    if (under) {
        eye.z_m = -camera.z_m;
        eye.pitch_deg = -camera.pitch_deg;
    }
    const double far_m = under ? under_water_m : std::numeric_limits<double>::infinity();
    Mesh mesh = mesh_of_cells(eye, sea, cell_pixels, far_m);
    while (mesh.vertices() > Mesh::vertices_max)
        mesh = mesh_of_cells(eye, sea, cell_pixels *= 1.25, far_m);
    return mesh;
}

std::vector<std::uint32_t> strip_indices(int columns, int rows) {
    std::vector<std::uint32_t> indices;
    indices.reserve(static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns - 1) * 6);
    for (int first = 0; first + 1 < columns; first += block_columns)
        for (int row = 0; row < rows; ++row)
            for (int column = first; column < std::min(first + block_columns, columns - 1);
                 ++column) {
                const auto a = static_cast<std::uint32_t>(row * columns + column);
                const std::uint32_t b = a + 1;
                const std::uint32_t c = a + static_cast<std::uint32_t>(columns);
                const std::uint32_t d = c + 1;
                for (const std::uint32_t index : {a, b, c, b, d, c})
                    indices.push_back(index);
            }
    return indices;
}

std::vector<IndexRange> strip_ranges(int columns, int rows, int used) {
    const auto count = [](int rows_of, int cells) {
        return static_cast<std::uint32_t>(rows_of * cells * 6);
    };
    if (used == rows)
        return {{0, count(rows, columns - 1)}};
    std::vector<IndexRange> ranges;
    for (int first = 0; first + 1 < columns; first += block_columns) {
        const int cells = std::min(block_columns, columns - 1 - first);
        ranges.push_back({count(rows, first), count(used, cells)});
    }
    return ranges;
}

} // namespace seaway::client
