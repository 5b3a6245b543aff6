// SPDX-License-Identifier: Apache-2.0
#include "sea/spectrum/spreading.h"

#include <algorithm>
#include <cmath>

#include "sea/basics/constants.h"
#include "sea/basics/quadrature.h"

namespace seaway::sea {

namespace {

/// ln 2 sqrt(pi).
constexpr double log_two_sqrt_pi = 1.2655121234846454;

/// Integral of cos2 times cos theta: 8 / (3 pi).
constexpr double cos2_first_moment = 0.8488263631567752;

/// (2/pi) cos^2 theta in the downwind half plane; theta in [-pi, pi].
double cos2_value(double theta_rad) {
    if (std::abs(theta_rad) >= 0.5 * pi)
        return 0.0;
    const double c = std::cos(theta_rad);
    return 2.0 / pi * c * c;
}

constexpr double hasselmann_jumps[] = {1.05};
constexpr double donelan_banner_jumps[] = {0.95, 1.6};

/// ln |cos(theta/2)|^2s, exact for narrow beams where 1 - cos would cancel.
double log_power(double theta_rad, double exponent) {
    const double sine = std::sin(0.5 * theta_rad);
    return exponent > 0.0 ? exponent * std::log1p(-std::min(sine * sine, 1.0)) : 0.0;
}

double wrap(double theta_rad) {
    return std::abs(theta_rad) <= pi ? theta_rad : std::remainder(theta_rad, two_pi);
}

} // namespace

double mitsuyasu_exponent(const SpreadingPlace& place) {
    const double log_x = std::log(place.omega_over_peak);
    // ln 11.5; capped so that an old sea (age to infinity) at w = 0 is not infinity times zero.
    const double log_peak = std::min(2.4423470353692043 - 2.5 * std::log(place.inverse_wave_age),
                                     13.815510557964274); // ln spreading_exponent_max
    const double s = std::exp(log_peak + (place.omega_over_peak <= 1.0 ? 5.0 : -2.5) * log_x);
    return std::min(s, spreading_exponent_max);
}

double hasselmann_exponent(const SpreadingPlace& place) {
    const double log_x = std::log(place.omega_over_peak);
    const double mu = -2.33 - 1.45 * (place.inverse_wave_age - 1.17);
    const double s = place.omega_over_peak < hasselmann_jumps[0] ? 6.97 * std::exp(4.06 * log_x)
                                                                 : 9.77 * std::exp(mu * log_x);
    return std::min(s, spreading_exponent_max);
}

double donelan_banner_beta(double x) {
    const double log_x = std::log(x);
    if (x < donelan_banner_jumps[0])
        return 2.61 * std::exp(1.3 * log_x);
    if (x < donelan_banner_jumps[1])
        return 2.28 * std::exp(-1.3 * log_x);
    return std::exp(2.302585092994046 * (-0.4 + 0.8393 * std::exp(-0.567 * 2.0 * log_x)));
}

std::span<const double> spreading_jumps(SpreadingKind kind) {
    switch (kind) {
    case SpreadingKind::hasselmann:
    case SpreadingKind::cos2_hasselmann:
        return hasselmann_jumps;
    case SpreadingKind::donelan_banner:
        return donelan_banner_jumps;
    case SpreadingKind::cos2:
    case SpreadingKind::cos2s:
    case SpreadingKind::mitsuyasu:
    case SpreadingKind::cos2_cos2s:
        break;
    }
    return {};
}

double swell_exponent(double omega_over_peak, double swell) {
    return 16.0 * std::tanh(1.0 / omega_over_peak) * swell * swell;
}

double log_cos2s_norm(double exponent) {
    // ln of Gamma(s+1)/Gamma(s+1/2): shifted to w = s + 1/4 >= 16 with the recurrence, then its
    // series in 1/w^2 (Bernoulli polynomials at 1/4). Unlike lgamma, free of global state.
    double w = exponent + 0.25;
    double ratio = 1.0;
    for (; w < 16.0; w += 1.0)
        ratio *= (w + 0.25) / (w + 0.75);
    const double v = 1.0 / (w * w);
    const double series =
        v * (1.0 / 64 + v * (-5.0 / 2048 + v * (61.0 / 49152 - v * 1385.0 / 1048576)));
    return std::log(ratio * std::sqrt(w)) + series - log_two_sqrt_pi;
}

Spreading::Spreading(const SpreadingModel& model, const SpreadingPlace& place, double exponent_max)
    : isotropic_(model.isotropic) {
    const double extra =
        model.swell > 0.0 ? swell_exponent(place.omega_over_peak, model.swell) : 0.0;
    exponent_ = extra;
    switch (model.kind) {
    case SpreadingKind::cos2:
        shape_ = Shape::half_plane;
        break;
    case SpreadingKind::donelan_banner:
        shape_ = Shape::sech;
        beta_ = donelan_banner_beta(place.omega_over_peak);
        break;
    case SpreadingKind::cos2s:
        exponent_ += model.exponent;
        break;
    case SpreadingKind::mitsuyasu:
        exponent_ += mitsuyasu_exponent(place);
        break;
    case SpreadingKind::hasselmann:
        exponent_ += hasselmann_exponent(place);
        break;
    case SpreadingKind::cos2_cos2s:
        exponent_ += model.exponent;
        broad_share_ = 1.0 - model.narrow_share;
        break;
    case SpreadingKind::cos2_hasselmann:
        exponent_ += hasselmann_exponent(place);
        broad_share_ = 1.0 - model.narrow_share;
        break;
    }
    exponent_ = std::min(exponent_, exponent_max);
    if (shape_ == Shape::power)
        log_norm_ = log_cos2s_norm(exponent_);
    else if (exponent_ > 0.0)
        log_norm_ = -std::log(over_half_circle([](double) { return 1.0; }));
    else if (shape_ == Shape::half_plane)
        log_norm_ = -0.4515827052894548; // ln 2/pi
    else
        log_norm_ = std::log(beta_ / (2.0 * std::tanh(beta_ * pi)));
}

Spreading Spreading::power(double exponent) {
    Spreading s;
    s.exponent_ = exponent;
    s.log_norm_ = log_cos2s_norm(exponent);
    return s;
}

/// The shape times exp(log_norm_), theta in [-pi, pi].
double Spreading::shape_value(double theta_rad) const {
    const double log_value = log_norm_ + log_power(theta_rad, exponent_);
    if (shape_ == Shape::power)
        return std::exp(log_value);
    if (shape_ == Shape::sech) {
        const double e = std::exp(-2.0 * beta_ * std::abs(theta_rad));
        return std::exp(log_value) * 4.0 * e / ((1.0 + e) * (1.0 + e));
    }
    if (std::abs(theta_rad) >= 0.5 * pi)
        return 0.0;
    const double c = std::cos(theta_rad);
    return std::exp(log_value) * c * c;
}

/// Integral of shape * f over the circle, f even. The substitution crowds nodes at theta = pi,
/// where |cos(theta/2)|^2s has a cusp for small s.
template <class F>
double Spreading::over_half_circle(const F& f) const {
    if (shape_ == Shape::half_plane)
        return 2.0 * integrate([&](double t) { return shape_value(t) * f(t); }, 0.0, 0.5 * pi, 2);
    const auto g = [&](double v) {
        const double v3 = v * v * v;
        const double theta = pi * (1.0 - v * v3);
        return shape_value(theta) * f(theta) * 4.0 * pi * v3;
    };
    return 2.0 * integrate(g, 0.0, 1.0, 4);
}

double Spreading::operator()(double theta_rad) const {
    const double theta = wrap(theta_rad);
    double d = shape_value(theta);
    if (broad_share_ > 0.0)
        d = (1.0 - broad_share_) * d + broad_share_ * cos2_value(theta);
    return isotropic_ > 0.0 ? (1.0 - isotropic_) * d + isotropic_ / two_pi : d;
}

double Spreading::first_moment() const {
    const double r1 = shape_ == Shape::power
                          ? exponent_ / (exponent_ + 1.0)
                          : over_half_circle([](double t) { return std::cos(t); });
    return (1.0 - isotropic_) * ((1.0 - broad_share_) * r1 + broad_share_ * cos2_first_moment);
}

} // namespace seaway::sea
