// SPDX-License-Identifier: Apache-2.0
// What the air between an eye and a point lets through, by few exponentials: what shaders do a pixel.
#pragma once

#include "client/view/sky/atmosphere.h"

namespace seaway::client {

/// Transmittance over a distance from a height along a direction, towards a point near the sea or at a
/// cloud, by colour: molecules and aerosol, four nodes that lie close together at the lower end. Ozone lies above.
/// Within 1 % of the integral for heights up to 20 km.
glm::dvec3 air_left(const Air& air, double height_m, double distance_m, double direction_z);

} // namespace seaway::client
