// SPDX-License-Identifier: Apache-2.0
#include "client/view/sky/dome.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace seaway::client {

namespace {

using std::numbers::pi;

} // namespace

Dome::Dome(int columns, int rows, double azimuth_rad, double dip_rad)
    : columns_(columns), rows_(rows), azimuth_rad_(azimuth_rad), dip_rad_(dip_rad),
      texels_(static_cast<std::size_t>(columns * rows)) {}

glm::dvec3 Dome::direction(int column, int row) const {
    return direction_at((column + 0.5) / columns_, (row + 0.5) / rows_);
}

glm::dvec3 Dome::direction_at(double across, double up) const {
    const double half = 0.5 * rows_, row = up * rows_ - 0.5;
    const bool sky = row >= half - 0.5;
    const double root = std::clamp((sky ? row - half : half - 1 - row) / (half - 1), 0.0, 1.0);
    const double elevation =
        (sky ? root * root * (pi / 2 + dip_rad_) : -root * root * (pi / 2 - dip_rad_)) - dip_rad_;
    const double turn = azimuth_rad_ + 2 * pi * across;
    const double level = std::cos(elevation);
    return {level * std::cos(turn), level * std::sin(turn), std::sin(elevation)};
}

DomePlace Dome::place(const glm::dvec3& direction) const {
    const double above = std::asin(std::clamp(direction.z, -1.0, 1.0)) + dip_rad_;
    const double range = pi / 2 + (above < 0 ? -dip_rad_ : dip_rad_);
    const double turn = (std::atan2(direction.y, direction.x) - azimuth_rad_) / (2 * pi);
    const double root = std::sqrt(std::min(std::abs(above) / range, 1.0));
    return {turn - std::floor(turn), above < 0 ? -root : root};
}

glm::dvec3 Dome::sample(const glm::dvec3& direction) const {
    return sample(place(direction));
}

glm::dvec3 Dome::sample(const DomePlace& place) const {
    const int half = rows_ / 2;
    const double x = place.around * columns_ - 0.5 + columns_;
    const bool sky = !std::signbit(place.from_horizon);
    const double y = std::abs(place.from_horizon) * (half - 1);
    const int step = std::min(static_cast<int>(y), half - 2);
    const int row = sky ? half + step : half - 1 - step, next = sky ? row + 1 : row - 1;
    const int left = static_cast<int>(x) % columns_, right = (left + 1) % columns_;
    const auto texel = [&](int column, int line) {
        return glm::dvec3(texels_[static_cast<std::size_t>(line * columns_ + column)]);
    };
    const double fx = x - std::floor(x), fy = y - step;
    return glm::mix(glm::mix(texel(left, row), texel(right, row), fx),
                    glm::mix(texel(left, next), texel(right, next), fx), fy);
}

} // namespace seaway::client
