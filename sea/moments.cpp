// SPDX-License-Identifier: Apache-2.0
#include "sea/moments.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sea/directional_spectrum.h"
#include "sea/quadrature.h"
#include "sea/realize.h"

namespace seaway::sea {

namespace {

/// Sums over energy, from integrals or from modes.
struct EnergySums {
    double m0 = 0;
    double m1 = 0;
    double m2 = 0;
    double slope = 0;
    double east = 0;
    double north = 0;

    void add(double energy, double omega) {
        m0 += energy;
        m1 += energy * omega;
        m2 += energy * omega * omega;
    }
};

SeaStatistics statistics(const EnergySums& sums, double peak_omega_radps) {
    SeaStatistics s;
    if (!(sums.m0 > 0.0))
        return s;
    s.significant_height_m = 4.0 * std::sqrt(sums.m0);
    s.peak_period_s = two_pi / peak_omega_radps;
    s.zero_crossing_period_s = two_pi * std::sqrt(sums.m0 / sums.m2);
    s.mean_period_s = two_pi * sums.m0 / sums.m1;
    s.mean_towards_rad = std::atan2(sums.north, sums.east);
    const double r1 = std::min(1.0, std::hypot(sums.east, sums.north) / sums.m0);
    s.spread_rad = std::sqrt(2.0 * (1.0 - r1));
    s.mean_square_slope = sums.slope;
    return s;
}

/// Nodes of a quadrature over [lo, hi] in ln w, with a break at the peak, where JONSWAP's sigma
/// jumps. `x` is w, `weight` includes dw.
std::vector<QuadratureNode> frequency_nodes(double lo, double hi, double peak) {
    std::vector<QuadratureNode> nodes;
    const auto add = [&nodes](double a, double b) {
        const int panels = std::max(1, static_cast<int>(std::ceil((b - a) / 0.12)));
        const double half = 0.5 * (b - a) / panels;
        for (int p = 0; p < panels; ++p)
            for (const QuadratureNode& node : gauss_legendre_16)
                for (const double side : {-1.0, 1.0}) {
                    const double omega = std::exp(a + (2 * p + 1 + side * node.x) * half);
                    nodes.push_back({omega, node.weight * half * omega});
                }
    };
    if (!(lo < hi))
        return nodes;
    if (lo < peak && peak < hi) {
        add(std::log(lo), std::log(peak));
        add(std::log(peak), std::log(hi));
    } else {
        add(std::log(lo), std::log(hi));
    }
    return nodes;
}

/// Below a quarter of the peak, exp(-5/4 4^4) leaves nothing; above 1000 peaks, 1e-12 of m0 and
/// 1e-6 of m2.
constexpr double lowest_over_peak = 0.25;
constexpr double highest_over_peak = 1000.0;

double variance_between(const DirectionalSpectrum& spectrum, double lo, double hi) {
    const double peak = spectrum.peak_omega_radps();
    double sum = 0.0;
    for (const QuadratureNode& node : frequency_nodes(std::max(lo, lowest_over_peak * peak),
                                                      std::min(hi, highest_over_peak * peak), peak))
        sum += node.weight * spectrum.frequency_density(node.x);
    return sum;
}

/// Variance that fade and cut-offs leave between two wavenumbers.
double kept_variance(const DirectionalSpectrum& spectrum, const Dispersion& dispersion, Band band) {
    const double peak = spectrum.peak_omega_radps();
    double sum = 0.0;
    for (const QuadratureNode& node : frequency_nodes(
             std::max(dispersion.omega(band.k_lo_radpm), lowest_over_peak * peak),
             std::min(dispersion.omega(band.k_hi_radpm), highest_over_peak * peak), peak)) {
        const double k = dispersion.wavenumber(node.x);
        sum += node.weight * spectrum.ring(k).density * k / dispersion.group_speed(k);
    }
    return sum;
}

std::vector<DirectionalSpectrum> spectra_of(const SeaState& sea) {
    std::vector<DirectionalSpectrum> spectra;
    for (const WaveSystem& system : sea.systems) {
        DirectionalSpectrum spectrum(system, sea);
        if (!spectrum.empty())
            spectra.push_back(spectrum);
    }
    return spectra;
}

/// The frequency at which the sum of all systems is largest.
double peak_of(std::span<const DirectionalSpectrum> spectra) {
    double lo = spectra.front().peak_omega_radps();
    double hi = lo;
    for (const DirectionalSpectrum& s : spectra) {
        lo = std::min(lo, s.peak_omega_radps());
        hi = std::max(hi, s.peak_omega_radps());
    }
    constexpr double step = 1.0005;
    double best_omega = lo;
    double best = 0.0;
    for (double omega = 0.5 * lo; omega < 2.0 * hi; omega *= step) {
        double density = 0.0;
        for (const DirectionalSpectrum& s : spectra)
            density += s.frequency_density(omega);
        if (density > best) {
            best = density;
            best_omega = omega;
        }
    }
    return best_omega;
}

SeaStatistics requested_statistics(std::span<const DirectionalSpectrum> spectra,
                                   const Dispersion& dispersion, double finest_k_hi) {
    EnergySums sums;
    for (const DirectionalSpectrum& spectrum : spectra) {
        const double peak = spectrum.peak_omega_radps();
        for (const QuadratureNode& node :
             frequency_nodes(lowest_over_peak * peak, highest_over_peak * peak, peak)) {
            const double energy = node.weight * spectrum.frequency_density(node.x);
            if (!(energy > 0.0))
                continue;
            const double r1 = spectrum.spreading(node.x).first_moment();
            sums.add(energy, node.x);
            sums.east += energy * r1 * std::cos(spectrum.towards_rad());
            sums.north += energy * r1 * std::sin(spectrum.towards_rad());
        }
        const double omega_hi = dispersion.omega(finest_k_hi);
        for (const QuadratureNode& node :
             frequency_nodes(lowest_over_peak * peak, omega_hi, peak)) {
            const double k = dispersion.wavenumber(node.x);
            sums.slope += node.weight * k * k * spectrum.frequency_density(node.x);
        }
    }
    return spectra.empty() ? SeaStatistics{} : statistics(sums, peak_of(spectra));
}

/// Peak of a realised sea: sum w E^4 / sum E^4 over narrow bins of equal ratio (Young 1995), which
/// one lucky mode cannot pull away.
class PeakFinder {
  public:
    void add(double energy, double omega) {
        const int bin = static_cast<int>(std::floor(std::log(omega) / bin_width)) + offset;
        if (bin >= 0 && bin < static_cast<int>(bins_.size())) {
            bins_[static_cast<std::size_t>(bin)].first += energy;
            bins_[static_cast<std::size_t>(bin)].second += energy * omega;
        }
    }
    double peak_omega_radps() const {
        double weights = 0.0;
        double sum = 0.0;
        for (const auto& [energy, moment] : bins_) {
            if (!(energy > 0.0))
                continue;
            const double omega = moment / energy;
            const double density = energy / omega;
            const double weight = density * density * density * density;
            weights += weight;
            sum += weight * omega;
        }
        return weights > 0.0 ? sum / weights : 1.0;
    }

