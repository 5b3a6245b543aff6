// SPDX-License-Identifier: Apache-2.0
#include "client/view/sky.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace seaway::client {

namespace {

constexpr double pi = std::numbers::pi;

// Vertical optical depths: Rayleigh after Bodhaine 1999, clean marine aerosol, ozone 300 DU.
const glm::dvec3 rayleigh_depth(0.042, 0.098, 0.245);
const glm::dvec3 aerosol_depth(0.045, 0.050, 0.056);
const glm::dvec3 ozone_depth(0.016, 0.030, 0.001);
constexpr double aerosol_albedo = 0.95;
constexpr double aerosol_asymmetry = 0.76;
const glm::dvec3 irradiance_above_air = 128.0 * glm::dvec3(1.04, 1.0, 0.95);
const glm::dvec3 night_radiance = 2e-6 * glm::dvec3(0.6, 0.8, 1.3); // airglow and stars

double air_mass(double elevation_rad) {
    const double degrees = elevation_rad * 180 / pi;
    return 1 / (std::sin(elevation_rad) + 0.50572 * std::pow(degrees + 6.07995, -1.6364));
}

double rayleigh_phase(double cosine) {
    return 3 / (16 * pi) * (1 + cosine * cosine);
}

double aerosol_phase(double cosine) { // Cornette and Shanks 1992
    constexpr double g = aerosol_asymmetry;
    return 3 / (8 * pi) * (1 - g * g) * (1 + cosine * cosine) /
           ((2 + g * g) * std::pow(1 + g * g - 2 * g * cosine, 1.5));
}

} // namespace

glm::dvec3 sun_direction(double time_of_day_h) {
    const double hour_angle = (time_of_day_h - 12) * pi / 12;
    const double latitude = pi / 4;
    // Declination 0: the sun moves on the celestial equator.
    return {-std::sin(hour_angle), -std::cos(hour_angle) * std::sin(latitude),
            std::cos(hour_angle) * std::cos(latitude)};
}

Sky::Sky(const glm::dvec3& direction) : sun_direction_(glm::normalize(direction)) {
    const double elevation = std::asin(std::clamp(sun_direction_.z, -1.0, 1.0));
    sun_elevation_rad_ = std::max(elevation, 0.0);
    // Twilight fades by a factor of ten about every 2.6 degrees (Rozenberg 1966).
    twilight_ = std::exp(std::min(elevation, 0.0) * 180 / pi * 0.9);
    const double disk_above = std::clamp(elevation / sun_radius_rad * 0.5 + 0.5, 0.0, 1.0);
    const glm::dvec3 depth = rayleigh_depth + aerosol_depth + ozone_depth;
    sun_irradiance_ =
        disk_above * irradiance_above_air * glm::exp(-depth * air_mass(sun_elevation_rad_));

    constexpr int steps = 32;
    for (int i = 0; i < steps; ++i)
        for (int j = 0; j < steps; ++j) {
            const double sine = (i + 0.5) / steps; // equal steps of sine: equal solid angles
            sky_irradiance_ += radiance(std::asin(sine), (j + 0.5) * pi / steps) * sine *
                               (2 * pi / (steps * steps));
        }
}

glm::dvec3 Sky::single_scattering(double elevation_rad, double azimuth_from_sun_rad) const {
    const double view_mass = air_mass(elevation_rad);
    const double sun_mass = air_mass(sun_elevation_rad_);
    const double cosine =
        std::sin(elevation_rad) * std::sin(sun_elevation_rad_) +
        std::cos(elevation_rad) * std::cos(sun_elevation_rad_) * std::cos(azimuth_from_sun_rad);
    const glm::dvec3 depth = rayleigh_depth + aerosol_depth;
    const glm::dvec3 phase = (rayleigh_depth * rayleigh_phase(cosine) +
                              aerosol_albedo * aerosol_depth * aerosol_phase(cosine)) /
                             depth;
    const double difference = view_mass - sun_mass;
    const glm::dvec3 path =
        std::abs(difference) < 1e-3
            ? view_mass * depth * glm::exp(-depth * sun_mass)
            : view_mass * (glm::exp(-depth * sun_mass) - glm::exp(-depth * view_mass)) / difference;
    return irradiance_above_air * glm::exp(-ozone_depth * sun_mass) * phase * path;
}

glm::dvec3 Sky::radiance(double elevation_rad, double azimuth_from_sun_rad) const {
    const glm::dvec3 depth = rayleigh_depth + aerosol_depth;
    const double sun_mass = air_mass(sun_elevation_rad_);
    // Half of what the beam loses comes down and is scattered again on the way to the eye.
    const glm::dvec3 diffuse = 0.5 / sun_mass * irradiance_above_air *
                               (1.0 - glm::exp(-depth * sun_mass)) *
                               glm::exp(-ozone_depth * sun_mass);
    const glm::dvec3 again = diffuse / pi * (1.0 - glm::exp(-depth * air_mass(elevation_rad)));
    return twilight_ * (single_scattering(elevation_rad, azimuth_from_sun_rad) + again) +
           night_radiance;
}

double Sky::white_radiance() const {
    const glm::dvec3 light = sky_irradiance_ + sun_irradiance_ * std::max(sun_direction_.z, 0.0);
    return glm::dot(light, glm::dvec3(0.2126, 0.7152, 0.0722)) / pi;
}

std::vector<float> Sky::map() const {
    std::vector<float> texels;
    int width = map_width, height = map_height;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double root = static_cast<double>(y) / (height - 1);
            const glm::dvec3 value = radiance(root * root * pi / 2, x * pi / (width - 1));
            for (int c = 0; c < 3; ++c)
                texels.push_back(static_cast<float>(value[c]));
            texels.push_back(1);
        }
    std::size_t above = 0;
    while (width > 1 || height > 1) {
        const std::size_t here = texels.size();
        const int parent_width = width;
        width = std::max(1, width / 2);
        height = std::max(1, height / 2);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                for (int c = 0; c < 4; ++c) {
                    const auto at = [&](int px, int py) {
                        return texels[above +
                                      static_cast<std::size_t>(4 * (py * parent_width + px) + c)];
                    };
                    texels.push_back(0.25f * (at(2 * x, 2 * y) + at(2 * x + 1, 2 * y) +
                                              at(2 * x, 2 * y + 1) + at(2 * x + 1, 2 * y + 1)));
                }
        above = here;
    }
    return texels;
}

} // namespace seaway::client
