// SPDX-License-Identifier: Apache-2.0
#include "client/view/water_optics.h"

#include <algorithm>
#include <cmath>

#include "client/view/sky/eye_curves.h"
#include "client/view/sky/look.h"

namespace seaway::client {

namespace {

/// Jerlov 1976, table XXVII (p. 135): types I to 9C, 1/m. Public transcriptions differ in one number, type I at
/// 400 nm: 0.027, taken here, in one 0.028.
constexpr std::array<WaterSpectrum, 10> jerlov_per_m{{
    {0.027, 0.022, 0.019, 0.018, 0.027, 0.043, 0.063, 0.089, 0.235, 0.305, 0.36, 0.42, 0.56},
    {0.038, 0.031, 0.026, 0.025, 0.032, 0.048, 0.067, 0.094, 0.24, 0.31, 0.37, 0.43, 0.57},
    {0.051, 0.042, 0.036, 0.033, 0.042, 0.054, 0.072, 0.099, 0.245, 0.315, 0.375, 0.435, 0.58},
    {0.096, 0.081, 0.068, 0.062, 0.07, 0.076, 0.089, 0.115, 0.26, 0.335, 0.4, 0.465, 0.61},
    {0.185, 0.16, 0.135, 0.116, 0.115, 0.116, 0.12, 0.148, 0.295, 0.375, 0.445, 0.52, 0.66},
    {0.51, 0.36, 0.25, 0.17, 0.14, 0.13, 0.12, 0.15, 0.3, 0.37, 0.45, 0.51, 0.65},
    {0.78, 0.54, 0.39, 0.29, 0.22, 0.2, 0.19, 0.21, 0.33, 0.4, 0.46, 0.56, 0.71},
    {1.1, 0.78, 0.56, 0.43, 0.36, 0.31, 0.3, 0.33, 0.4, 0.48, 0.54, 0.65, 0.8},
    {1.6, 1.2, 0.89, 0.71, 0.58, 0.49, 0.46, 0.46, 0.48, 0.54, 0.63, 0.78, 0.92},
    {2.4, 1.9, 1.6, 1.23, 0.99, 0.78, 0.63, 0.58, 0.6, 0.65, 0.76, 0.92, 1.1},
}};
/// Scattering of pure sea water (Morel 1974), 1/m.
constexpr WaterSpectrum pure_scattering_per_m{0.0076, 0.0058, 0.0045, 0.0036, 0.0029,
                                              0.0023, 0.0019, 0.0016, 0.0014, 0.0011,
                                              0.0010, 0.0008, 0.0007};
constexpr std::size_t green_band = 6; ///< 550 nm

/// North_sea, by eye: what comes out of crests and of bubbles; of deep water: water_reflectance.
const glm::dvec3 north_sea_crest(0.012, 0.055, 0.048);
const glm::dvec3 north_sea_bubbles(0.10, 0.32, 0.30);

// Those colours of crests and bubbles are what type III leaves of white after so far, within an eighth. So for
// other waters.
constexpr double crest_white = 0.107, crest_path_m = 5.5;
constexpr double bubbles_white = 0.53, bubbles_path_m = 4.2;
constexpr double colour_path_m = 4;
/// Light that lost all but one hue is outside of sRGB. On its way there a colour goes through 0, where a logarithm
/// says nothing of water: attenuation is taken where it has come down to so much of the brightest.
constexpr double least_of_brightest = 0.05;

constexpr double first_nm = 400, step_nm = 5;
constexpr std::size_t seen_bands = 61;

/// Planck's law at 5778 K, in parts of what it is at 550 nm.
double daylight(double nm) {
    constexpr double hc_over_kt_nm = 1.4387769e7 / 5778;
    const auto law = [](double at) { return std::pow(at, -5) / std::expm1(hc_over_kt_nm / at); };
    return law(nm) / law(550);
}

double between(const WaterSpectrum& spectrum, double nm) {
    const double at = std::clamp((nm - water_band_nm(0)) / 25, 0.0, water_bands - 1.0);
    const std::size_t low = std::min(static_cast<std::size_t>(at), water_bands - 2);
    const double t = at - static_cast<double>(low);
    return (1 - t) * spectrum[low] + t * spectrum[low + 1];
}

using Seen = std::array<glm::dvec3, seen_bands>;

Seen seen_of_daylight() {
    Seen all{};
    for (std::size_t i = 0; i < seen_bands; ++i) {
        const double nm = first_nm + step_nm * static_cast<double>(i);
        all[i] = daylight(nm) * eye_curves(nm);
    }
    return all;
}

/// Sum over what eyes see, below 0 outside of sRGB; `share` of a wavelength in nm.
template <class F>
glm::dvec3 colour(const F& share) {
    static const Seen seen = seen_of_daylight();
    glm::dvec3 sum(0), white(0);
    for (std::size_t i = 0; i < seen_bands; ++i) {
        sum += share(first_nm + step_nm * static_cast<double>(i)) * seen[i];
        white += seen[i];
    }
    return sum / white;
}

bool tells_of_water(const glm::dvec3& left, int c) {
    return left[c] > 0 && left[c] >= least_of_brightest * std::max({left.r, left.g, left.b});
}

/// The longest way within far_m of which `tells` holds, which it does of short ones.
template <class F>
double longest_m(double far_m, const F& tells) {
    constexpr int halvings = 24; // to a millimetre of the deepest ocean
    double near_m = 0;
    for (int i = 0; i < halvings; ++i) {
        const double middle_m = 0.5 * (near_m + far_m);
        (tells(middle_m) ? near_m : far_m) = middle_m;
    }
    return near_m;
}

/// Left of white by a way through water.
glm::dvec3 left_after(const glm::dvec3& attenuation_per_m, double path_m) {
    return glm::exp(-attenuation_per_m * path_m);
}

} // namespace

WaterSpectrum diffuse_attenuation_per_m(sea::WaterType type) {
    const sea::WaterType like = type == sea::WaterType::north_sea ? sea::WaterType::jerlov_3 : type;
    return jerlov_per_m[static_cast<std::size_t>(like) - 1];
}

double pigment_mgpm3(double attenuation_550_per_m) {
    return std::pow(std::max(attenuation_550_per_m - 0.0640, 0.0) / 0.0410, 1 / 0.650);
}

double particle_scattering_per_m(double pigment_mgpm3) {
    return 0.30 * std::pow(pigment_mgpm3, 0.62);
}

WaterSpectrum reflectance_below(sea::WaterType type) {
    const WaterSpectrum attenuation_per_m = diffuse_attenuation_per_m(type);
    const double pigment = pigment_mgpm3(attenuation_per_m[green_band]);
    const double b = particle_scattering_per_m(pigment);
    WaterSpectrum out{};
    for (std::size_t i = 0; i < water_bands; ++i) {
        const double back = pigment > 0 ? 0.002 + 0.02 * (0.5 - 0.25 * std::log10(pigment)) *
                                                      water_band_nm(green_band) / water_band_nm(i)
                                        : 0;
        const double ratio =
            0.33 * (pure_scattering_per_m[i] / 2 + b * back) / attenuation_per_m[i];
        double r = ratio;
        for (int step = 0; step < 50; ++step) // contracts by 3.25 R a step, R below a tenth
            r = ratio * (1 + 2.25 * r) / (0.90 * (1 - r));
        out[i] = r;
    }
    return out;
}

double reflectance_above(double below) {
    return 0.41 * below / (1 - 0.48 * below);
}

double floor_reflectance_above(double albedo) {
    return 0.52 * albedo / (1 - 0.48 * albedo);
}

glm::dvec3 colour_of(const WaterSpectrum& shares) {
    return glm::max(colour([&](double nm) { return between(shares, nm); }), glm::dvec3(0));
}

glm::dvec3 attenuation_rgb_per_m(sea::WaterType type, double path_m) {
    const WaterSpectrum per_m = diffuse_attenuation_per_m(type);
    const auto left = [&](double way_m) {
        return colour([&](double nm) { return std::exp(-way_m * between(per_m, nm)); });
    };
    const glm::dvec3 whole = left(path_m);
    glm::dvec3 out(0);
    for (int c = 0; c < 3; ++c)
        if (tells_of_water(whole, c)) {
            out[c] = -std::log(whole[c]) / path_m;
        } else {
            const double way_m = longest_m(
                path_m, [&](double middle_m) { return tells_of_water(left(middle_m), c); });
            out[c] = -std::log(left(way_m)[c]) / way_m;
        }
    return out;
}

double slant_of_attenuation(sea::WaterType type) {
    constexpr double slant = 1.18; ///< 45 degrees in air: 31.9 from the vertical in water
    return type == sea::WaterType::north_sea || type < sea::WaterType::coastal_1 ? 1 : slant;
}

WaterLook water_look(const sea::Water& water, double depth_m, double wave_m) {
    constexpr double matters = 1e-4; ///< of the luminance of deep water: one colour of it may be 0
    WaterLook look;
    const bool by_eye = water.type == sea::WaterType::north_sea;
    WaterSpectrum above = reflectance_below(water.type);
    for (double& value : above)
        value = reflectance_above(value);
    look.reflectance = by_eye ? water_reflectance : colour_of(above);
    const glm::dvec3 near = attenuation_rgb_per_m(water.type, crest_path_m);
    look.crest = by_eye ? north_sea_crest : crest_white * left_after(near, crest_path_m);
    look.bubbles = by_eye ? north_sea_bubbles : bubbles_white * left_after(near, bubbles_path_m);
    const bool has_floor = std::isfinite(depth_m);
    look.attenuation_per_m = attenuation_rgb_per_m(water.type, colour_path_m);
    look.floor_attenuation_per_m =
        has_floor ? attenuation_rgb_per_m(water.type, 2 * depth_m) : look.attenuation_per_m;
    for (int c = 0; c < 3; ++c)
        look.floor[c] = floor_reflectance_above(water.bottom_albedo[static_cast<std::size_t>(c)]);
    const double least_m = has_floor ? std::max(depth_m - wave_m, 0.0) : 0;
    const glm::dvec3 most = look.floor * left_after(look.floor_attenuation_per_m, 2 * least_m);
    look.floor_seen =
        has_floor &&
        glm::any(glm::greaterThan(most, glm::dvec3(matters * luminance_of(look.reflectance))));
    return look;
}

} // namespace seaway::client
