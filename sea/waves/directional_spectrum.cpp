// SPDX-License-Identifier: Apache-2.0
#include "sea/waves/directional_spectrum.h"

#include <algorithm>
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
            phillips_upwind_ = sea.phillips_upwind;
            peak_omega_ = dispersion_.omega(phillips_peak_radpm());
        }
        break;
    case SpectrumKind::pierson_moskowitz:
        frequency_ = FrequencySpectrum::pierson_moskowitz(
            sea.wind_speed_19m5_mps.value_or(wind_19m5_over_10m * wind), g);
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

void DirectionalSpectrum::set(const MeasuredSea& sea) {
    measured_ = sea.spectrum;
    towards_ = sea.towards_rad;
    spreading_model_ = sea.spreading;
    peak_omega_ = measured_ ? measured_->peak_omega_radps() : 0.0;
}

double DirectionalSpectrum::short_wave_factor(double k) const {
    if (!cutoffs_.contains(k))
        return 0.0;
    const double kl = k * fade_m_;
    return fade_m_ > 0.0 ? std::exp(-kl * kl) : 1.0;
}

Spreading DirectionalSpectrum::spreading(double omega) const {
    const double x = empty() ? 1.0 : omega / peak_omega_;
    return Spreading(spreading_model_, {x, inverse_wave_age_});
}

std::complex<double> DirectionalSpectrum::direction_moment(double omega) const {
    if (measured_ && measured_->has_directions()) {
        const MeasuredBin* bin = measured_->find(omega);
        return bin != nullptr ? bin->directions->first_moment() : 0.0;
    }
    if (phillips_upwind_)
        return 0.0;
    return std::polar(spreading(omega).first_moment(), towards_);
}

std::vector<double> DirectionalSpectrum::density_breaks() const {
    if (empty())
        return {};
    if (!measured_)
        // Below a quarter of the peak, exp(-5/4 4^4) leaves nothing; above 1000 peaks lie 1e-12 of
        // m0 and 1e-6 of m2. At the peak JONSWAP's sigma jumps. Phillips' law is of wavenumbers, of which shallow water has
        // those of lower frequencies: as far as in deep water, a million peaks.
        return {0.25 * peak_omega_, peak_omega_,
                std::max(1000.0 * peak_omega_,
                         phillips_constant_ > 0.0
                             ? std::sqrt(dispersion_.gravity_mps2 * 1e6 * phillips_peak_radpm())
                             : 0.0)};
    std::vector<double> edges;
    for (const MeasuredBin& bin : measured_->bins) {
        if (edges.empty() || bin.omega_lo_radps > edges.back())
            edges.push_back(bin.omega_lo_radps);
        edges.push_back(bin.omega_hi_radps);
    }
    if (edges.front() <= 0.0)
        edges.front() = 1e-3 * edges[1]; // integrals run in ln w; this loses 0.1 % of one bin
    return edges;
}

std::vector<double> DirectionalSpectrum::breaks() const {
    std::vector<double> all = density_breaks();
    if (all.empty() || (measured_ && measured_->has_directions()))
        return all;
    const double lowest = all.front(), highest = all.back();
    for (const double jump : spreading_jumps(spreading_model_.kind))
        if (lowest < jump * peak_omega_ && jump * peak_omega_ < highest)
            all.push_back(jump * peak_omega_);
    std::sort(all.begin(), all.end());
    return all;
}

std::vector<double> DirectionalSpectrum::wavenumber_breaks() const {
    std::vector<double> wavenumbers{cutoffs_.k_lo_radpm, cutoffs_.k_hi_radpm};
    for (const double omega : density_breaks())
        wavenumbers.push_back(dispersion_.wavenumber(omega));
    return wavenumbers;
}

double DirectionalSpectrum::frequency_density(double omega) const {
    if (empty() || !(omega > 0.0))
        return 0.0;
    if (measured_) {
        const MeasuredBin* bin = measured_->find(omega);
        return bin != nullptr ? variance_scale_ * bin->density : 0.0;
    }
    if (phillips_constant_ > 0.0) {
        const double k = dispersion_.wavenumber(omega);
        return wavenumber_density(k) / dispersion_.group_speed(k);
    }
    return variance_scale_ * frequency_.density(omega);
}

DirectionalSpectrum::Peak DirectionalSpectrum::peak_around(double omega) const {
    const MeasuredBin* bin = measured_ ? measured_->find(omega) : nullptr;
    if (bin == nullptr)
        return {omega, 0.0};
    return {measured_->peak_around(*bin), bin->omega_mid_radps};
}

double DirectionalSpectrum::wavenumber_density(double k) const {
    if (phillips_constant_ > 0.0)
        return (phillips_upwind_ ? 2.0 : 1.0) * variance_scale_ *
               phillips_density_k(k, phillips_constant_, phillips_wind_mps_,
                                  dispersion_.gravity_mps2);
    return frequency_density(dispersion_.omega(k)) * dispersion_.group_speed(k);
}

DirectionalSpectrum::Ring DirectionalSpectrum::ring(double k) const {
    const double factor = empty() || !(k > 0.0) ? 0.0 : short_wave_factor(k);
    if (factor <= 0.0)
        return {0.0, 0.0, Spreading::power(0.0)};
    const double omega = dispersion_.omega(k);
    const double density = factor * wavenumber_density(k) / k;
    if (measured_ && measured_->has_directions()) {
        const MeasuredBin* bin = measured_->find(omega);
        return {density, 0.0, Spreading::power(0.0), bin != nullptr ? &*bin->directions : nullptr};
    }
    return {density, towards_, spreading(omega), nullptr, phillips_upwind_};
}

double DirectionalSpectrum::Ring::operator()(double direction_rad) const {
    if (measured != nullptr)
        return density * (*measured)(direction_rad);
    const double theta = direction_rad - towards_rad;
    return density *
           (both_ways ? 0.5 * (spreading(theta) + spreading(theta + pi)) : spreading(theta));
}

double DirectionalSpectrum::density(double kx, double ky) const {
    const Ring at = ring(std::hypot(kx, ky));
    return at.density > 0.0 ? at(std::atan2(ky, kx)) : 0.0;
}

} // namespace seaway::sea
