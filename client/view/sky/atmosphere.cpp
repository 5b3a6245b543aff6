// SPDX-License-Identifier: Apache-2.0
#include "client/view/sky/atmosphere.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace seaway::client {

namespace {

using std::numbers::pi;
const glm::dvec3 wavelengths_nm(610, 550, 445);
/// Columns: what each wavelength adds to red, green and blue, klx.
const glm::dmat3 klx_of_shares(glm::dvec3(184.14, -19.397, -14.029),
                               glm::dvec3(-56.811, 149.747, 13.660),
                               glm::dvec3(0.671, -2.350, 128.369));

} // namespace

glm::dvec3 sunlight_klx(const glm::dvec3& shares) {
    return glm::max(klx_of_shares * shares, glm::dvec3(0));
}

Air::Air(const Atmosphere& atmosphere) : Atmosphere(atmosphere) {
    const double all = std::log(50.0) / visibility_m; // 2 % = 1/50
    const double aerosol = std::max(all - rayleigh_scattering_per_m.g, 0.0);
    aerosol_extinction_per_m_ =
        aerosol * glm::pow(wavelengths_nm / 550.0, glm::dvec3(-aerosol_exponent));
}

Medium Air::at(double height_m) const {
    const glm::dvec3 rayleigh = rayleigh_scattering_per_m * std::exp(-height_m / rayleigh_scale_m);
    const glm::dvec3 aerosol = aerosol_extinction_per_m_ * std::exp(-height_m / aerosol_scale_m);
    const double tent = std::max(0.0, 1 - std::abs(height_m - ozone_centre_m) / ozone_half_width_m);
    return {rayleigh, aerosol_albedo * aerosol, rayleigh + aerosol + ozone_absorption_per_m * tent};
}

glm::dvec3 Air::rayleigh_rgb_per_m() const {
    return sunlight_klx(rayleigh_scattering_per_m) / sunlight_klx(glm::dvec3(1));
}

glm::dvec3 Air::aerosol_rgb_per_m() const {
    return sunlight_klx(aerosol_extinction_per_m_) / sunlight_klx(glm::dvec3(1));
}

double rayleigh_phase(double cosine) {
    return 3 / (16 * pi) * (1 + cosine * cosine);
}

double aerosol_phase(double asymmetry, double cosine) {
    const double g = asymmetry;
    const double base = 1 + g * g - 2 * g * cosine;
    return 3 / (8 * pi) * (1 - g * g) * (1 + cosine * cosine) /
           ((2 + g * g) * base * std::sqrt(base));
}

Ray ray_from(const Atmosphere& air, double height_m, double zenith_cosine) {
    return {air.planet_radius_m + height_m, zenith_cosine};
}

bool meets_sea(const Atmosphere& air, const Ray& ray) {
    const double r = ray.radius_m, edge = air.planet_radius_m;
    return ray.cosine < 0 && r * r * (ray.cosine * ray.cosine - 1) + edge * edge >= 0;
}

double length_m(const Atmosphere& air, const Ray& ray) {
    const double r = ray.radius_m, along = r * ray.cosine;
    const bool sea = meets_sea(air, ray);
    const double edge = air.planet_radius_m + (sea ? 0 : air.thickness_m);
    const double root = std::sqrt(std::max(along * along - r * r + edge * edge, 0.0));
    return std::max(0.0, sea ? -along - root : -along + root);
}

double dip_rad(const Atmosphere& air, double height_m) {
    return std::acos(air.planet_radius_m / (air.planet_radius_m + std::max(height_m, 0.0)));
}

double radius_after_m(const Ray& ray, double distance_m) {
    const double r = ray.radius_m;
    return std::sqrt(r * r + distance_m * (distance_m + 2 * r * ray.cosine));
}

double height_after_m(const Atmosphere& air, const Ray& ray, double distance_m) {
    return std::max(radius_after_m(ray, distance_m) - air.planet_radius_m, 0.0);
}

} // namespace seaway::client
