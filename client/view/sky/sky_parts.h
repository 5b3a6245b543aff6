// SPDX-License-Identifier: Apache-2.0
// The pieces that SkyMaker makes a sky of. Pure functions; thread-safe but for the pool.
#pragma once

#include <memory>
#include <vector>

#include "client/view/sky/blurred_dome.h"
#include "client/view/sky/clouds.h"
#include "client/view/sky/sky_view.h"

namespace seaway::client {

/// Airglow, zodiacal light and stars too faint to be drawn, above the air, kcd/m2. A fifth of it is lost on the way to the
/// sea, where the zenith of a dark clear sky has 22 magnitudes a square arc second, 1.7e-4 cd/m2 (Falchi 2016, Science
/// Advances 2, e1600377; Patat 2003 has 21.6 in a year of many sunspots).
inline const glm::dvec3 airglow = 2.15e-7 * glm::dvec3(0.77, 1.05, 1.18);

/// What a dome sends to the level, klx.
glm::dvec3 level_irradiance(const Dome& dome);

/// Views of the air from one height under sun and moon, and their strengths; no moon: null.
struct Lit {
    std::shared_ptr<const SkyView> sun, moon;
    double sun_strength = 0, moon_strength = 0;
};

/// A dome around a height: sky with the glow of the night, and the source of the air below the horizon.
/// below: the eye is below the clouds, in air that they shade.
Dome clear_dome(const Lit& lit, const AirTables& air, const CloudLayer& clouds, bool below,
                ThreadPool& pool);
/// A dome at the sea with clouds before it.
Dome with_clouds(Dome dome, const CloudLayer& layer, const std::vector<glm::vec2>& noise,
                 const AirTables& air, ThreadPool& pool);
/// Below the horizon: what the sea sends, of the sky that it mirrors and of its body. down: what falls on
/// it, klx. Its body is north_sea's, whatever the type of the water.
void lay_sea(Dome& dome, const glm::dvec3& down_klx, ThreadPool& pool);

/// Texels of all layers and mips, [mip][layer][y][x][rgba]: the blurred sea's, the eye's, the noise's;
/// means where nothing is looked up.
std::vector<float> picture_of(const BlurredDome& sea, const Dome& eye,
                              const std::vector<glm::vec2>& noise);

} // namespace seaway::client
