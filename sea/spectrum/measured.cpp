// SPDX-License-Identifier: Apache-2.0
#include "sea/spectrum/measured.h"

#include <algorithm>
#include <cmath>

#include "sea/basics/constants.h"

namespace seaway::sea {

namespace {

using Complex = std::complex<double>;

/// How close to a single direction coefficients may come: beyond, the maximum entropy form has
/// peaks that no lattice resolves.
constexpr double first_moment_max = 0.999;
constexpr double second_moment_share_max = 0.98;

/// Bins whose widths differ by less than this factor may share a parabola.
constexpr double alike = 1.75;

} // namespace

MeasuredDirections MeasuredDirections::from_moments(Complex c1, std::optional<Complex> c2) {
    MeasuredDirections d;
    if (std::abs(c1) > first_moment_max) {
        c1 *= first_moment_max / std::abs(c1);
        d.changed_ = true;
    }
    d.c1_ = c1;
    if (!c2) {
        const double r1 = std::abs(c1);
        d.beam_ = Spreading::power(r1 / (1.0 - r1)); // r1 = s / (s + 1)
        return d;
    }
    // |c2 - c1^2| <= 1 - |c1|^2 is what a density that is nowhere negative obeys.
    const double room = second_moment_share_max * (1.0 - std::norm(c1));
    const Complex excess = *c2 - c1 * c1;
    if (std::abs(excess) > room) {
        c2 = c1 * c1 + excess * (room / std::abs(excess));
        d.changed_ = true;
    }
    d.phi1_ = (c1 - *c2 * std::conj(c1)) / (1.0 - std::norm(c1));
    d.phi2_ = *c2 - c1 * d.phi1_;
    d.scale_ = (1.0 - d.phi1_ * std::conj(c1) - d.phi2_ * std::conj(*c2)).real() / two_pi;
    return d;
}

double MeasuredDirections::lines_share(std::size_t directions) {
    const double half_step = pi / static_cast<double>(directions);
    const double sinc = std::sin(half_step) / half_step;
    return sinc * sinc;
}

MeasuredDirections MeasuredDirections::from_table(double first_rad, std::vector<double> density) {
    MeasuredDirections d;
    d.first_rad_ = first_rad;
    const std::size_t density_count = density.size();
    const auto count = static_cast<double>(density_count);
    double sum = 0.0;
    for (const double value : density)
        sum += value;
    for (double& value : density)
        value = value / sum * (count / two_pi);
    d.table_ = std::move(density);
    // The first moment of the straight lines between the entries.
    const double step = two_pi / count;
    for (std::size_t i = 0; i < d.table_.size(); ++i) {
        const double angle = first_rad + static_cast<double>(i) * step;
        d.c1_ += std::polar(d.table_[i] * step, angle);
    }
    d.c1_ *= lines_share(density_count);
    return d;
}

double MeasuredDirections::operator()(double towards_rad) const {
    if (beam_)
        return (*beam_)(towards_rad - std::arg(c1_));
    if (table_.empty()) {
        const Complex turn{std::cos(towards_rad), -std::sin(towards_rad)};
        return scale_ / std::norm(1.0 - turn * (phi1_ + turn * phi2_));
    }
    const auto count = static_cast<double>(table_.size());
    const double turns = (towards_rad - first_rad_) / two_pi;
    const double place = std::min((turns - std::floor(turns)) * count, count);
    const auto i = static_cast<std::size_t>(place) % table_.size();
    const double share = place - std::floor(place);
    return (1.0 - share) * table_[i] + share * table_[(i + 1) % table_.size()];
}

const MeasuredBin* MeasuredSpectrum::find(double omega_radps) const {
    const auto after = std::upper_bound(
        bins.begin(), bins.end(), omega_radps,
        [](double omega, const MeasuredBin& bin) { return omega < bin.omega_lo_radps; });
    if (after == bins.begin() || omega_radps >= std::prev(after)->omega_hi_radps)
        return nullptr;
    return &*std::prev(after);
}

double MeasuredSpectrum::peak_omega_radps() const {
    const auto highest =
        std::max_element(bins.begin(), bins.end(), [](const MeasuredBin& a, const MeasuredBin& b) {
            return a.density < b.density;
        });
    if (highest == bins.end() || !(highest->density > 0.0))
        return 0.0;
    return peak_around(*highest);
}

double MeasuredSpectrum::peak_around(const MeasuredBin& bin) const {
    const auto at = static_cast<std::size_t>(&bin - bins.data());
    if (at == 0 || at + 1 >= bins.size())
        return bin.omega_mid_radps;
    const MeasuredBin& before = bins[at - 1];
    const MeasuredBin& after = bins[at + 1];
    const double width = bin.omega_hi_radps - bin.omega_lo_radps;
    const auto fits = [&](const MeasuredBin& other, double gap) {
        const double ratio = (other.omega_hi_radps - other.omega_lo_radps) / width;
        return std::abs(gap) < 1e-6 * width && ratio > 1.0 / alike && ratio < alike &&
               other.density <= bin.density;
    };
    if (!fits(before, bin.omega_lo_radps - before.omega_hi_radps) ||
        !fits(after, after.omega_lo_radps - bin.omega_hi_radps))
        return bin.omega_mid_radps;
    // Newton's divided differences through (middle, density) of the three.
    const double left =
        (bin.density - before.density) / (bin.omega_mid_radps - before.omega_mid_radps);
    const double right =
        (after.density - bin.density) / (after.omega_mid_radps - bin.omega_mid_radps);
    const double bend = (right - left) / (after.omega_mid_radps - before.omega_mid_radps);
    if (!(bend < 0.0))
        return bin.omega_mid_radps; // three bins of one height
    return 0.5 * (before.omega_mid_radps + bin.omega_mid_radps) - 0.5 * left / bend;
}

} // namespace seaway::sea
