// SPDX-License-Identifier: Apache-2.0
// What water of an optical type does to light: from spectra of attenuation to linear sRGB.
//
// Kd, the diffuse attenuation of daylight going down, is Jerlov's (Marine Optics, 1976, table XXVII). What comes back
// up is Morel's model (1988, J. Geophys. Res. 93, 10749; as 6S has it, Vermote 1997): just below the surface
//     R = 0.33 / u  bb / Kd,  u = 0.90 (1 - R) / (1 + 2.25 R)
//     bb = bw / 2 + b (0.002 + 0.02 (1/2 - log10(C) / 4) 550 nm / wavelength),  b = 0.30 C^0.62
// with bw the scattering of pure sea water and C the pigment with which his Kd(550 nm) = 0.064 + 0.041 C^0.65 is
// Jerlov's. Its b is that of Solonenko and Mobley (2015) within a quarter for coastal waters. Above the surface comes
// out 0.41 R / (1 - 0.48 R): 0.94 of daylight enters, radiance falls by n^2, and what comes up is brighter at the sides
// than in the middle (Q = 4; Morel and Gentili 1996), 0.48 of it is mirrored down again.
//
// How far to trust it: types I to 3C have the ratio of blue to green that satellites see at such a Kd(490 nm) (NASA's
// KD2S of 2009) within a third. Brightness hangs on particles and varies by a factor of 1.5 between waters of one type;
// coasts with mineral silt are two to five times as bright as 5C to 9C here, which are stained rather than muddy.
//
// Pure functions, up to 0.1 ms each; thread-safe.
#pragma once

#include <array>

#include <glm/glm.hpp>

#include "sea/basics/water_type.h"

namespace seaway::client {

inline constexpr std::size_t water_bands = 13; ///< 400, 425 .. 700 nm
constexpr double water_band_nm(std::size_t band) {
    return 400 + 25 * static_cast<double>(band);
}
using WaterSpectrum = std::array<double, water_bands>;

/// Kd, 1/m. Of north_sea: that of III.
WaterSpectrum diffuse_attenuation_per_m(sea::WaterType type);
/// Pigment of Morel's waters with this Kd at 550 nm, mg/m3.
double pigment_mgpm3(double attenuation_550_per_m);
/// b of Morel's particles at 550 nm, 1/m.
double particle_scattering_per_m(double pigment_mgpm3);
/// R: light going up over light going down, just below the surface of deep water.
WaterSpectrum reflectance_below(sea::WaterType type);
/// What leaves the water, of R below the surface; without what the surface mirrors at the angle of the eye.
double reflectance_above(double below);
/// The same of a sea floor, which sends light back evenly (Q = pi), right below the surface.
double floor_reflectance_above(double albedo);

/// Share of daylight as a colour: linear sRGB, 1 where nothing is lost; what lies outside of sRGB is cut at 0.
/// Eyes of CIE 1931 (Wyman 2013), a sun of 5778 K.
glm::dvec3 colour_of(const WaterSpectrum& shares);

/// Attenuation by colour, 1/m: exact for light that went so far, and near that. Of a colour of which less would be left than a
/// twentieth of the brightest, and on longer ways less than none, that of the way that leaves a twentieth. Does not jump
/// with the way, and is never above Kd's largest.
glm::dvec3 attenuation_rgb_per_m(sea::WaterType type, double path_m);

/// Way over depth of the daylight of which Jerlov's Kd is: 1 in oceans, measured with the sun in the zenith; his coastal types are
/// for 45 degrees (Jerlov 1976, as fig. 6.18 of Stewart's Introduction to Physical Oceanography has them).
double slant_of_attenuation(sea::WaterType type);

/// What shaders are told of water.
struct WaterLook {
    glm::dvec3 reflectance;             ///< of deep water, above the surface
    glm::dvec3 attenuation_per_m;       ///< of light under water, near the eye
    glm::dvec3 floor_attenuation_per_m; ///< of light that has been to the sea floor
    glm::dvec3 crest;                   ///< of light that shines through a crest, what comes out
    glm::dvec3 bubbles;                 ///< of light on water full of bubbles, likewise
    glm::dvec3 floor;        ///< of the sea floor, seen above the surface through no water
    bool floor_seen = false; ///< it changes what is seen
};
/// depth_m: still; may be infinite. wave_m: how far the surface may be above or below.
WaterLook water_look(const sea::Water& water, double depth_m, double wave_m);

} // namespace seaway::client
