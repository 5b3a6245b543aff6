// SPDX-License-Identifier: Apache-2.0
// Physical constants and their defaults. SI units.
#pragma once

#include <limits>
#include <numbers>

namespace seaway::sea {

inline constexpr double pi = std::numbers::pi;
inline constexpr double degrees_per_radian = 180.0 / pi;
inline constexpr double two_pi = 2.0 * std::numbers::pi;

inline constexpr double gravity_default_mps2 = 9.81;
/// sigma / rho = 0.074 N/m over 1000 kg/m3 (physics.md section 3).
inline constexpr double surface_tension_default_m3ps2 = 7.4e-5;
inline constexpr double deep_water_m = std::numeric_limits<double>::infinity();

/// Wind at 19.5 m over wind at 10 m: the neutral log law with Cd = 1.3e-3,
/// 1 + sqrt(Cd)/0.4 ln 1.95. (1.026, often printed, is the same with log10.)
inline constexpr double wind_19m5_over_10m = 1.06019733;

} // namespace seaway::sea
