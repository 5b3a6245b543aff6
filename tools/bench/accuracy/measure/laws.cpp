// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/accuracy/measure/laws.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <initializer_list>
#include <numbers>

#include "sea/basics/dispersion.h"
#include "sea/waves/statistics/moments.h"

namespace seaway::bench {

namespace {

double square(double x) {
    return x * x;
}

/// An interpolant of exp(i q x): its mean is `amplitude` of the wave, its mean square `power`.
struct Shown {
    double amplitude;
    double power;
    double steepness; ///< mean square of its derivative by grid points; cubic splines alone
};

Shown shown_along(SpaceRule rule, double q) {
    if (q < 1e-9)
        return {1, 1, q * q};
    if (rule == SpaceRule::bilinear) {
        const double sinc = std::sin(0.5 * q) / (0.5 * q);
        return {sinc * sinc, (2.0 + std::cos(q)) / 3.0, 0.0};
    }
    // sea::spline_error is 2 r / (1 + r), r the sum of the aliases; the two nearest carry their power.
    const double amplitude = 1.0 - 0.5 * sea::spline_error(q);
    const double above = q + 2.0 * std::numbers::pi, below = 2.0 * std::numbers::pi - q;
    const double power_above = square(square(square(q / above)));
    const double power_below = square(square(square(q / below)));
    return {amplitude, square(amplitude) * (1.0 + power_above + power_below),
            square(amplitude) *
                (square(q) + power_above * square(above) + power_below * square(below))};
}

double missed_between(const Shown& x, const Shown& y) {
    return std::max(0.0, 1.0 - 2.0 * x.amplitude * y.amplitude + x.power * y.power);
}

/// Likewise of both derivatives, by grid points.
double steepness_missed(const Shown& x, const Shown& y, double qx, double qy) {
    const double kept = 1.0 - 2.0 * x.amplitude * y.amplitude;
    return std::max(0.0,
                    (qx * qx + qy * qy) * kept + x.steepness * y.power + x.power * y.steepness);
}

/// Mean square of the ulp of a half over 12, for values of a normal distribution.
double half_rounding_variance(double sigma) {
    double sum = 0, weight = 0;
    for (double x = -5.0; x <= 5.0; x += 0.02) {
        int exponent = 0;
        std::frexp(sigma * x, &exponent);
        const double ulp = std::ldexp(1.0, std::max(exponent, -13) - 11);
        const double density = std::exp(-0.5 * x * x);
        sum += density * ulp * ulp / 12.0;
        weight += density;
    }
    return sum / weight;
}

/// A cubic spline through noise at the grid points has so much of its variance between them; likewise
/// the two values that Hermite mixes, and its two rates, in units of interval^2. Bilinear filtering:
/// 2/3 an axis.
constexpr double spline_noise = 0.75;
constexpr double bilinear_noise = 4.0 / 9.0;
constexpr double value_noise = 26.0 / 35.0;
constexpr double rate_noise = 2.0 / 105.0;
/// And of its slope in units of 1 / spacing^2, both axes: the energy of the cardinal spline's derivative.
constexpr double spline_slope_noise = 2.0 * 2.475 * 0.874;
/// A range of so many standard deviations is what a map of some 10^5 points shows.
constexpr double map_range_sigmas = 4.5;

/// What one cascade's waves amount to.
struct Moments {
    double height_m2 = 0, displacement_m2 = 0, rate_m2ps2 = 0, slope2 = 0, strain2 = 0;
};

Moments moments(const sea::CascadeModes& cascade) {
    Moments m;
    for_each_wave(cascade, [&](std::size_t, double kx, double ky, double variance, double omega) {
        const double k2 = kx * kx + ky * ky;
        const double aspect = sea::orbit_aspect(std::sqrt(k2), cascade.depth_m);
        m.height_m2 += variance;
        m.displacement_m2 += variance * aspect * aspect;
        m.rate_m2ps2 += variance * omega * omega;
        m.slope2 += variance * k2;
        m.strain2 += variance * aspect * aspect * k2;
    });
    return m;
}

/// Time rules by phase step, so that every mode need not be averaged over an interval.
struct MissedInTime {
    static constexpr int bins = 256;
    std::array<double, bins> share{};
    double u_max;

