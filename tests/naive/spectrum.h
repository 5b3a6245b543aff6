// SPDX-License-Identifier: Apache-2.0
// Formulas of spectra typed in as they are printed, in single precision.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace seaway::naive {

/// A2: w^-5 overflows where exp(-(wp/w)^4) is zero: infinity times zero.
inline float density(float omega_radps, float peak_radps, float scale) {
    return scale * std::pow(omega_radps, -5.0f) *
           std::exp(-1.25f * std::pow(peak_radps / omega_radps, 4.0f));
}

/// A7: tanh as sinh over cosh, which are both infinite above 89.
inline float omega(float k_radpm, float depth_m) {
    return std::sqrt(9.81f * k_radpm *
                     (std::sinh(k_radpm * depth_m) / std::cosh(k_radpm * depth_m)));
}

/// A13: the fetch law for any fetch; nothing says that growth ends.
inline double jonswap_hs_m(double wind_mps, double fetch_m) {
    const double x = 9.81 * fetch_m / (wind_mps * wind_mps);
    const double peak = 2 * std::numbers::pi * 3.5 * (9.81 / wind_mps) * std::pow(x, -0.33);
    const double alpha = 0.076 * std::pow(x, -0.22);
    // The integral of the shape with gamma 3.3 is 0.2 * 1.5259 (D05).
    return 4 * std::sqrt(alpha * 9.81 * 9.81 * std::pow(peak, -4) * 0.2 * 1.5259);
}

/// A15: the norm of cos2s by the gamma functions of the paper; Gamma(2s+1) is infinite above s = 17.
inline float cos2s_norm(float s) {
    return std::pow(2.0f, 2 * s - 1) / std::numbers::pi_v<float> * std::tgamma(s + 1) *
           std::tgamma(s + 1) / std::tgamma(2 * s + 1);
}

/// A23: Box-Muller's radius of a word that may be zero.
inline double box_muller_radius(std::uint32_t word) {
    return std::sqrt(-2 * std::log(word / 4294967296.0));
}

} // namespace seaway::naive
