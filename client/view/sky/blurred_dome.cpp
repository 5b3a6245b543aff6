// SPDX-License-Identifier: Apache-2.0
#include "client/view/sky/blurred_dome.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "client/view/sky/transmittance.h"

namespace seaway::client {

namespace {

using std::numbers::pi;
constexpr int lobe_points = 48;

/// Points of a Gaussian lobe of standard deviation 1 an axis, on a spiral.
std::array<glm::dvec2, lobe_points> make_lobe() {
    std::array<glm::dvec2, lobe_points> points;
    double square = 0;
    for (int i = 0; i < lobe_points; ++i) {
        const double radius = std::sqrt(-2 * std::log(1 - (i + 0.5) / lobe_points));
        const double turn = i * pi * (3 - std::sqrt(5.0));
        points[static_cast<std::size_t>(i)] = radius * glm::dvec2(std::cos(turn), std::sin(turn));
        square += radius * radius;
    }
    const double scale = std::sqrt(2 * lobe_points / square);
    for (glm::dvec2& point : points)
        point *= scale;
    return points;
}

} // namespace

BlurredDome::BlurredDome(Dome sharp, ThreadPool& pool) : sharp_(std::move(sharp)) {
    for (int m = 1; m < levels; ++m)
        blurred_[static_cast<std::size_t>(m - 1)] = blur(m, pool);
}

glm::dvec3 BlurredDome::sample_level(int level, const DomePlace& place) const {
    if (level == 0)
        return sharp_.sample(place);
    // What a device's sampler does at the place of level 0.
    const int columns = sharp_.columns() >> level, rows = sharp_.rows() >> level;
    const double half = 0.5 * sharp_.rows();
    const double root = std::abs(place.from_horizon) * (half - 1);
    const double row = std::signbit(place.from_horizon) ? half - 1 - root : half + root;
    const double x = place.around * columns - 0.5 + columns;
    const double y = std::clamp((row + 0.5) / sharp_.rows() * rows - 0.5, 0.0, rows - 1.0);
    const int y0 = std::min(static_cast<int>(y), rows - 2);
    const int x0 = static_cast<int>(x) % columns, x1 = (x0 + 1) % columns;
    const std::vector<glm::vec3>& texels = this->level(level);
    const auto texel = [&](int column, int line) {
        return glm::dvec3(texels[static_cast<std::size_t>(line * columns + column)]);
    };
    const double fx = x - std::floor(x);
    return glm::mix(glm::mix(texel(x0, y0), texel(x1, y0), fx),
                    glm::mix(texel(x0, y0 + 1), texel(x1, y0 + 1), fx), y - y0);
}

std::vector<glm::vec3> BlurredDome::blur(int level, ThreadPool& pool) const {
    static const std::array<glm::dvec2, lobe_points> lobe = make_lobe();
    const int columns = sharp_.columns() >> level, rows = sharp_.rows() >> level;
    // What the level before lacks: variances of lobes add up.
    const double sigma = 0.5 * first_blur_rad * std::exp2(level);
    const double before = level == 1 ? 0 : sigma / 2;
    const double rest = std::sqrt(sigma * sigma - before * before);
    std::vector<glm::vec3> out(static_cast<std::size_t>(columns * rows));
    for_rows(pool, rows, [&](int y) {
        // A lobe is the same all around: where its points lie is found once a row.
        const glm::dvec3 middle = sharp_.direction_at(0.5 / columns, (y + 0.5) / rows);
        const glm::dvec3 aside = glm::normalize(glm::cross(middle, glm::dvec3(0, 0, 1)));
        const glm::dvec3 up = glm::cross(aside, middle);
        std::array<DomePlace, lobe_points> places;
        std::transform(lobe.begin(), lobe.end(), places.begin(), [&](const glm::dvec2& point) {
            const glm::dvec2 at = rest * point;
            const double angle = glm::length(at), turned = std::min(angle, pi);
            const glm::dvec3 lean = (aside * at.x + up * at.y) / angle;
            return sharp_.place(middle * std::cos(turned) + lean * std::sin(turned));
        });
        for (int x = 0; x < columns; ++x) {
            const double turn = static_cast<double>(x) / columns;
            glm::dvec3 sum(0);
            for (const DomePlace& place : places)
                sum += sample_level(level - 1, {place.around + turn, place.from_horizon});
            out[static_cast<std::size_t>(y * columns + x)] = glm::vec3(sum / double{lobe_points});
        }
    });
    return out;
}

glm::dvec3 BlurredDome::sample(const glm::dvec3& direction, double blur_rad) const {
    const DomePlace place = sharp_.place(direction);
    const double share = blur_rad / first_blur_rad;
    const double level = std::clamp(share < 1 ? share : 1 + std::log2(share), 0.0, levels - 1.0);
    const int low = std::min(static_cast<int>(level), levels - 2);
    return glm::mix(sample_level(low, place), sample_level(low + 1, place), level - low);
}

} // namespace seaway::client