  private:
    static constexpr double bin_width = 0.1;
    static constexpr int offset = 120; ///< exp(-12) rad/s
    std::array<std::pair<double, double>, 240> bins_{};
};

/// Calls f(energy, kx, ky, omega) for every mode; energy is its variance averaged over time.
template <class F>
void over_modes(const CascadeModes& cascade, const F& f) {
    const int size = cascade.spec.size;
    const double step = cascade.spec.wavenumber_step_radpm();
    for (int iy = 0; iy < size; ++iy)
        for (int ix = 0; ix < size; ++ix) {
            const auto index = static_cast<std::size_t>(iy * size + ix);
            const double energy = 2.0 * std::norm(cascade.h0[index]);
            if (energy > 0.0)
                f(energy, step * signed_index(ix, size), step * signed_index(iy, size),
                  omega_from_rate(cascade.rate[index]));
        }
}

/// Relative standard deviation of Hs over seeds: sqrt(2 sum E^2) / (2 sum E), E the mean of the
/// variances expected of k and -k (physics.md section 5).
double expected_scatter(std::span<const DirectionalSpectrum> spectra, const CascadeModes& cascade) {
    const double step = cascade.spec.wavenumber_step_radpm();
    const int steps = cascade.spec.size / 2 - 1;
    double sum = 0.0;
    double squares = 0.0;
    // The energy sits in the first rings; beyond 40 steps a mode's share no longer matters.
    const int reach = std::min(steps, 40);
    for (int ny = -reach; ny <= reach; ++ny)
        for (int nx = -reach; nx <= reach; ++nx) {
            if (!cascade.band.contains(step * std::hypot(nx, ny)))
                continue;
            double pair = 0.0;
            for (const DirectionalSpectrum& s : spectra)
                pair += 0.5 * step * step *
                        (s.density(step * nx, step * ny) + s.density(-step * nx, -step * ny));
            sum += pair;
            squares += pair * pair;
        }
    return sum > 0.0 ? std::sqrt(2.0 * squares) / (2.0 * sum) : 0.0;
}

} // namespace

double requested_variance(const SeaState& sea, double omega_lo_radps, double omega_hi_radps) {
    double sum = 0.0;
    for (const DirectionalSpectrum& spectrum : spectra_of(sea))
        sum += variance_between(spectrum, omega_lo_radps, omega_hi_radps);
    return sum;
}

SeaSummary summarize(const SeaState& sea, const Realization& realization) {
    SeaSummary summary;
    const Dispersion dispersion = sea.dispersion();
    const std::vector<DirectionalSpectrum> spectra = spectra_of(sea);
    const double k_end =
        realization.cascades.empty() ? 0.0 : realization.cascades.back().band.k_hi_radpm;
    summary.requested = requested_statistics(spectra, dispersion, k_end);
    for (const DirectionalSpectrum& s : spectra)
        summary.longest_peak_wavelength_m =
            std::max(summary.longest_peak_wavelength_m,
                     two_pi / dispersion.wavenumber(s.peak_omega_radps()));
    EnergySums sums;
    PeakFinder peak;
    double covered = 0.0;
    for (const CascadeModes& cascade : realization.cascades) {
        CascadeVariance& variance = summary.cascades.emplace_back();
        for (const DirectionalSpectrum& s : spectra)
            variance.requested_m2 += kept_variance(s, dispersion, cascade.band);
        over_modes(cascade, [&](double energy, double kx, double ky, double omega) {
            const double k = std::hypot(kx, ky);
            sums.add(energy, omega);
            sums.slope += energy * k * k;
            sums.east += energy * kx / k;
            sums.north += energy * ky / k;
            peak.add(energy, omega);
            variance.realised_m2 += energy;
        });
        variance.expected_scatter = expected_scatter(spectra, cascade);
        covered += variance.requested_m2;
    }
    summary.realised = statistics(sums, peak.peak_omega_radps());
    if (realization.cascades.empty())
        return summary;
    const double infinite = std::numeric_limits<double>::infinity();
    const double omega_lo = dispersion.omega(realization.cascades.front().band.k_lo_radpm);
    const double omega_hi = dispersion.omega(k_end);
    summary.lost_below_m2 = requested_variance(sea, 0.0, omega_lo);
    summary.lost_above_m2 = requested_variance(sea, omega_hi, infinite);
    summary.lost_fade_m2 = std::max(0.0, requested_variance(sea, omega_lo, omega_hi) - covered);
    return summary;
}

} // namespace seaway::sea
