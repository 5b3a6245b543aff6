// SPDX-License-Identifier: Apache-2.0
// Light that the air scatters towards an eye, of a sun of illuminance 1 above the air.
//
// Single scattering is integrated along the ray; light scattered twice and more comes from a table of
// 32 x 32 by height and height of the sun (Hillaire 2020, section 5.5: isotropic beyond the first time,
// the same medium all around, a geometric series); in dense air, where no place is like the next, by two streams
// (two_stream.h). Radiance is per unit of the sun's illuminance: what
// is strong or coloured of the sun is multiplied last, so all is linear in it.
//
// Immutable and thread-safe. AirTables take 100 ms of CPU, which threads share; they hang on the medium alone.
#pragma once

#include <vector>

#include "client/view/sky/air_way.h"
#include "client/view/sky/transmittance.h"

namespace seaway::client {

/// Radius of the discs of sun and moon, as tables see them.
inline constexpr double disc_radius_rad = 0.00465;

class MultipleScattering {
  public:
    MultipleScattering(const Air& air, const TransmittanceTable& transmittance, ThreadPool& pool);

    /// Radiance that a scatterer at this height meets from all around, already averaged over directions,
    /// with what is scattered again.
    glm::dvec3 at(double height_m, double sun_cosine) const;

    static constexpr int size = 32;
    /// [height][sun], from the sea up, from the sun below to overhead.
    const std::vector<glm::dvec3>& texels() const { return table_; }

  private:
    double thickness_m_;
    std::vector<glm::dvec3> table_; ///< [height][sun]
};

/// What a scatterer sends out again of light from all around, and what leaves the air or the sea, on
/// average over all directions: of light that nothing absorbs they add up to 1 (the furnace test).
struct Transfer {
    glm::dvec3 lit;       ///< by the sun, scattered once and by the sea
    glm::dvec3 scattered; ///< share that air sends back (f_ms of the paper)
    glm::dvec3 absorbed;
    glm::dvec3 passed; ///< share that comes from beyond the air, or from the sea if white_sea
};
/// Under each of these suns.
std::vector<Transfer> transfers_at(const Air& air, const TransmittanceTable& transmittance,
                                   double height_m, const std::vector<double>& sun_cosines);

struct AirTables {
    explicit AirTables(const Atmosphere& atmosphere, ThreadPool& pool);
    Air air;
    TransmittanceTable transmittance;
    MultipleScattering multiple;
};

/// Optical depth by colour of the air above a height, straight up: a number above 0.
glm::dvec3 depth_above(const AirTables& tables, double height_m);

/// Air between an eye and a point.
struct AirLight {
    glm::dvec3 radiance; ///< sent towards the eye
    glm::dvec3 transmittance;
};

inline constexpr int view_steps = 28;

/// Along a way in a direction, whose angle with the sun has this cosine; the sun's height is at the start of the way.
glm::dvec3 air_radiance(const AirTables& tables, const AirWay& way, double to_sun_cosine,
                        double sun_cosine);

/// From a height along a unit direction (up is z) for a distance, 0 .. length_m(). Twice the steps where
/// the ray has its lowest point on the way.
AirLight air_light(const AirTables& tables, double height_m, const glm::dvec3& direction,
                   const glm::dvec3& to_sun, double distance_m, int steps = view_steps);
/// The same without light that was scattered more than once; for tests.
AirLight single_scattering(const AirTables& tables, double height_m, const glm::dvec3& direction,
                           const glm::dvec3& to_sun, double distance_m, int steps);

} // namespace seaway::client
