// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/budget/cascade_waves.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "sea/surface/budget/interpolation_laws.h"
#include "sea/surface/maps/regrid.h"

namespace seaway::sea {

namespace {

/// 2 t x <= c x^2 + t^2 / c for any c. Of the product that counts on both sides already, t's share where it grows.
double slow_share_m2(double own_m2, double slow_m2) {
    return own_m2 > 0 ? slow_m2 * slow_m2 / own_m2 : 0.0;
}

/// Of stylised waves what agrees at one interval may agree at no other: then c is this, by which the square of what space misses counts more than is
/// stated: a twentieth of a bound whose margin is a fifth.
constexpr double spared_share = 0.1;

} // namespace

bool has_given(const CascadeModes& modes) {
    bool given = !modes.sines.empty();
    for (std::size_t i = 0; i < modes.h0.size() && !given; ++i)
        given = modes.is_given(i) && modes.h0[i] != std::complex<double>{};
    return given;
}

/// One mode.
struct CascadeWaves::Wave {
    double variance_m2;
    double kx, ky;
    double omega_radps;
    double aspect; ///< of the water's orbits
    bool given;
    double index; ///< on the lattice, any direction
};

/// What a grid misses along each axis. A wave that is missed by `east` and by `north` is missed by their
/// sum in the middle of a cell; halves of what they have in common make the two add up to that in the
/// square.
struct CascadeWaves::Missed {
    WaveSum east, north;
    double common_m2 = 0;

