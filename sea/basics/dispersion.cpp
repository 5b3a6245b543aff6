// SPDX-License-Identifier: Apache-2.0
#include "sea/basics/dispersion.h"

#include <algorithm>
#include <cmath>

namespace seaway::sea {

namespace {

/// Beyond this k d, tanh is 1 to the last bit and every term with sech^2 is below 1e-15.
constexpr double deep_kd = 20.0;

/// 1 - tanh^2 y without cancellation.
double sech_squared(double y) {
    const double e = std::exp(-2.0 * y);
    return 4.0 * e / ((1.0 + e) * (1.0 + e));
}

} // namespace

double Dispersion::omega(double k) const {
    const double kd = k * depth_m;
    const double restoring = k * (gravity_mps2 + surface_tension_m3ps2 * k * k);
    if (k <= 0.0)
        return 0.0;
    return std::sqrt(kd > deep_kd ? restoring : restoring * std::tanh(kd));
}

double Dispersion::group_speed(double k) const {
    if (k <= 0.0)
        return std::sqrt(gravity_mps2 * depth_m);
    const double kd = k * depth_m;
    const double slope = gravity_mps2 + 3.0 * surface_tension_m3ps2 * k * k;
    if (kd > deep_kd)
        return slope / (2.0 * omega(k));
    const double restoring = k * (gravity_mps2 + surface_tension_m3ps2 * k * k);
    return (slope * std::tanh(kd) + depth_m * restoring * sech_squared(kd)) / (2.0 * omega(k));
}

double Dispersion::wavenumber(double omega_radps) const {
    if (!(omega_radps > 0.0))
        return 0.0;
    // Start from gravity waves at this depth, or from capillary waves if they are shorter; Newton
    // in ln k converges from either side because ln omega(ln k) is smooth with slope 1/2 .. 3/2.
    const double deep = omega_radps * omega_radps / gravity_mps2;
    const double a = deep * depth_m;
    double k = a < 1.0 ? std::sqrt(a) * (1.0 + a / 6.0) / depth_m : deep;
    if (surface_tension_m3ps2 > 0.0)
        k = std::min(k, std::cbrt(omega_radps * omega_radps / surface_tension_m3ps2));
    for (int step = 0; step < 30; ++step) {
        const double w = omega(k);
        const double correction = std::log(omega_radps / w) * w / (group_speed(k) * k);
        k *= std::exp(correction);
        if (std::abs(correction) < 2e-15)
            break;
    }
    return k;
}

double orbit_aspect(double k, double depth_m) {
    const double kd = k * depth_m;
    return kd > deep_kd ? 1.0 : 1.0 / std::tanh(std::max(kd, orbit_kd_min));
}

double orbit_growth_m(double k_radpm, double depth_m) {
    const double kd = k_radpm * depth_m;
    if (kd < orbit_kd_min || orbit_aspect(k_radpm, depth_m) == 1.0)
        return 0.0;
    return 2.0 * kd * depth_m / std::sinh(2.0 * kd);
}

} // namespace seaway::sea
