// SPDX-License-Identifier: Apache-2.0
// Directional spreading D(theta): the share of a frequency's energy per radian, theta measured from
// the main direction. D >= 0, D(theta) = D(-theta), and its integral over the full circle is 1 for
// every accepted parameter.
//
// Pure values; thread-safe. Making one costs about 0.1 us (2 us with swell on cos2 and
// donelan_banner, which are normalised by quadrature); evaluating one about 50 ns.
#pragma once

#include <cstdint>
#include <limits>
#include <span>

namespace seaway::sea {

enum class SpreadingKind : std::uint8_t {
    cos2,       ///< 2/pi cos^2 theta in the downwind half plane, 0 upwind
    cos2s,      ///< N(s) |cos(theta/2)|^2s, s the same at all frequencies (Longuet-Higgins 1963)
    mitsuyasu,  ///< cos2s with s(w) of Mitsuyasu et al. 1975
    hasselmann, ///< cos2s with s(w) of Hasselmann, Dunckel, Ewing 1980, break at 1.05 wp
    donelan_banner,  ///< sech^2(beta theta), Donelan et al. 1985, Banner 1990
    cos2_cos2s,      ///< blend of a broad cos2 with a narrow cos2s
    cos2_hasselmann, ///< blend of a broad cos2 with a narrow hasselmann
};

/// What a scene says about spreading.
struct SpreadingModel {
    SpreadingKind kind = SpreadingKind::cos2s;
    double exponent = 10.0; ///< s of cos2s and cos2_cos2s, 0 .. 1e6
    double swell = 0.0;     ///< Horvath 2015 elongation xi, 0 .. 1: times |cos(theta/2)|^(2 s_xi)
    double isotropic = 0.0; ///< share of energy spread evenly over the circle, 0 .. 1
    /// The blends: share of the energy in the narrow part, 0 .. 1; the rest is cos2, which no swell
    /// narrows.
    double narrow_share = 0.5;
};

/// Where in the sea a frequency stands.
struct SpreadingPlace {
    double omega_over_peak;
    double inverse_wave_age; ///< U10 / cp; 0.83 for a fully developed sea
};

inline constexpr double inverse_wave_age_fully_developed = 0.83;
/// No beam is taken narrower than this s (0.08 degrees); also the limit of Mitsuyasu's s at U -> 0.
inline constexpr double spreading_exponent_max = 1e6;

/// D(theta) at one frequency.
class Spreading {
  public:
    /// s <= exponent_max for the cos2s family: how narrow the lattice can carry.
    Spreading(const SpreadingModel& model, const SpreadingPlace& place,
              double exponent_max = spreading_exponent_max);
    /// cos2s with this s.
    static Spreading power(double exponent);

    /// D at theta from the main direction, 1/rad; any finite theta, wrapped to [-pi, pi].
    double operator()(double theta_rad) const;

    /// First Fourier coefficient, integral of D cos theta: 0 .. 1. Closed or by quadrature.
    double first_moment() const;

    /// s of the cos2s family, swell included; of cos2 and donelan_banner: the swell factor's alone;
    /// of a blend: of its narrow part.
    double exponent() const { return exponent_; }

  private:
    enum class Shape : std::uint8_t { half_plane, power, sech };
    Spreading() = default;
    double shape_value(double theta_rad) const;
    template <class F>
    double over_half_circle(const F& f) const;

    Shape shape_ = Shape::power;
    double exponent_ = 0.0;
    double beta_ = 0.0;
    double log_norm_ = 0.0;
    double isotropic_ = 0.0;
    double broad_share_ = 0.0; ///< of cos2, beside `shape_`
};

double mitsuyasu_exponent(const SpreadingPlace& place);
double hasselmann_exponent(const SpreadingPlace& place);
double donelan_banner_beta(double omega_over_peak);
/// w / wp where a spreading jumps, as its authors printed it.
std::span<const double> spreading_jumps(SpreadingKind kind);
/// Horvath's addition to s: 16 tanh(wp/w) xi^2.
double swell_exponent(double omega_over_peak, double swell);
/// ln N(s), N = Gamma(s+1) / (2 sqrt(pi) Gamma(s+1/2)), to 1e-14 for s >= 0.
double log_cos2s_norm(double exponent);

} // namespace seaway::sea
