// SPDX-License-Identifier: Apache-2.0
#include "sea/spectrum/spectra.h"

#include <algorithm>
#include <cmath>

#include "sea/basics/quadrature.h"

namespace seaway::sea {

namespace {

constexpr double pm_alpha = 8.1e-3;
/// Peak of Pierson-Moskowitz: (4 * 0.74 / 5)^(1/4) g / U19.5.
constexpr double pm_peak = 0.8771632473301956;

/// The exponent r of gamma; x = w / wp.
double peak_exponent(double x) {
    const double sigma = x <= 1.0 ? 0.07 : 0.09;
    const double z = (x - 1.0) / sigma;
    return std::exp(-0.5 * z * z);
}

/// A wind or fetch this small raises nothing; denormals count as zero.
bool raises_waves(double value) {
    return value >= 1e-100;
}

} // namespace

FrequencySpectrum FrequencySpectrum::jonswap_by_wind(double wind_speed_10m_mps, double fetch_m,
                                                     double gamma, double gravity_mps2) {
    FrequencySpectrum s;
    if (!raises_waves(wind_speed_10m_mps) || !raises_waves(fetch_m))
        return s;
    const double ratio = gravity_mps2 / wind_speed_10m_mps;
    const double grown = ratio * (fetch_m / wind_speed_10m_mps);
    s.growth_clamped_ = grown > full_development_fetch && std::isfinite(fetch_m);
    const double log_x = std::log(std::min(grown, full_development_fetch));
    s.peak_omega_ = two_pi * 3.5 * ratio * std::exp(-0.33 * log_x);
    s.scale_ = 0.076 * gravity_mps2 * gravity_mps2 * std::exp(-0.22 * log_x);
    s.log_gamma_ = std::log(gamma);
    return s;
}

FrequencySpectrum FrequencySpectrum::jonswap_by_height(double significant_height_m,
                                                       double peak_period_s, double gamma) {
    FrequencySpectrum s;
    if (!raises_waves(significant_height_m))
        return s;
    s.peak_omega_ = two_pi / peak_period_s;
    s.log_gamma_ = std::log(gamma);
    const double peak2 = s.peak_omega_ * s.peak_omega_;
    s.scale_ = significant_height_m * significant_height_m / 16.0 * peak2 * peak2 /
               jonswap_shape_integral(gamma);
    return s;
}

FrequencySpectrum FrequencySpectrum::pierson_moskowitz(double wind_speed_19m5_mps,
                                                       double gravity_mps2) {
    FrequencySpectrum s;
    if (!raises_waves(wind_speed_19m5_mps))
        return s;
    s.peak_omega_ = pm_peak * gravity_mps2 / wind_speed_19m5_mps;
    s.scale_ = pm_alpha * gravity_mps2 * gravity_mps2;
    return s;
}

FrequencySpectrum FrequencySpectrum::at_depth(double depth_m, double gravity_mps2) const {
    FrequencySpectrum s = *this;
    s.depth_m_ = depth_m;
    s.gravity_mps2_ = gravity_mps2;
    return s;
}

double FrequencySpectrum::density(double omega) const {
    if (empty() || !(omega > 0.0))
        return 0.0;
    const double inverse = peak_omega_ / omega;
    const double inverse2 = inverse * inverse;
    double exponent = -1.25 * inverse2 * inverse2;
    if (log_gamma_ != 0.0)
        exponent += peak_exponent(omega / peak_omega_) * log_gamma_;
    // Leave before w^5 underflows; what is dropped is below 1e-300 of the peak (hard case A2).
    if (!(exponent > -700.0))
        return 0.0;
    const double omega2 = omega * omega;
    const double s = scale_ * std::exp(exponent) / (omega2 * omega2 * omega);
    return std::isinf(depth_m_) ? s : s * kitaigorodskii_factor(omega, depth_m_, gravity_mps2_);
}

double grown_sea_wind_10m_mps(double variance_m2, double gravity_mps2) {
    // m0 = alpha U^4 / (4 beta g^2), U at 19.5 m.
    constexpr double beta = 0.74;
    return std::pow(4.0 * beta / pm_alpha * variance_m2 * gravity_mps2 * gravity_mps2, 0.25) /
           wind_19m5_over_10m;
}

double kitaigorodskii_factor(double omega_radps, double depth_m, double gravity_mps2) {
    const Dispersion gravity_waves{gravity_mps2, 0.0, depth_m};
    const double kd = gravity_waves.wavenumber(omega_radps) * depth_m;
    if (!(kd < 20.0))
        return 1.0;
    // sinh(2y) = (1 - e^-4y) / (2 e^-2y), written without overflow; its series below 1e-3.
    const double y = kd;
    const double q =
        y < 1e-3 ? 1.0 - 2.0 * y * y / 3.0 : 4.0 * y * std::exp(-2.0 * y) / -std::expm1(-4.0 * y);
    const double t = std::tanh(y);
    return t * t / (1.0 + q);
}

double jonswap_shape_integral(double gamma) {
    // In u = ln x; split at the peak, where sigma jumps.
    const double log_gamma = std::log(gamma);
    const auto shape = [log_gamma](double u) {
        return std::exp(-4.0 * u - 1.25 * std::exp(-4.0 * u) +
                        peak_exponent(std::exp(u)) * log_gamma);
    };
    return integrate(shape, -1.2, 0.0, 12) + integrate(shape, 0.0, 0.7, 12) +
           integrate(shape, 0.7, 9.0, 12);
}

double phillips_density_k(double k, double constant, double wind_speed_10m_mps,
                          double gravity_mps2) {
    if (!raises_waves(wind_speed_10m_mps) || !(k > 0.0) || !(constant > 0.0))
        return 0.0;
    const double length = wind_speed_10m_mps / gravity_mps2 * wind_speed_10m_mps;
    const double inverse = 1.0 / (k * length);
    const double log_s = std::log(0.5 * pi * constant) - 3.0 * std::log(k) - inverse * inverse;
    return log_s > -700.0 ? std::exp(log_s) : 0.0;
}

} // namespace seaway::sea