    void add(double variance, double amplitude, double along_x, double along_y, bool given) {
        east.add(variance * along_x * along_x, amplitude * along_x, given);
        north.add(variance * along_y * along_y, amplitude * along_y, given);
        common_m2 += variance * along_x * along_y;
    }
    void count(Motion& motion, double loss_sigmas) const {
        const double given_common_m2 = east.given_m * north.given_m / square(loss_sigmas);
        const double common = std::max(common_m2, given_common_m2);
        motion.east_m2 += east.variance_m2(loss_sigmas) + common;
        motion.north_m2 += north.variance_m2(loss_sigmas) + common;
    }
};

CascadeWaves::CascadeWaves(const CascadeModes& modes, const DepthGlide& glide, int given_cascades)
    : glide_(glide), given_cascades_(std::max(given_cascades, 1)),
      loss_sigmas_(bound_sigmas / std::sqrt(2.0 * given_cascades_)), size_(modes.spec.size),
      compact_size_(size_), spacing_m_(modes.spec.spacing_m()), length_m_(modes.spec.length_m),
      depth_m_(modes.depth_m),
      by_length_(glide.changes() ? 1 + static_cast<std::size_t>(bins_an_octave * std::log2(size_))
                                 : 0),
      rings_(static_cast<std::size_t>(size_)) { // the corners are at 0.71 of it
    for (std::size_t i = 0; i < modes.h0.size(); ++i)
        if (modes.h0[i] != std::complex<double>{})
            omega_max_radps_ = std::max(omega_max_radps_, omega_from_rate(modes.rate[i]));
    omega_fastest_radps_ = omega_max_radps_;
    const double dk = modes.spec.wavenumber_step_radpm();
    double reach = 0; ///< of lattice indices
    Missed missed[3];
    for (int iy = 0; iy < size_; ++iy)
        for (int ix = 0; ix < size_; ++ix) {
            const auto i = static_cast<std::size_t>(iy) * static_cast<std::size_t>(size_) +
                           static_cast<std::size_t>(ix);
            const double variance = 2.0 * std::norm(modes.h0[i]);
            const double kx = dk * signed_index(ix, size_), ky = dk * signed_index(iy, size_);
            if (!(variance > 0))
                continue;
            const double index = std::hypot(signed_index(ix, size_), signed_index(iy, size_));
            reach = std::max(reach, index);
            add({variance, kx, ky, omega_from_rate(modes.rate[i]),
                 orbit_aspect(std::hypot(kx, ky), modes.depth_m), modes.is_given(i), index},
                missed);
        }
    if (modes.sines.empty())
        compact_size_ = smallest_grid(reach, size_);
    if (compact_size_ < size_)
        follows_gain_ = follows_gain(compact_size_);
    for (const SineField& field : modes.sines) {
        const SineError& error = sines_.emplace_back(field, spacing_m_);
        omega_fastest_radps_ = std::max(omega_fastest_radps_, error.omega_max_radps());
        height_.gradient.given_m2 += error.slope_variance();
        for (const SineLine& line : sine_lines(field)) {
            const double k2 = square(line.kx_radpm) + square(line.ky_radpm);
            curvature_.add(line.variance_m2() * square(k2),
                           std::sqrt(2.0 * line.variance_m2()) * k2, true);
        }
        detail_m2_ += error.detail_m2();
        rate_detail_m2ps2_ += error.rate_detail_m2ps2();
    }
    Motion* const motions[] = {&height_, &displacement_, &strain_};
    for (int i = 0; i < 3; ++i)
        missed[i].count(*motions[i], loss_sigmas_);
    given_east_m_ = missed[0].east.given_m;
    given_north_m_ = missed[0].north.given_m;
    const Shares with = with_sines(0);
    height_.east_m2 += with.east_m2;
    height_.north_m2 += with.north_m2;
    for (Motion* motion : {&height_, &displacement_})
        motion->single_m =
            single_precision_share * 4.0 * std::sqrt(motion->whole.variance_m2(bound_sigmas));
    for (const SineField& field : modes.sines) // of those what is largest: they are no sum of many
        height_.single_m += single_precision_share * sine_height_max_m(field);
    strain_.single_m = sampled_slope_error(displacement_.single_m, spacing_m_);
}

void CascadeWaves::add(const Wave& wave, Missed (&missed)[3]) {
    const double share = wave.omega_radps / omega_max_radps_;
    const auto bin = static_cast<std::size_t>(
        std::min(static_cast<int>(share * Motion::bins), Motion::bins - 1));
    const double qx = std::abs(wave.kx) * spacing_m_, qy = std::abs(wave.ky) * spacing_m_;
    const double k = std::hypot(wave.kx, wave.ky);
    const auto count = [&](Motion& motion, Missed& by_grid, double factor, double (*law)(double)) {
        const double variance = wave.variance_m2 * square(factor);
        const double amplitude = std::sqrt(2.0 * variance);
        const double missed_east = law(qx), missed_north = law(qy);
        motion.by_frequency[bin].add(variance, amplitude, wave.given);
        motion.missed_by_frequency[bin].east_m2 += variance * missed_east;
        motion.missed_by_frequency[bin].north_m2 += variance * missed_north;
        motion.whole.add(variance, amplitude, wave.given);
        motion.gradient.add(variance * square(k), amplitude * k, wave.given);
        by_grid.add(variance, amplitude, missed_east, missed_north, wave.given);
    };
    count(height_, missed[0], 1.0, spline_error);
    count(displacement_, missed[1], wave.aspect, spline_error);
    count(strain_, missed[2], wave.aspect * k, spline_slope_error);
    curvature_.add(wave.variance_m2 * square(k * k), std::sqrt(2.0 * wave.variance_m2) * k * k,
                   wave.given);
    if (glide_.changes())
        by_length_[static_cast<std::size_t>(bins_an_octave * std::log2(wave.index))].add(
            wave.variance_m2, std::sqrt(2.0 * wave.variance_m2), wave.given);
    Ring& ring = rings_[static_cast<std::size_t>(wave.index)];
    const auto count_ring = [&](WaveSum& sum, double factor) {
        const double part = wave.variance_m2 * square(factor);
        sum.add(part, std::sqrt(2.0 * part), wave.given);
    };
    count_ring(ring.height, 1.0);
    count_ring(ring.displacement, wave.aspect);
    count_ring(ring.slope, k);
    count_ring(ring.strain, wave.aspect * k);
    const double detail =
        wave.variance_m2 * (2.0 - 2.0 * std::cos(qx)) * (2.0 - 2.0 * std::cos(qy));
    detail_m2_ += detail;
    rate_detail_m2ps2_ += detail * square(wave.omega_radps);
}

bool CascadeWaves::can_be_cut() const {
    return sines_.empty() && Regrid::takes(size_);
}

double CascadeWaves::follows_gain(int size) const {
    return Orbits(size, length_m_, depth_m_).gain();
}

CutWaves CascadeWaves::cut(int size) const {
    Ring missed;
    for (auto n = static_cast<std::size_t>(size / 2); n < rings_.size(); ++n) {
        missed.height.add(rings_[n].height, 1.0);
        missed.displacement.add(rings_[n].displacement, 1.0);
        missed.slope.add(rings_[n].slope, 1.0);
        missed.strain.add(rings_[n].strain, 1.0);
    }
    const auto rms = [this](const WaveSum& sum, double sigmas) {
        return std::sqrt(sum.variance_m2(sigmas / std::sqrt(given_cascades_)));
    };
    return {rms(missed.height, bound_sigmas), rms(missed.displacement, bound_sigmas),
            rms(missed.slope, bound_sigmas), rms(missed.strain, fold_sigmas)};
}

bool CascadeWaves::told_by(TimeUs interval_us) const {
    return omega_fastest_radps_ * seconds_from_us(interval_us) <= hermite_phase_max;
}

double CascadeWaves::time_rms(const Motion& motion, TimeUs interval_us) const {
    WaveSum missed;
    for (int bin = 0; bin < Motion::bins; ++bin)
        missed.add(motion.by_frequency[static_cast<std::size_t>(bin)],
                   missed_in_time(bin, interval_us));
    return std::sqrt(missed.variance_m2(loss_sigmas_));
}

double CascadeWaves::missed_in_time(int bin, TimeUs interval_us) const {
    const double u = omega_max_radps_ * (bin + 1) / Motion::bins * seconds_from_us(interval_us);
    return glide_.us > 0
               ? gliding_error(u, static_cast<double>(interval_us) / static_cast<double>(glide_.us))
               : hermite_error(u);
}

CascadeWaves::OrbitsMissed CascadeWaves::orbits_missed(TimeUs interval_us) const {
    constexpr double margin = 1.2;    // within a bin, and of waves that turn meanwhile
    constexpr double deep_enough = 8; // coth is 1 to 2e-7
    WaveSum displacement, strain;
    for (std::size_t bin = 0; bin < by_length_.size(); ++bin) {
        const double k = 2.0 * std::numbers::pi / length_m_ *
                         std::exp2((static_cast<double>(bin) + 0.5) / bins_an_octave);
        if (by_length_[bin].mean_square_m2() == 0 || k * depth_m_ > deep_enough)
            continue;
        const double missed = margin * orbit_error(k, glide_, interval_us);
        displacement.add(by_length_[bin], missed);
        strain.add(by_length_[bin], missed * k);
    }
    return {std::sqrt(displacement.variance_m2(loss_sigmas_)),
            std::sqrt(strain.variance_m2(loss_sigmas_))};
}

Motion::Missed CascadeWaves::in_common(const Motion& motion, TimeUs interval_us) const {
    Motion::Missed common;
    for (int bin = 0; bin < Motion::bins; ++bin) {
        const Motion::Missed& missed = motion.missed_by_frequency[static_cast<std::size_t>(bin)];
        const double in_time = missed_in_time(bin, interval_us);
        common.east_m2 += in_time * missed.east_m2;
        common.north_m2 += in_time * missed.north_m2;
    }
    return common;
}

double CascadeWaves::as_rms(double bound_m) const {
    return std::sqrt(given_cascades_) * bound_m / bound_sigmas;
}

CascadeWaves::AtMost CascadeWaves::modes_missed(TimeUs interval_us) const {
    double time_m = 0;
    for (int bin = 0; bin < Motion::bins && interval_us > 0; ++bin)
        time_m += height_.by_frequency[static_cast<std::size_t>(bin)].given_m *
                  missed_in_time(bin, interval_us);
    return {as_rms(time_m), as_rms(given_east_m_), as_rms(given_north_m_)};
}

CascadeWaves::Shares CascadeWaves::with_sines(TimeUs interval_us) const {
    if (sines_.empty())
        return {};
    const AtMost sines = sines_missed(interval_us), modes = modes_missed(interval_us);
    const auto both = [&](double AtMost::*a, double AtMost::*b) {
        return modes.*a * sines.*b + modes.*b * sines.*a;
    };
    const double axes_m2 = sines.east_m * sines.north_m + both(&AtMost::east_m, &AtMost::north_m);
    const auto own_m2 = [&](double AtMost::*part) {
        return square(sines.*part) + both(part, part);
    };
    return {own_m2(&AtMost::time_m), own_m2(&AtMost::east_m) + axes_m2,
            own_m2(&AtMost::north_m) + axes_m2,
            sines.agrees * sines.time_m * sines.east_m + both(&AtMost::time_m, &AtMost::east_m),
            sines.agrees * sines.time_m * sines.north_m + both(&AtMost::time_m, &AtMost::north_m)};
}

CascadeWaves::AtMost CascadeWaves::sines_missed(TimeUs interval_us) const {
    AtMost all;
    double largest_m = 0;
    for (const SineError& sine : sines_) {
        const SineError::Time time =
            interval_us > 0 ? sine.time(interval_us, glide_.us) : SineError::Time{};
        const double time_m = as_rms(time.missed_m);
        const double space_m = as_rms(sine.east_m()) + as_rms(sine.north_m());
        all.time_m += time_m;
        all.east_m += as_rms(sine.east_m());
        all.north_m += as_rms(sine.north_m());
        largest_m +=
            std::sqrt(square(time_m) + square(space_m) + 2.0 * time.agrees * time_m * space_m);
    }
    const double space_m = all.east_m + all.north_m, product_m2 = 2.0 * all.time_m * space_m;
    if (product_m2 > 0)
        all.agrees = std::clamp(
            (square(largest_m) - square(all.time_m) - square(space_m)) / product_m2, 0.0, 1.0);
    return all;
}

CascadeLoss CascadeWaves::loss(TimeUs interval_us) const {
    const auto of = [&](const Motion& motion) {
        const Motion::Missed common = in_common(motion, interval_us);
        MapLoss loss;
        loss.time_m =
            std::sqrt(square(time_rms(motion, interval_us)) + common.east_m2 + common.north_m2);
        loss.east_m = std::sqrt(motion.east_m2 + common.east_m2);
        loss.north_m = std::sqrt(motion.north_m2 + common.north_m2);
        return loss;
    };
    CascadeLoss loss{of(height_), of(displacement_)};
    loss.displacement.time_m =
        std::hypot(loss.displacement.time_m, orbits_missed(interval_us).displacement_m);
    const Shares with = with_sines(interval_us);
    MapLoss& height = loss.height;
    height.time_m =
        std::sqrt(square(height.time_m) + with.time_m2 + with.time_east_m2 + with.time_north_m2);
    height.east_m = std::sqrt(square(height.east_m) + with.time_east_m2);
    height.north_m = std::sqrt(square(height.north_m) + with.time_north_m2);
    return loss;
}

double CascadeWaves::slow_rms(const Motion& motion, TimeUs interval_us, TimeUs slow_us) const {
    const Motion::Missed own = in_common(motion, interval_us), slow = in_common(motion, slow_us);
    return std::sqrt(square(time_rms(motion, slow_us)) + slow_share_m2(own.east_m2, slow.east_m2) +
                     slow_share_m2(own.north_m2, slow.north_m2));
}

CascadeWaves::SlowLoss CascadeWaves::slow_loss(TimeUs interval_us, TimeUs slow_us) const {
    const Shares own = with_sines(interval_us), slow = with_sines(slow_us);
    return {std::sqrt(
                square(slow_rms(height_, interval_us, slow_us)) + slow.time_m2 +
                slow_share_m2(own.time_east_m2 + spared_share * own.east_m2, slow.time_east_m2) +
                slow_share_m2(own.time_north_m2 + spared_share * own.north_m2, slow.time_north_m2)),
            std::hypot(slow_rms(displacement_, interval_us, slow_us),
                       orbits_missed(slow_us).displacement_m)};
}

double CascadeWaves::time_costs_m2(TimeUs interval_us, double sideways_weight) const {
    const CascadeLoss all = loss(interval_us);
    const auto beside_space = [](const MapLoss& loss, const Motion& motion) {
        return loss.interpolation_variance_m2() - motion.east_m2 - motion.north_m2;
    };
    return beside_space(all.height, height_) +
           square(sideways_weight) * beside_space(all.displacement, displacement_);
}

double CascadeWaves::time_strain_rms(TimeUs interval_us) const {
    return std::hypot(time_rms(strain_, interval_us), orbits_missed(interval_us).strain);
}

double CascadeWaves::strain_rms(TimeUs interval_us) const {
    const Motion::Missed common = in_common(strain_, interval_us);
    return std::sqrt(square(time_strain_rms(interval_us)) + strain_.east_m2 + strain_.north_m2 +
                     2.0 * (common.east_m2 + common.north_m2));
}

} // namespace seaway::sea
