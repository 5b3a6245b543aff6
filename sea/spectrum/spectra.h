// SPDX-License-Identifier: Apache-2.0
// Frequency spectra: one-sided S(w), m2 s/rad, with m0 = integral of S dw and Hs = 4 sqrt(m0).
//
// Pure values and functions, thread-safe. Finite for every w >= 0 and every accepted
// parameter (hard case A2). Sources beside each function; choices in
// docs/physics.md.
#pragma once

#include "sea/basics/dispersion.h"

namespace seaway::sea {

/// w^-5 family: S = scale w^-5 exp(-5/4 (wp/w)^4) gamma^r, r as JONSWAP (Hasselmann et al. 1973),
/// times the Kitaigorodskii depth factor if `depth_m` is set.
class FrequencySpectrum {
  public:
    /// No waves at all.
    FrequencySpectrum() = default;

    /// JONSWAP by wind (10 m) and fetch: alpha = 0.076 x^-0.22, fp = 3.5 (g/U) x^-0.33,
    /// x = g F / U^2 clamped at full development (growth_clamped()). U, F >= 0; 0 is no sea.
    static FrequencySpectrum jonswap_by_wind(double wind_speed_10m_mps, double fetch_m,
                                             double gamma, double gravity_mps2);
    /// JONSWAP by Hs, Tp, gamma (1 .. 20), normalised exactly (numeric integral of the shape).
    /// gamma = 1 is Bretschneider / ITTC: S = 5/16 Hs^2 wp^4 w^-5 exp(-5/4 (wp/w)^4).
    static FrequencySpectrum jonswap_by_height(double significant_height_m, double peak_period_s,
                                               double gamma);
    /// Pierson-Moskowitz 1964 by the wind at 19.5 m: alpha 8.1e-3, beta 0.74.
    static FrequencySpectrum pierson_moskowitz(double wind_speed_19m5_mps, double gravity_mps2);

    /// The same times the exact Kitaigorodskii factor (TMA, Bouws et al. 1985). Lowers Hs.
    FrequencySpectrum at_depth(double depth_m, double gravity_mps2) const;

    /// S(w), m2 s/rad; w >= 0.
    double density(double omega_radps) const;

    bool empty() const { return peak_omega_ <= 0.0; }
    double peak_omega_radps() const { return peak_omega_; } ///< of the deep-water form
    bool growth_clamped() const { return growth_clamped_; }

  private:
    double scale_ = 0.0; ///< the factor of w^-5, m2 (rad/s)^4
    double peak_omega_ = 0.0;
    double log_gamma_ = 0.0;
    double depth_m_ = deep_water_m;
    double gravity_mps2_ = gravity_default_mps2;
    bool growth_clamped_ = false;
};

/// Wind at 10 m of the Pierson-Moskowitz sea of this variance.
double grown_sea_wind_10m_mps(double variance_m2, double gravity_mps2);

/// Dimensionless fetch g F / U^2 at which JONSWAP's peak reaches Pierson-Moskowitz's 0.13 g/U10;
/// no sea grows beyond: (3.5/0.13)^(1/0.33).
inline constexpr double full_development_fetch = 21563.0995553856;

/// Kitaigorodskii's depth factor tanh^2(kd) / (1 + 2kd/sinh 2kd), k from w^2 = g k tanh kd; 0 .. 1.
double kitaigorodskii_factor(double omega_radps, double depth_m, double gravity_mps2);

/// Integral of x^-5 exp(-5/4 x^-4) gamma^r over x = w/wp: 0.2 at gamma 1; gamma 1 .. 20, to 1e-10.
double jonswap_shape_integral(double gamma);

/// Phillips' saturation spectrum over the wavenumber, S(k) = (pi/2) A exp(-1/(kL)^2) / k^3, m3/rad,
/// L = U^2/g: the downwind half of Tessendorf's A exp(-1/(kL)^2) cos^2 / k^4 (Tessendorf 2001).
/// Hs = 4 sqrt(A pi L^2 / 4).
double phillips_density_k(double k_radpm, double constant, double wind_speed_10m_mps,
                          double gravity_mps2);

} // namespace seaway::sea
