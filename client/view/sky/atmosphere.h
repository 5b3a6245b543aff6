// SPDX-License-Identifier: Apache-2.0
// Atmosphere: the air above the sea, as a medium that scatters and absorbs light.
//
// Three parts after Hillaire 2020 ("A Scalable and Production Ready Sky and Atmosphere Rendering
// Technique"): molecules (Rayleigh), aerosol (Mie) and ozone, by the spectra of Bruneton 2017 ("A
// Qualitative and Quantitative Evaluation of 8 Clear Sky Models", demo.cc). Aerosol is given by the
// visibility at sea level.
//
// Light is computed at three wavelengths, 610, 550 and 445 nm, as shares of the sun's light outside the
// air, and becomes a colour at the end (sunlight_klx). With 680, 550, 440 nm taken for red, green and blue,
// as both papers have it, ozone takes of red a third of what it takes of green, and twilight is purple.
//
// A value; pure functions; heights in metres above the mean sea, coefficients per metre.
#pragma once

#include <glm/glm.hpp>

#include "base/result.h"

namespace seaway::client {

/// Mean radius of the earth (IUGG).
inline constexpr double earth_radius_m = 6371e3;

struct Atmosphere {
    double planet_radius_m = earth_radius_m;
    double thickness_m = 100e3; ///< Hillaire 2020: 6360 to 6460 km

    glm::dvec3 rayleigh_scattering_per_m{8.960e-6, 13.558e-6, 31.637e-6}; ///< at the sea
    double rayleigh_scale_m = 8000;

    /// Distance at which 2 % of contrast is left (Koschmieder), at 550 nm. 40 km is an optical depth
    /// of aerosol of 0.10, the mean over the oceans (Smirnov 2009, Maritime Aerosol Network: 0.11 at
    /// 500 nm).
    double visibility_m = 40e3;
    double aerosol_scale_m = 1200;
    double aerosol_albedo = 0.9;    ///< share of its extinction that is scattering; Bruneton 2017
    double aerosol_asymmetry = 0.8; ///< of the phase function of Cornette and Shanks 1992
    double aerosol_exponent = 0.6;  ///< of wavelength (Angstrom); Smirnov 2009 over oceans

    glm::dvec3 ozone_absorption_per_m{2.505e-6, 1.771e-6, 0.085e-6}; ///< densest; 300 DU
    double ozone_centre_m = 25e3;
    double ozone_half_width_m = 15e3; ///< of its tent

    double ground_albedo = 0.06; ///< the sea's under a mean sky (Payne 1972)

    bool operator==(const Atmosphere&) const = default;
};

inline constexpr double visibility_min_m = 200;
inline constexpr double visibility_max_m = 280e3; ///< air without aerosol has 288 km

/// The colour, linear sRGB in klx, of what is left of the sun's light: shares at the three wavelengths, 1
/// outside the air, which is 128 klx of white: eyes are adapted to daylight. A fit to spectra of 47 bands (sun and ozone of Bruneton 2017, eyes of
/// CIE 1931 after Wyman 2013) after thousand and a half ways through air, haze and ozone, where it is
/// right within 3 % of the brightest channel, 10 % of a setting sun; what lies outside of sRGB is cut.
glm::dvec3 sunlight_klx(const glm::dvec3& shares);

/// What a metre of the medium does to light.
struct Medium {
    glm::dvec3 rayleigh_per_m; ///< scattered
    glm::dvec3 aerosol_per_m;  ///< scattered
    glm::dvec3 extinction_per_m;
};

/// An Atmosphere with what is computed of it once.
class Air : public Atmosphere {
  public:
    explicit Air(const Atmosphere& atmosphere);
    /// At a height of 0 .. thickness_m.
    Medium at(double height_m) const;
    /// Of the aerosol, at the sea, by wavelength.
    const glm::dvec3& aerosol_extinction_per_m() const { return aerosol_extinction_per_m_; }
    /// Extinction at the sea by colour, of thin air: what the short ways over the sea need.
    glm::dvec3 rayleigh_rgb_per_m() const;
    glm::dvec3 aerosol_rgb_per_m() const;

  private:
    glm::dvec3 aerosol_extinction_per_m_;
};

/// Share of scattered light a steradian, by the cosine of the angle of deflection.
double rayleigh_phase(double cosine);
double aerosol_phase(double asymmetry, double cosine);

/// A ray from a height, by the cosine of its zenith angle.
struct Ray {
    double radius_m; ///< of its start, from the planet's centre
    double cosine;
};
Ray ray_from(const Atmosphere& air, double height_m, double zenith_cosine);
/// Does it meet the sea?
bool meets_sea(const Atmosphere& air, const Ray& ray);
/// To the sea or to the top of the air; 0 if neither lies ahead.
double length_m(const Atmosphere& air, const Ray& ray);
/// Angle by which the horizon lies below the level, rad.
double dip_rad(const Atmosphere& air, double height_m);
/// From the planet's centre, after a distance.
double radius_after_m(const Ray& ray, double distance_m);
/// Height above the sea after a distance; not below 0.
double height_after_m(const Atmosphere& air, const Ray& ray, double distance_m);

} // namespace seaway::client
