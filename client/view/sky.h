// SPDX-License-Identifier: Apache-2.0
// A clear sky for a height of the sun: radiance by direction, sun and sky light on the sea.
//
// Exact single scattering in a plane-parallel atmosphere seen from its bottom: with the air masses
// m_v of the view and m_s of the sun and vertical optical depth tau,
//     L = E P m_v (exp(-tau m_s) - exp(-tau m_v)) / (m_v - m_s),
// air masses after Kasten and Young 1989 (38 at the horizon, which stands for the curved earth),
// plus a diffuse part for light scattered more often. Rayleigh and aerosol depths at 680, 550, 440
// nm; ozone takes part in the light of the sun.
//
// Light is in klx and kcd/m2: outside the atmosphere the sun gives 128 klx. Immutable; thread-safe.
#pragma once

#include <vector>

#include <glm/glm.hpp>

namespace seaway::client {

/// Where the sun stands at this hour of solar time, on the day of equinox at 45 degrees north:
/// rises in the east at 6, 45 degrees high in the south at 12, sets in the west at 18. Unit vector,
/// local frame.
glm::dvec3 sun_direction(double time_of_day_h);

class Sky {
  public:
    explicit Sky(const glm::dvec3& sun_direction);

    const glm::dvec3& sun_direction() const { return sun_direction_; }
    /// What arrives at the sea, on a plane normal to the beam, klx.
    const glm::dvec3& sun_irradiance() const { return sun_irradiance_; }
    /// What the sky without the disk of the sun sends to a horizontal plane, klx.
    const glm::dvec3& sky_irradiance() const { return sky_irradiance_; }
    /// Elevation 0 .. pi/2, azimuth from the sun 0 .. pi.
    glm::dvec3 radiance(double elevation_rad, double azimuth_from_sun_rad) const;

    /// Radiance of a white sheet that lies on the sea, kcd/m2: the middle of what light there is.
    double white_radiance() const;

    static constexpr double sun_radius_rad = 0.00465;
    static constexpr int map_width = 128;  ///< azimuth from the sun
    static constexpr int map_height = 128; ///< square root of elevation, row 0: the horizon
    /// radiance() as a map for shaders/view/sky.glsl, all mips, [mip][y][x][rgba].
    std::vector<float> map() const;

  private:
    glm::dvec3 single_scattering(double elevation_rad, double azimuth_from_sun_rad) const;

    glm::dvec3 sun_direction_;
    double sun_elevation_rad_; ///< of the light; not below the horizon
    double twilight_;          ///< 1 by day, falls as the sun sinks
    glm::dvec3 sun_irradiance_;
    glm::dvec3 sky_irradiance_{0.0};
};

} // namespace seaway::client
