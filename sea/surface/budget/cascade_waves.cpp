// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/budget/cascade_waves.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include "sea/surface/budget/interpolation_laws.h"

namespace seaway::sea {

namespace {

double square(double x) {
    return x * x;
}

/// What a hard bound counts where standard deviations are added.
double as_rms(double bound_m) {
    return bound_m / bound_sigmas;
}

/// A wave that is missed by `east` along one axis and by `north` along the other is missed by their sum
/// in the middle of a cell. Halves of what they have in common make the two add up to that in the square.
void miss(Motion& motion, double variance, double east, double north) {
    motion.east_m2 += variance * east * (east + north);
    motion.north_m2 += variance * north * (east + north);
}

} // namespace

CascadeWaves::CascadeWaves(const CascadeModes& modes)
    : size_(modes.spec.size), spacing_m_(modes.spec.spacing_m()) {
    for (std::size_t i = 0; i < modes.h0.size(); ++i)
        if (modes.h0[i] != std::complex<double>{})
            omega_max_radps_ = std::max(omega_max_radps_, omega_from_rate(modes.rate[i]));
    const double dk = modes.spec.wavenumber_step_radpm();
    for (int iy = 0; iy < size_; ++iy)
        for (int ix = 0; ix < size_; ++ix) {
            const auto i = static_cast<std::size_t>(iy) * static_cast<std::size_t>(size_) +
                           static_cast<std::size_t>(ix);
            const double variance = 2.0 * std::norm(modes.h0[i]);
            const double kx = dk * signed_index(ix, size_), ky = dk * signed_index(iy, size_);
            if (variance > 0)
                add(variance, kx, ky, omega_from_rate(modes.rate[i]),
                    orbit_aspect(std::hypot(kx, ky), modes.depth_m));
        }
    for (const SineField& field : modes.sines) {
        const SineError& error = sines_.emplace_back(field, spacing_m_);
        miss(height_, 1.0, as_rms(error.east_m()), as_rms(error.north_m()));
        height_.gradient += error.slope_variance();
        detail_m2_ += error.detail_m2();
        rate_detail_m2ps2_ += error.rate_detail_m2ps2();
    }
    height_.single_m = single_precision_share * 4.0 * std::sqrt(height_.whole_m2);
    displacement_.single_m = single_precision_share * 4.0 * std::sqrt(displacement_.whole_m2);
    strain_.single_m = sampled_slope_error(displacement_.single_m, spacing_m_);
}

void CascadeWaves::add(double variance, double kx, double ky, double omega_radps, double aspect) {
    const double share = omega_radps / omega_max_radps_;
    const auto bin =
        static_cast<std::size_t>(std::min(static_cast<int>(share * Motion::bins), Motion::bins - 1));
    const double qx = std::abs(kx) * spacing_m_, qy = std::abs(ky) * spacing_m_;
    const double k_squared = kx * kx + ky * ky;
    const auto count = [&](Motion& motion, double part, double east, double north) {
        motion.by_frequency_m2[bin] += part;
        motion.whole_m2 += part;
        motion.gradient += part * k_squared;
        miss(motion, part, east, north);
    };
    count(height_, variance, spline_error(qx), spline_error(qy));
    count(displacement_, variance * square(aspect), spline_error(qx), spline_error(qy));
    count(strain_, variance * square(aspect) * k_squared, spline_slope_error(qx),
          spline_slope_error(qy));
    const double detail = variance * (2.0 - 2.0 * std::cos(qx)) * (2.0 - 2.0 * std::cos(qy));
    detail_m2_ += detail;
    rate_detail_m2ps2_ += detail * square(omega_radps);
}

bool CascadeWaves::told_by(TimeUs interval_us) const {
    return omega_max_radps_ * seconds_from_us(interval_us) <= hermite_phase_max;
}

double CascadeWaves::time_rms(const Motion& motion, TimeUs interval_us) const {
    double sum = 0;
    for (int bin = 0; bin < Motion::bins; ++bin) {
        const double omega = omega_max_radps_ * (bin + 1) / Motion::bins;
        const double missed = hermite_error(omega * seconds_from_us(interval_us));
        sum += motion.by_frequency_m2[static_cast<std::size_t>(bin)] * missed * missed;
    }
    return std::sqrt(sum);
}

CascadeLoss CascadeWaves::loss(TimeUs interval_us) const {
    const auto of = [&](const Motion& motion) {
        MapLoss loss;
        loss.time_m = time_rms(motion, interval_us);
        loss.east_m = std::sqrt(motion.east_m2);
        loss.north_m = std::sqrt(motion.north_m2);
        return loss;
    };
    CascadeLoss loss{of(height_), of(displacement_)};
    for (const SineError& sine : sines_)
        loss.height.time_m = std::hypot(loss.height.time_m, as_rms(sine.time_m(interval_us)));
    return loss;
}

double CascadeWaves::time_strain_rms(TimeUs interval_us) const {
    return time_rms(strain_, interval_us);
}

double CascadeWaves::strain_rms(TimeUs interval_us) const {
    return std::sqrt(square(time_strain_rms(interval_us)) + strain_.east_m2 + strain_.north_m2);
}

} // namespace seaway::sea
