// SPDX-License-Identifier: Apache-2.0
// Dispersion of surface waves: w^2 = (g k + s k^3) tanh(k d), s = surface tension / density.
//
// Accurate to rounding for k d from 1e-8 to infinity; depth_m may be infinite. No cosh, so nothing
// overflows (hard cases A6, A7). Pure functions; thread-safe.
#pragma once

#include "sea/basics/constants.h"
#include "sea/basics/time.h"

namespace seaway::sea {

struct Dispersion {
    double gravity_mps2 = gravity_default_mps2;
    double surface_tension_m3ps2 = surface_tension_default_m3ps2;
    double depth_m = deep_water_m;

    bool operator==(const Dispersion&) const = default;

    /// Angular frequency, rad/s; k >= 0 in rad/m. 0 at k = 0.
    double omega(double k_radpm) const;

    /// Group velocity d omega / d k, m/s; k > 0. At k = 0 its limit, sqrt(g d).
    double group_speed(double k_radpm) const;

    /// The k whose omega(k) this is, rad/m, to 1e-14 relative; omega >= 0. About 5 steps.
    double wavenumber(double omega_radps) const;
};

/// All that the frequencies of the waves of a sea follow from (mode_rate, sea/waves/realize.h).
struct WaveLaw {
    Dispersion dispersion = {};
    TimeUs loop_period_us = 0; ///< 0: never repeats

    bool operator==(const WaveLaw&) const = default;
};

/// Width over height of the orbit that water runs at the surface, coth(k d) (Airy; Dean and
/// Dalrymple 1991, 4): by so much a wave moves water further sideways than up and down. Exactly 1
/// above k d = 20. Below orbit_kd_min linear theory has ended and it grows no further, coth(0.05)
/// = 20.02. k > 0.
double orbit_aspect(double k_radpm, double depth_m);
/// By what share it grows for each 1/m that the inverse of the depth does: d ln coth(kd) / d(1/d) = 2 k d^2 / sinh(2 k d). Nothing where it stays as it is.
double orbit_growth_m(double k_radpm, double depth_m);
inline constexpr double orbit_kd_min = 0.05;

} // namespace seaway::sea
