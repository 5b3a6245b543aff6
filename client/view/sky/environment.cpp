// SPDX-License-Identifier: Apache-2.0
#include "client/view/sky/environment.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "client/view/sky/look.h"
#include "client/view/sky/transmittance.h"
#include "shaders/shared/view.h"

namespace seaway::client {

namespace {

using std::numbers::pi;
/// A sun is so much brighter than the sky around it.
constexpr double sun_contrast = 10;
/// What is brighter than the sky within this angle of the brightest texel is sun: lenses spread it.
constexpr double sun_rad = 3 * pi / 180;
constexpr double around_rad = 6 * pi / 180; ///< sky: from there on to here
/// Of coarse pictures in texels: with its neighbours aslant, and with those around them.
constexpr double sun_texels = 1.5, around_texels = 3;
constexpr int samples_max = 8; ///< of a texel of the table, a side

/// Of the elevation of a row's upper edge.
double sine_at(const EnvironmentPicture& picture, int row) {
    return std::sin(pi * (0.5 - static_cast<double>(row) / picture.height));
}

/// That reach above the horizon.
int upper_rows(const EnvironmentPicture& picture) {
    return (picture.height + 1) / 2;
}

std::size_t brightest(const EnvironmentPicture& picture) {
    const auto upper =
        std::ptrdiff_t{picture.width} * upper_rows(picture); // a sun stands above the sea
    const auto most =
        std::max_element(picture.texels.begin(), picture.texels.begin() + upper,
                         [](const glm::vec3& a, const glm::vec3& b) {
                             return luminance_of(glm::dvec3(a)) < luminance_of(glm::dvec3(b));
                         });
    return static_cast<std::size_t>(most - picture.texels.begin());
}

/// Calls visit(texel, direction, steradians) for texels of the upper half within an angle of a direction.
template <class Visit>
void around(EnvironmentPicture& picture, const glm::dvec3& middle, double angle,
            const Visit& visit) {
    for (int y = 0; y < upper_rows(picture); ++y) {
        const double up = pi * (0.5 - (y + 0.5) / picture.height);
        if (std::abs(up - std::asin(std::clamp(middle.z, -1.0, 1.0))) > angle + pi / picture.height)
            continue;
        for (int x = 0; x < picture.width; ++x) {
            const glm::dvec3 direction = picture.direction(x, y);
            if (glm::length(direction - middle) < 2 * std::sin(angle / 2))
                visit(picture.texels[static_cast<std::size_t>(y * picture.width + x)], direction,
                      picture.upper_sr(y));
        }
    }
}

/// Takes the sun out of the picture.
void take_sun(EnvironmentPicture& picture, Environment& out) {
    const std::size_t at = brightest(picture);
    const auto width = static_cast<std::size_t>(picture.width);
    const glm::dvec3 middle =
        picture.direction(static_cast<int>(at % width), static_cast<int>(at / width));
    const double texel_rad = pi / picture.height;
    const double sun = std::min(std::max(sun_rad, sun_texels * texel_rad), pi);
    const double ring = std::min(std::max(around_rad, around_texels * texel_rad), pi);
    glm::dvec3 sky(0);
    double sky_sr = 0;
    around(picture, middle, ring,
           [&](const glm::vec3& texel, const glm::dvec3& direction, double sr) {
               if (glm::length(direction - middle) < 2 * std::sin(sun / 2))
                   return;
               sky += sr * glm::dvec3(texel);
               sky_sr += sr;
           });
    if (sky_sr == 0) // of fewer rows than a file has
        return;
    sky /= sky_sr;
    if (luminance_of(glm::dvec3(picture.texels[at])) <= sun_contrast * luminance_of(sky))
        return;
    glm::dvec3 towards(0);
    around(picture, middle, sun, [&](glm::vec3& texel, const glm::dvec3& direction, double sr) {
        const glm::dvec3 excess = glm::max(glm::dvec3(texel) - sky, glm::dvec3(0));
        out.sun_klx += sr * excess;
        towards += sr * luminance_of(excess) * direction;
        texel -= glm::vec3(excess);
    });
    out.to_sun = glm::normalize(towards);
}

/// Linear between texels; the picture goes round, and its poles are edges.
glm::dvec3 sample(const EnvironmentPicture& picture, const glm::dvec3& direction) {
    const double bearing = std::atan2(direction.x, direction.y);
    const double x = (0.5 + bearing / (2 * pi)) * picture.width - 0.5 + picture.width;
    const double up = std::asin(std::clamp(direction.z, -1.0, 1.0));
    const double y = std::clamp((0.5 - up / pi) * picture.height - 0.5, 0.0, picture.height - 1.0);
    const int x0 = static_cast<int>(x) % picture.width, x1 = (x0 + 1) % picture.width;
    const int y0 = static_cast<int>(y), y1 = std::min(y0 + 1, picture.height - 1);
    const auto texel = [&](int px, int py) {
        return glm::dvec3(picture.texels[static_cast<std::size_t>(py * picture.width + px)]);
    };
    const double fx = x - std::floor(x);
    return glm::mix(glm::mix(texel(x0, y0), texel(x1, y0), fx),
                    glm::mix(texel(x0, y1), texel(x1, y1), fx), y - y0);
}

glm::dvec3 turned(const glm::dvec3& direction, double clockwise_rad) {
    const double c = std::cos(clockwise_rad), s = std::sin(clockwise_rad);
    return {c * direction.x + s * direction.y, c * direction.y - s * direction.x, direction.z};
}

} // namespace

glm::dvec3 EnvironmentPicture::direction(int x, int y) const {
    const double bearing = 2 * pi * ((x + 0.5) / width - 0.5);
    const double up = pi * (0.5 - (y + 0.5) / height);
    return {std::cos(up) * std::sin(bearing), std::cos(up) * std::cos(bearing), std::sin(up)};
}

double EnvironmentPicture::texel_sr(int y) const {
    return 2 * pi / width * (sine_at(*this, y) - sine_at(*this, y + 1));
}

double EnvironmentPicture::upper_sr(int y) const {
    return 2 * pi / width *
           (std::max(sine_at(*this, y), 0.0) - std::max(sine_at(*this, y + 1), 0.0));
}

glm::dvec3 level_light(const EnvironmentPicture& picture) {
    glm::dvec3 sum(0);
    for (int y = 0; y < upper_rows(picture); ++y) {
        // The mean sine over the solid angle of what lies above the horizon is the middle of its edges' sines.
        const double sine = (sine_at(picture, y) + std::max(sine_at(picture, y + 1), 0.0)) / 2;
        for (int x = 0; x < picture.width; ++x)
            sum += picture.upper_sr(y) * sine *
                   glm::dvec3(picture.texels[static_cast<std::size_t>(y * picture.width + x)]);
    }
    return sum;
}

Environment environment_of(EnvironmentPicture picture, double turn_deg, ThreadPool& pool) {
    const double turn = turn_deg * pi / 180;
    Environment out;
    take_sun(picture, out);
    out.to_sun = turned(out.to_sun, turn);
    out.sky = Dome(shaders::sky_columns, shaders::sky_rows, 0, 0);
    Dome& dome = out.sky;
    const int across = std::clamp(picture.width / dome.columns() + 1, 1, samples_max);
    for_rows(pool, dome.rows() / 2, [&](int half) {
        const int y = dome.rows() / 2 + half;
        const double high = dome.direction_at(0, (y + 1.0) / dome.rows()).z;
        const double rows =
            std::abs(std::asin(high) - std::asin(dome.direction(0, y).z)) / pi * picture.height;
        const int up = std::clamp(static_cast<int>(2 * rows) + 1, 1, samples_max);
        for (int x = 0; x < dome.columns(); ++x) {
            glm::dvec3 sum(0);
            for (int i = 0; i < across; ++i)
                for (int j = 0; j < up; ++j) {
                    glm::dvec3 direction =
                        dome.direction_at((x + (i + 0.5) / across) / dome.columns(),
                                          (y + (j + 0.5) / up) / dome.rows());
                    // Of the horizon's own row, what lies above it.
                    direction.z = std::max(direction.z, pi / 2 / picture.height);
                    sum += sample(picture, turned(glm::normalize(direction), -turn));
                }
            dome.at(x, y) = glm::vec3(sum / double(across * up));
        }
    });
    for (int y = 0; y < dome.rows() / 2; ++y)
        for (int x = 0; x < dome.columns(); ++x)
            dome.at(x, y) = dome.at(x, dome.rows() / 2);
    return out;
}

} // namespace seaway::client
