// SPDX-License-Identifier: Apache-2.0
// The directional spectrum of one wave system over the whole wavenumber plane, m4/rad2:
//
//     Psi(kx, ky) = S(w) D(theta, w) (dw/dk) / k,     Var(eta) = sum over k of Psi dkx dky
//
// k and -k are different waves; energy travels along +k. Immutable; thread-safe.
#pragma once

#include "sea/sea_state.h"
#include "sea/spectra.h"
#include "sea/spreading.h"

namespace seaway::sea {

class DirectionalSpectrum {
  public:
    /// Takes depth, gravity, scale, fade and cut-offs from the sea state.
    DirectionalSpectrum(const WaveSystem& system, const SeaState& sea);

    /// All that is the same around a ring |k| = const: Psi = density * spreading(theta - towards).
    struct Ring {
        double density; ///< S(w) (dw/dk) / k with fade and cut-offs, m4/rad
        Spreading spreading;
    };
    /// `exponent_max`: the narrowest beam, as s of cos2s, that the lattice can carry at this k.
    Ring ring(double k_radpm, double exponent_max = spreading_exponent_max) const;

    /// Psi, m4/rad2; 0 at k = 0.
    double density(double kx_radpm, double ky_radpm) const;

    /// S(w), m2 s/rad, as asked for: with the height scale, without fade and cut-offs.
    double frequency_density(double omega_radps) const;
    /// D at this frequency, theta from towards_rad().
    Spreading spreading(double omega_radps, double exponent_max = spreading_exponent_max) const;

    bool empty() const { return peak_omega_ <= 0.0; }
    double towards_rad() const { return towards_; }
    double peak_omega_radps() const { return peak_omega_; } ///< 0 if there are no waves
    bool growth_clamped() const { return frequency_.growth_clamped(); }

  private:
    void set(const WindSea& sea);
    void set(const Swell& sea);
    double short_wave_factor(double k_radpm) const;

    Dispersion dispersion_;
    FrequencySpectrum frequency_;
    double phillips_constant_ = 0.0; ///< > 0: Phillips in place of `frequency_`
    double phillips_wind_mps_ = 0.0;
    SpreadingModel spreading_model_;
    double towards_ = 0.0;
    double peak_omega_ = 0.0;
    double inverse_wave_age_ = inverse_wave_age_fully_developed;
    double variance_scale_ = 1.0;
    double fade_m_ = 0.0;
    Band cutoffs_{};
};

} // namespace seaway::sea
