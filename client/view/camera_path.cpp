// SPDX-License-Identifier: Apache-2.0
#include "client/view/camera_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "base/csv_table.h"

namespace seaway::client {

namespace {

constexpr std::size_t rows_max = 100'000;
/// Times of all seas (sea::time_us_max), and the least step that they know.
constexpr double path_time_max_s = 1e12;
constexpr double path_step_min_s = 1e-6;

struct Column {
    const char* name;
    double Camera::*value;
    double low, high;
    bool needed = true;
};
constexpr std::array<Column, 6> path_columns{{
    {"x_m", &Camera::x_m, -camera_place_max_m, camera_place_max_m},
    {"y_m", &Camera::y_m, -camera_place_max_m, camera_place_max_m},
    {"z_m", &Camera::z_m, camera_height_min_m, camera_height_max_m},
    {"yaw_deg", &Camera::yaw_deg, -camera_yaw_max_deg, camera_yaw_max_deg},
    {"pitch_deg", &Camera::pitch_deg, -camera_pitch_max_deg, camera_pitch_max_deg},
    {"fov_deg", &Camera::view_deg, camera_view_min_deg, camera_view_max_deg, false},
}};

/// The angle that is the same direction as `angle` and nearest to `near`, deg.
double unwrapped(double angle, double near) {
    return near + std::remainder(angle - near, 360.0);
}

/// In order, and so far apart and no further that slopes are finite.
Result<void> check_time(const CsvTable& table, std::size_t row, std::size_t column) {
    const double t_s = table.rows[row][column];
    if (std::abs(t_s) > path_time_max_s)
        return table.error(
            row, fmt::format("t_s {:g}: {:g} .. {:g}", t_s, -path_time_max_s, path_time_max_s));
    if (row == 0)
        return {};
    const double before_s = table.rows[row - 1][column];
    if (t_s <= before_s)
        return table.error(row, fmt::format("t_s {:.9g} does not lie after the row before, {:.9g}",
                                            t_s, before_s));
    // A step of 1e-6 s late in time is rounded to somewhat less.
    if (t_s - before_s < 0.5 * path_step_min_s)
        return table.error(row, fmt::format("t_s {:.9g} is {:.3g} s after the row before; at least "
                                            "{:g} s",
                                            t_s, t_s - before_s, path_step_min_s));
    return {};
}

} // namespace

Result<CameraPath> CameraPath::parse(std::string_view text, const std::string& name,
                                     const Camera& base) {
    SEAWAY_TRY_LET(const CsvTable table, parse_csv(text, name, rows_max));
    const std::optional<std::size_t> time = table.column("t_s");
    if (!time)
        return Error{name + ": no column t_s"};
    for (const Column& column : path_columns)
        if (column.needed && !table.column(column.name))
            return Error{fmt::format("{}: no column {}", name, column.name)};
    std::vector<Key> keys;
    for (std::size_t row = 0; row < table.rows.size(); ++row) {
        Key key{table.rows[row][*time], base};
        SEAWAY_TRY(check_time(table, row, *time));
        for (const Column& column : path_columns) {
            const std::optional<std::size_t> at = table.column(column.name);
            if (!at)
                continue;
            const double value = table.rows[row][*at];
            if (value < column.low || value > column.high)
                return table.error(row, fmt::format("{} {:g}: {:g} .. {:g}", column.name, value,
                                                    column.low, column.high));
            key.camera.*column.value = value;
        }
        if (!keys.empty())
            key.camera.yaw_deg = unwrapped(key.camera.yaw_deg, keys.back().camera.yaw_deg);
        keys.push_back(key);
    }
    return CameraPath(std::move(keys));
}

CameraPath CameraPath::turntable(const Camera& base, double duration_s) {
    constexpr int parts = 64;
    constexpr double ahead_m = 100;
    const glm::dvec3 forward = base.forward();
    const double level = std::hypot(forward.x, forward.y);
    // Under water it looks up to the surface.
    const double to_sea = base.z_m < 0 ? forward.z : -forward.z;
    const double radius_m =
        to_sea > 1e-3 ? std::min(std::abs(base.z_m) * level / to_sea, 1000 * ahead_m) : ahead_m;
    const glm::dvec2 centre =
        glm::dvec2(base.x_m, base.y_m) +
        radius_m * glm::dvec2(std::cos(base.azimuth_rad()), std::sin(base.azimuth_rad()));
    std::vector<Key> keys;
    for (int i = 0; i <= parts; ++i) {
        Key key{duration_s * i / parts, base};
        const double yaw_deg = base.yaw_deg + 360.0 * i / parts;
        const double azimuth_rad = (90 - yaw_deg) * std::numbers::pi / 180;
        key.camera.yaw_deg = yaw_deg;
        key.camera.x_m = centre.x - radius_m * std::cos(azimuth_rad);
        key.camera.y_m = centre.y - radius_m * std::sin(azimuth_rad);
        keys.push_back(key);
    }
    return CameraPath(std::move(keys));
}

Camera CameraPath::at(double t_s) const {
    if (t_s <= keys_.front().t_s)
        return keys_.front().camera;
    if (t_s >= keys_.back().t_s)
        return keys_.back().camera;
    const auto after = std::upper_bound(keys_.begin(), keys_.end(), t_s,
                                        [](double t, const Key& key) { return t < key.t_s; });
    const Key& b = *after;
    const Key& a = *(after - 1);
    const Key& before = after - 1 == keys_.begin() ? a : *(after - 2);
    const Key& later = after + 1 == keys_.end() ? b : *(after + 1);
    const double span_s = b.t_s - a.t_s;
    const double s = (t_s - a.t_s) / span_s, r = 1 - s;
    Camera camera = a.camera;
    for (const Column& column : path_columns) {
        const auto value = [&](const Key& key) { return key.camera.*column.value; };
        const auto slope = [&](const Key& from, const Key& to) {
            return (value(to) - value(from)) / (to.t_s - from.t_s);
        };
        const double cubic = r * r * (1 + 2 * s) * value(a) + s * s * (1 + 2 * r) * value(b) +
                             s * r * span_s * (r * slope(before, b) - s * slope(a, later));
        // Yaw was unwrapped and has no ends: after a hundred turns it goes on.
        const bool turns = column.value == &Camera::yaw_deg;
        camera.*column.value = turns ? cubic : std::clamp(cubic, column.low, column.high);
    }
    camera.z_m = std::max(camera.z_m, std::min(a.camera.z_m, b.camera.z_m));
    return camera;
}

} // namespace seaway::client
