// SPDX-License-Identifier: Apache-2.0
#include "sea/directional_spectrum.h"

#include <cmath>

namespace seaway::sea {

DirectionalSpectrum::DirectionalSpectrum(const WaveSystem& system, const SeaState& sea)
    : dispersion_(sea.dispersion()), variance_scale_(sea.height_scale * sea.height_scale),
      fade_m_(sea.short_wave_fade_m), cutoffs_{sea.wavenumber_min_radpm, sea.wavenumber_max_radpm} {
    std::visit([this](const auto& s) { set(s); }, system);
}

void DirectionalSpectrum::set(const WindSea& sea) {
    const double g = dispersion_.gravity_mps2;
    const double wind = sea.wind_speed_10m_mps;
    towards_ = sea.towards_rad;
    spreading_model_ = sea.spreading;
    switch (sea.spectrum) {
    case SpectrumKind::phillips:
        if (wind >= 1e-3 && sea.phillips_constant > 0.0) {
            phillips_constant_ = sea.phillips_constant;
            phillips_wind_mps_ = wind;
            // exp(-1/(kL)^2)/k^3 is largest at kL = sqrt(2/3).
            peak_omega_ = dispersion_.omega(std::sqrt(2.0 / 3.0) * g / (wind * wind));
        }
        break;
    case SpectrumKind::pierson_moskowitz:
        frequency_ = FrequencySpectrum::pierson_moskowitz(wind_19m5_over_10m * wind, g);
        break;
    case SpectrumKind::jonswap:
    case SpectrumKind::tma:
    case SpectrumKind::bretschneider:
        frequency_ = FrequencySpectrum::jonswap_by_wind(wind, sea.fetch_m, sea.gamma, g);
        if (sea.spectrum == SpectrumKind::tma)
            frequency_ = frequency_.at_depth(dispersion_.depth_m, g);
        break;
    }
    if (!frequency_.empty())
        peak_omega_ = frequency_.peak_omega_radps();
    inverse_wave_age_ = wind * peak_omega_ / g;
}

void DirectionalSpectrum::set(const Swell& sea) {
    towards_ = sea.towards_rad;
    spreading_model_ = sea.spreading;
    const double gamma = sea.spectrum == SpectrumKind::bretschneider ? 1.0 : sea.gamma;
    frequency_ =
        FrequencySpectrum::jonswap_by_height(sea.significant_height_m, sea.peak_period_s, gamma);
    if (sea.spectrum == SpectrumKind::tma)
        frequency_ = frequency_.at_depth(dispersion_.depth_m, dispersion_.gravity_mps2);
    peak_omega_ = frequency_.peak_omega_radps();
}

double DirectionalSpectrum::short_wave_factor(double k) const {
    if (!cutoffs_.contains(k))
        return 0.0;
    const double kl = k * fade_m_;
    return fade_m_ > 0.0 ? std::exp(-kl * kl) : 1.0;
}

Spreading DirectionalSpectrum::spreading(double omega, double exponent_max) const {
    const double x = empty() ? 1.0 : omega / peak_omega_;
    return Spreading(spreading_model_, {x, inverse_wave_age_}, exponent_max);
}

double DirectionalSpectrum::frequency_density(double omega) const {
    if (empty() || !(omega > 0.0))
        return 0.0;
    if (phillips_constant_ > 0.0) {
        const double k = dispersion_.wavenumber(omega);
        return variance_scale_ *
               phillips_density_k(k, phillips_constant_, phillips_wind_mps_,
                                  dispersion_.gravity_mps2) /
               dispersion_.group_speed(k);
    }
    return variance_scale_ * frequency_.density(omega);
}

DirectionalSpectrum::Ring DirectionalSpectrum::ring(double k, double exponent_max) const {
    const double factor = empty() || !(k > 0.0) ? 0.0 : short_wave_factor(k);
    if (factor <= 0.0)
        return {0.0, Spreading::power(0.0)};
    const double omega = dispersion_.omega(k);
    const double s_k =
        phillips_constant_ > 0.0
            ? variance_scale_ * phillips_density_k(k, phillips_constant_, phillips_wind_mps_,
                                                   dispersion_.gravity_mps2)
            : frequency_density(omega) * dispersion_.group_speed(k);
    return {factor * s_k / k, spreading(omega, exponent_max)};
}

double DirectionalSpectrum::density(double kx, double ky) const {
    const Ring at = ring(std::hypot(kx, ky));
    return at.density > 0.0 ? at.density * at.spreading(std::atan2(ky, kx) - towards_) : 0.0;
}

} // namespace seaway::sea
