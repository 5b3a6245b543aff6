// SPDX-License-Identifier: Apache-2.0
// Formulas of spectra typed in as they are printed, in single precision.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "sea/waves/directional_spectrum.h"

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

/// A1: the direction of a wave, k_x / k, wherever k is.
inline double direction_x(double kx_radpm, double ky_radpm) {
    return kx_radpm / std::hypot(kx_radpm, ky_radpm);
}

/// A4: where -k lies in an array of n x n, without "% n": wrong where an index is zero.
inline std::size_t mirrored(std::size_t ix, std::size_t iy, std::size_t n) {
    return ((n - iy) * n + (n - ix)) % (n * n); // else it would read beyond the array
}

/// A5: a tanh that fits the depth factor well where waves feel the ground a little.
inline double depth_factor(double omega_radps, double depth_m) {
    return 0.5 + 0.5 * std::tanh(1.8 * (omega_radps * std::sqrt(depth_m / 9.81) - 1.125));
}

/// A14: JONSWAP's norm by a fit made for gamma around 3.
inline double jonswap_norm(double gamma) {
    return 1 - 0.287 * std::log(gamma);
}

/// A16: the density at the lattice point times the cell, however narrow the beam, m2.
inline double sampled_variance(const sea::DirectionalSpectrum& spectrum, int nx, int ny,
                               double step_radpm) {
    return spectrum.density(nx * step_radpm, ny * step_radpm) * step_radpm * step_radpm;
}

/// A20: sech^2 of the angle between two directions as it comes, not wrapped; not normalised.
inline double sech2_beam(double beta, double theta_rad, double towards_rad) {
    return std::pow(std::cosh(beta * (theta_rad - towards_rad)), -2);
}

/// A22: a seed made of the parameters: every change draws another sea.
inline std::uint64_t seed_of(double wind_mps) {
    return static_cast<std::uint64_t>(1000 * wind_mps + 0.5);
}

/// A24: the noise of shaders, 0 .. 1, in floats.
inline float hashed_noise(float x, float y) {
    const float s = std::sin(x * 12.9898f + y * 78.233f) * 43758.5453f;
    return s - std::floor(s);
}

/// A13, A9, A12: the fetch law for any wind and fetch; nothing says that growth ends.
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

/// I8: how far Hs of one tile may be off, whatever the tile.
inline constexpr double hs_gate = 0.03;

} // namespace seaway::naive
