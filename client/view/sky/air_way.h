// SPDX-License-Identifier: Apache-2.0
// AirWay: a ray through the air in steps, with all of it that hangs neither on the sun nor on the ray's azimuth. Rays of one
// height and zenith angle share it: a row of a table, a ring of directions, any number of suns.
//
// Values; thread-safe; valid as long as the table of transmittances. A step takes 90 ns of CPU.
#pragma once

#include <vector>

#include "client/view/sky/transmittance.h"

namespace seaway::client {

/// A piece of the ray, whose medium is taken for constant.
struct AirStep {
    double at_m;                  ///< its middle, from the start of the ray
    double height_m;              ///< of its middle
    double radius_m;              ///< the same from the planet's centre, as the ray has it
    glm::dvec3 rayleigh, aerosol; ///< what it scatters that arrives at the start: shares
    glm::dvec3 absorbed;          ///< what it absorbs, of what would arrive: shares
    TransmittanceAt light;        ///< by which a sun arrives there
    glm::dvec3 scattered() const { return rayleigh + aerosol; }
};

struct AirWay {
    Ray ray;
    double length_m;
    std::vector<AirStep> steps;
    glm::dvec3 passed; ///< share that arrives of what enters at its end

    /// Cosine of the sun's zenith angle at a step, by that at the start and that of the angle between ray and sun.
    double sun_cosine(const AirStep& step, double at_start, double to_ray) const {
        return (ray.radius_m * at_start + step.at_m * to_ray) / step.radius_m;
    }
};

/// For a distance, 0 .. length_m(). Steps are short where the ray is lowest; twice as many where that is on the way.
AirWay way_through(const Air& air, const TransmittanceTable& transmittance, const Ray& ray,
                   double distance_m, int steps);

} // namespace seaway::client
