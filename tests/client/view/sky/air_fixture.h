// SPDX-License-Identifier: Apache-2.0
// Tables of the default air, made once for all tests of a program; other air is made where it is asked.
#pragma once

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "client/view/sky/scattering.h"

namespace seaway::client {

inline constexpr double air_pi = std::numbers::pi;
inline constexpr double air_degree = air_pi / 180;

inline ThreadPool& air_pool() {
    static ThreadPool pool;
    return pool;
}
inline const AirTables& clear_air() {
    static const AirTables tables(Atmosphere{}, air_pool());
    return tables;
}
/// Towards an elevation, in the east.
inline glm::dvec3 towards(double elevation_deg, double azimuth_deg = 0) {
    const double e = elevation_deg * air_degree, a = azimuth_deg * air_degree;
    return {std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)};
}
inline double whole_length_m(const Atmosphere& air, double height_m, const glm::dvec3& direction) {
    return length_m(air, ray_from(air, height_m, direction.z));
}

} // namespace seaway::client
