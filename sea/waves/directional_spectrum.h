// SPDX-License-Identifier: Apache-2.0
// The directional spectrum of one wave system over the whole wavenumber plane, m4/rad2:
//
//     Psi(kx, ky) = S(w) D(theta, w) (dw/dk) / k,     Var(eta) = sum over k of Psi dkx dky
//
// k and -k are different waves; energy travels along +k. Immutable; thread-safe.
#pragma once

#include <complex>
#include <memory>
#include <vector>

#include "sea/spectrum/spectra.h"
#include "sea/spectrum/spreading.h"
#include "sea/waves/sea_state.h"

namespace seaway::sea {

class DirectionalSpectrum {
  public:
    /// Takes depth, gravity, scale, fade and cut-offs from the sea state. Explicit and stylised
    /// waves have no spectrum: empty().
    DirectionalSpectrum(const WaveSystem& system, const SeaState& sea);

    /// All that is the same around a ring |k| = const.
    struct Ring {
        double density; ///< S(w) (dw/dk) / k with fade and cut-offs, m4/rad
        double towards_rad;
        Spreading spreading;
        const MeasuredDirections* measured = nullptr; ///< in place of `spreading`
        bool both_ways = false;                       ///< half the energy runs upwind

        /// Psi, m4/rad2, for waves towards this angle.
        double operator()(double direction_rad) const;
    };
    /// Refers to this spectrum.
    Ring ring(double k_radpm) const;

    /// Psi, m4/rad2; 0 at k = 0.
    double density(double kx_radpm, double ky_radpm) const;

    /// S(w), m2 s/rad, as asked for: with the height scale, without fade and cut-offs.
    double frequency_density(double omega_radps) const;
    /// Integral of D e^{i phi} at this frequency, phi the direction towards: mean direction and
    /// circular spread.
    std::complex<double> direction_moment(double omega_radps) const;
    /// Frequencies where S, its slope or the spreading jumps, ascending, from the lowest to the highest
    /// that matter: an integral between neighbours is smooth.
    std::vector<double> breaks() const;
    /// Of S alone as wavenumbers, rad/m, with the cut-offs among them; in no order.
    std::vector<double> wavenumber_breaks() const;

    /// Outside these no energy is kept.
    Band cutoffs() const { return cutoffs_; }

    /// Waves ever shorter turn ever faster, and add ever more to m2: of Phillips' saturation with surface tension.
    bool m2_diverges() const {
        return phillips_constant_ > 0.0 && dispersion_.surface_tension_m3ps2 > 0.0;
    }
    bool empty() const { return peak_omega_ <= 0.0; }
    double peak_omega_radps() const { return peak_omega_; } ///< 0 if there are no waves
    struct Peak {
        double omega_radps;
        double bin_omega_radps; ///< middle of the measured bin that holds it; else 0
    };
    /// The peak that lies around the frequency where S is largest: of measured bins by a parabola
    /// (MeasuredSpectrum::peak_around); of a formula that frequency itself.
    Peak peak_around(double omega_radps) const;
    bool growth_clamped() const { return frequency_.growth_clamped(); }

  private:
    void set(const WindSea& sea);
    void set(const Swell& sea);
    void set(const MeasuredSea& sea);
    void set(const ExplicitModes&) {} ///< no spectra: no energy here
    void set(const SineRamps&) {}
    std::vector<double> density_breaks() const;
    double wavenumber_density(double k_radpm) const;
    Spreading spreading(double omega_radps) const;
    double short_wave_factor(double k_radpm) const;

    Dispersion dispersion_;
    FrequencySpectrum frequency_;
    double phillips_constant_ = 0.0; ///< > 0: Phillips in place of `frequency_`
    double phillips_wind_mps_ = 0.0;
    /// exp(-1/(kL)^2)/k^3 is largest at kL = sqrt(2/3), L = U^2/g.
    double phillips_peak_radpm() const {
        return std::sqrt(2.0 / 3.0) * dispersion_.gravity_mps2 /
               (phillips_wind_mps_ * phillips_wind_mps_);
    }
    bool phillips_upwind_ = false;
    std::shared_ptr<const MeasuredSpectrum> measured_;
    SpreadingModel spreading_model_;
    double towards_ = 0.0;
    double peak_omega_ = 0.0;
    double inverse_wave_age_ = inverse_wave_age_fully_developed;
    double variance_scale_ = 1.0;
    double fade_m_ = 0.0;
    Band cutoffs_{};
};

} // namespace seaway::sea