    MissedInTime(TimeRule rule, double largest_u) : u_max(std::max(largest_u, 1e-9)) {
        for (int bin = 0; bin < bins; ++bin)
            share[static_cast<std::size_t>(bin)] = missed_in_time(rule, (bin + 0.5) * u_max / bins);
    }
    double operator()(double u) const {
        const int bin = std::min(static_cast<int>(u / u_max * bins), bins - 1);
        return share[static_cast<std::size_t>(bin)];
    }
};

struct Variances {
    double space = 0, time = 0, codec = 0, format = 0, phase = 0, latency = 0;
    double slope = 0; ///< of slopes, by all of space, time and codec
};

void add_waves(const sea::CascadeModes& cascade, double interval_s,
               const Configuration& configuration, sea::TimeUs time_us, Variances& v) {
    const double dx = cascade.spec.spacing_m();
    double omega_max = 0;
    for_each_wave(cascade, [&](std::size_t, double, double, double, double omega) {
        omega_max = std::max(omega_max, omega);
    });
    const MissedInTime missed(configuration.time, omega_max * interval_s);
    std::vector<Shown> shown; // of 0 .. size / 2 lattice steps
    for (int n = 0; n <= cascade.spec.size / 2; ++n)
        shown.push_back(
            shown_along(configuration.space, n * cascade.spec.wavenumber_step_radpm() * dx));
    const auto steps = [size = cascade.spec.size](std::size_t index) {
        return static_cast<std::size_t>(std::abs(sea::signed_index(static_cast<int>(index), size)));
    };
    const auto side = static_cast<std::size_t>(cascade.spec.size);
    const bool maps = configuration.evaluator == Evaluator::maps;
    // Frequency, time and product are each rounded: 0.42 of 2^-24 rms, over all mantissas.
    const double rounded = configuration.phase == PhaseRule::float32 ? 0.73 * 0x1p-24 : 0x1p-54;
    for_each_wave(cascade, [&](std::size_t i, double kx, double ky, double variance, double omega) {
        if (maps) {
            const Shown &x = shown[steps(i % side)], &y = shown[steps(i / side)];
            const double in_time = variance * missed(omega * interval_s);
            v.space += variance * missed_between(x, y);
            v.time += in_time;
            v.slope += in_time * (kx * kx + ky * ky) +
                       variance * steepness_missed(x, y, kx * dx, ky * dx) / (dx * dx);
        }
        if (configuration.phase != PhaseRule::fixed_point) {
            const double phase = rounded * omega * sea::seconds_from_us(time_us);
            v.phase += variance * 2.0 * (1.0 - std::exp(-0.5 * phase * phase));
        }
        v.latency += variance * 2.0 * (1.0 - std::cos(omega * configuration.latency_s));
    });
}

/// Rounding at the grid points, height and what displacements move up and down a slope.
void add_rounding(const Waves& waves, std::size_t c, const Moments& m, double slope2,
                  const Configuration& configuration, Variances& v) {
    const double interval_s = sea::seconds_from_us(waves.budget.cascades[c].interval_us);
    const bool hermite = configuration.time == TimeRule::hermite;
    const double values =
        (configuration.space == SpaceRule::spline ? spline_noise : bilinear_noise) *
        (configuration.time == TimeRule::linear ? 2.0 / 3.0
         : hermite                              ? value_noise
                                                : 1.0);
    const double rates = hermite ? spline_noise * rate_noise * square(interval_s) : 0.0;
    const double sideways = slope2 * square(waves.used->choppiness.x);
    if (configuration.format == MapFormat::f16)
        v.format +=
            values * (half_rounding_variance(std::sqrt(m.height_m2)) +
                      sideways * half_rounding_variance(std::sqrt(0.5 * m.displacement_m2))) +
            rates * half_rounding_variance(std::sqrt(m.rate_m2ps2));
    if (configuration.format == MapFormat::snorm16) {
        const double step2 = square(map_range_sigmas / 32767.0) / 12.0;
        v.format += values * step2 * (m.height_m2 + 0.5 * sideways * m.displacement_m2) +
                    rates * step2 * m.rate_m2ps2;
    }
    const double asked_m = configuration.codec_error_m.value_or(waves.budget.codec_error_m);
    if (!(asked_m > 0))
        return;
    const auto bounds =
        sea::codec_bounds(waves.budget, sea::surface_fields, static_cast<int>(c), asked_m);
    const double value2 = std::min(square(static_cast<double>(bounds[0])) / 3.0, m.height_m2);
    const double rate2 = std::min(square(static_cast<double>(bounds[3])) / 3.0, m.rate_m2ps2);
    v.codec += (values * value2 + rates * rate2) * (1.0 + sideways);
    const double steeper =
        spline_slope_noise / spline_noise / square(waves.used->cascades[c].spec.spacing_m());
    v.slope += steeper * (values * value2 + rates * rate2);
}

/// Fixed-point steps: what is left of lambda D is squeezed by lambda grad D each step. Moments of a
/// normal squeeze grow as (2n - 1)!!; along its own direction a displacement meets 0.6 of the variance.
double inverse_rms(int steps, double sideways, double displacement_m2, double strain2,
                   double slope2) {
    double left2 = square(sideways) * displacement_m2;
    for (int n = 1; n <= steps; ++n)
        left2 *= square(sideways) * 0.6 * strain2 * (2 * n - 1);
    return std::sqrt(0.6 * slope2 * left2);
}

} // namespace

double missed_in_time(TimeRule rule, double u) {
    if (rule == TimeRule::every_frame)
        return 0.0;
    constexpr int steps = 16;
    constexpr sea::TimeUs second = 1'000'000;
    const std::complex<double> after = std::polar(1.0, u);
    double sum = 0;
    for (int i = 0; i < steps; ++i) {
        const double s = (i + 0.5) / steps;
        const auto [value, rate] = time_weights(rule, 0, second, sea::us_from_seconds(s));
        const std::complex<double> iu(0.0, u);
        const std::complex<double> shown =
            value[0] + value[1] * iu + (value[2] + value[3] * iu) * after;
        sum += std::norm(std::polar(1.0, u * s) - shown);
    }
    return sum / steps;
}

double Prediction::rms_m() const {
    double sum = 0;
    for (const double part :
         {space_m, time_m, codec_m, format_m, inverse_m, modes_m, phase_m, latency_m})
        sum += square(part);
    return std::sqrt(sum);
}

Prediction predict(const Waves& waves, const Configuration& configuration, sea::TimeUs time_us) {
    std::vector<Moments> each;
    Moments whole;
    for (const sea::CascadeModes& cascade : waves.used->cascades) {
        const Moments& m = each.emplace_back(moments(cascade));
        whole.displacement_m2 += m.displacement_m2;
        whole.slope2 += m.slope2;
        whole.strain2 += m.strain2;
    }
    Variances v;
    for (std::size_t c = 0; c < each.size(); ++c) {
        const sea::TimeUs interval_us = waves.budget.cascades[c].interval_us;
        add_waves(waves.used->cascades[c], sea::seconds_from_us(interval_us), configuration,
                  time_us, v);
        if (configuration.evaluator == Evaluator::maps)
            add_rounding(waves, c, each[c], whole.slope2, configuration, v);
    }
    Prediction p;
    p.space_m = std::sqrt(v.space);
    p.time_m = std::sqrt(v.time);
    p.codec_m = std::sqrt(v.codec);
    p.format_m = std::sqrt(v.format);
    p.phase_m = std::sqrt(v.phase);
    p.latency_m = std::sqrt(v.latency);
    if (configuration.space == SpaceRule::spline)
        p.slope_rms = std::sqrt(v.slope);
    p.modes_m = std::sqrt(std::max(0.0, variance_of(*waves.all) - variance_of(*waves.used)));
    if (p.modes_m < 1e-9)
        p.modes_m = 0;
    if (configuration.fixed_point_steps)
        p.inverse_m = inverse_rms(*configuration.fixed_point_steps, waves.used->choppiness.x,
                                  whole.displacement_m2, whole.strain2, whole.slope2);
    return p;
}

double Missing::rms_m() const {
    return std::sqrt(square(longer_m) + square(shorter_m) + square(between_m));
}

Missing missing_waves(const Waves& waves) {
    const sea::Dispersion dispersion = waves.state.dispersion();
    // What the scene itself cuts off nobody misses.
    const auto variance = [&](double k_lo, double k_hi) {
        k_lo = std::max(k_lo, waves.state.wavenumber_min_radpm);
        k_hi = std::min(k_hi, waves.state.wavenumber_max_radpm);
        return k_lo < k_hi ? sea::requested_variance(waves.state, dispersion.omega(k_lo),
                                                     dispersion.omega(k_hi))
                           : 0.0;
    };
    constexpr double longest_radpm = 1e-5, ripple_radpm = 2.0 * std::numbers::pi / 0.017;
    Missing missing;
    double held_to = waves.used->cascades.front().band.k_lo_radpm;
    missing.longer_m = std::sqrt(variance(longest_radpm, held_to));
    double between = 0;
    for (const sea::CascadeModes& cascade : waves.used->cascades) {
        if (cascade.band.k_lo_radpm > held_to * (1 + 1e-12))
            between += variance(held_to, cascade.band.k_lo_radpm);
        held_to = std::max(held_to, cascade.band.k_hi_radpm);
    }
    missing.between_m = std::sqrt(between);
    missing.shorter_m = std::sqrt(variance(held_to, 1e4));
    double slope2 = 0;
    for (double k = held_to; k < ripple_radpm; k *= 1.1)
        slope2 += square(k * std::sqrt(1.1)) * variance(k, std::min(1.1 * k, ripple_radpm));
    missing.slope_rms = std::sqrt(slope2);
    return missing;
}

} // namespace seaway::bench
