// SPDX-License-Identifier: Apache-2.0
#include "sea/waves/statistics/moments.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <map>
#include <tuple>
#include <utility>
#include <vector>

#include "sea/basics/quadrature.h"
#include "sea/waves/directional_spectrum.h"
#include "sea/waves/realize.h"
#include "sea/waves/statistics/frequency_nodes.h"
#include "sea/waves/statistics/given_waves.h"
#include "sea/waves/statistics/lattice_bias.h"
#include "sea/waves/statistics/peak_finder.h"

namespace seaway::sea {

namespace {

/// Sums over energy, from integrals or from modes.
struct EnergySums {
    double m0 = 0;
    double m1 = 0;
    double m2 = 0;
    double slope = 0;
    double strain = 0;
    double squeeze = 0;
    double east = 0;
    double north = 0;

    /// All but m2. `direction`: mean of e^{i phi} over this energy.
    void add(double energy, double omega, std::complex<double> direction) {
        m0 += energy;
        m1 += energy * omega;
        east += energy * direction.real();
        north += energy * direction.imag();
    }
    /// `aspect` of the orbits of these waves: 0 where they move nothing sideways.
    void add_gradients(double energy, double k, double aspect) {
        slope += energy * k * k;
        add_strain(energy, k, aspect);
    }
    void add_strain(double energy, double k, double aspect) {
        strain += energy * k * k * aspect * aspect;
    }
    /// Of waves towards (cos, sin): lambda_x dDx/dx + lambda_y dDy/dy.
    void add_squeeze(double energy, double k, double aspect, double cos, double sin,
                     const Choppiness& choppiness) {
        const double share = choppiness.x * cos * cos + choppiness.y * sin * sin;
        squeeze += energy * k * k * aspect * aspect * share * share;
    }
};

double period_s(double omega_radps) {
    return moves(omega_radps) ? two_pi / omega_radps : 0.0;
}

/// Below it shares of a variance are no numbers: waves of 1e-140 m.
constexpr double variance_min_m2 = 1e-280;

SeaStatistics statistics(const EnergySums& sums, double peak_omega_radps) {
    SeaStatistics s;
    if (!(sums.m0 > variance_min_m2))
        return s;
    s.significant_height_m = 4.0 * std::sqrt(sums.m0);
    s.peak_period_s = period_s(peak_omega_radps);
    s.zero_crossing_period_s = period_s(std::sqrt(sums.m2 / sums.m0));
    s.mean_period_s = period_s(sums.m1 / sums.m0);
    s.mean_towards_rad = std::atan2(sums.north, sums.east);
    const double r1 = std::min(1.0, std::hypot(sums.east, sums.north) / sums.m0);
    s.spread_rad = std::sqrt(2.0 * (1.0 - r1));
    s.mean_square_slope = sums.slope;
    s.mean_square_strain = sums.strain;
    return s;
}

constexpr double infinite = std::numeric_limits<double>::infinity();

double variance_between(const DirectionalSpectrum& spectrum, double lo, double hi) {
    double sum = 0.0;
    for (const QuadratureNode& node : frequency_nodes(spectrum, lo, hi))
        sum += node.weight * spectrum.frequency_density(node.x);
    return sum;
}

/// Variance that fade and cut-offs leave between two wavenumbers.
double kept_variance(const DirectionalSpectrum& spectrum, const Dispersion& dispersion, Band band) {
    double sum = 0.0;
    for (const QuadratureNode& node : kept_nodes(spectrum, dispersion, band)) {
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

/// Where the sum of all systems is largest; within a measured bin where its parabola is.
DirectionalSpectrum::Peak peak_of(std::span<const DirectionalSpectrum> spectra) {
    double lo = spectra.front().peak_omega_radps();
    double hi = lo;
    for (const DirectionalSpectrum& s : spectra) {
        lo = std::min(lo, s.peak_omega_radps());
        hi = std::max(hi, s.peak_omega_radps());
    }
    constexpr double step = 1.0005;
    double best_omega = lo;
    double best = 0.0;
    const auto look_at = [&](double omega) {
        double density = 0.0;
        for (const DirectionalSpectrum& s : spectra)
            density += s.frequency_density(omega);
        if (density > best) {
            best = density;
            best_omega = omega;
        }
    };
    // Between the steps below lie narrow bins and the very peak that a scene names.
    for (const DirectionalSpectrum& s : spectra)
        look_at(s.peak_omega_radps());
    for (double omega = 0.5 * lo; omega < 2.0 * hi; omega *= step)
        look_at(omega);
    const auto strongest = std::max_element(
        spectra.begin(), spectra.end(),
        [best_omega](const DirectionalSpectrum& a, const DirectionalSpectrum& b) {
            return a.frequency_density(best_omega) < b.frequency_density(best_omega);
        });
    return strongest->peak_around(best_omega);
}

struct StrongestLine {
    double omega_radps = 0.0; ///< 0: none moves
    double energy_m2 = 0.0;
};

/// Of energies by frequency, whatever the directions, where most of those that move is. Waves of one length on tiles of several
/// lengths differ in their last bits: they are one line.
StrongestLine strongest_line(const std::map<double, double>& energy_by_omega) {
    double line_omega = 0.0, sum = 0.0;
    StrongestLine best;
    for (const auto& [omega, energy] : energy_by_omega) {
        if (!moves(omega))
            continue;
        if (omega > line_omega * (1.0 + 1e-9)) {
            line_omega = omega;
            sum = 0.0;
        }
        sum += energy;
        if (sum > best.energy_m2)
            best = {line_omega, sum};
    }
    return best;
}

/// A line is a peak beside that of the spectra where it holds more than these do around it, in as narrow a band as the peak of a realised
/// sea is looked for in.
bool stands_out(const StrongestLine& line, std::span<const DirectionalSpectrum> spectra,
                double peak_omega_radps) {
    const double half = std::exp(0.5 * PeakFinder::bin_width);
    double around_m2 = 0.0;
    for (const DirectionalSpectrum& spectrum : spectra)
        around_m2 += variance_between(spectrum, peak_omega_radps / half, peak_omega_radps * half);
    return line.energy_m2 > around_m2;
}

SeaStatistics requested_statistics(const SeaState& sea,
                                   std::span<const DirectionalSpectrum> spectra, double finest_k_hi,
                                   double& peak_bin_period_s) {
    const Dispersion dispersion = sea.dispersion();
    EnergySums sums;
    for (const DirectionalSpectrum& spectrum : spectra) {
        for (const QuadratureNode& node : frequency_nodes(spectrum, 0.0, infinite)) {
            const double energy = node.weight * spectrum.frequency_density(node.x);
            if (!(energy > 0.0))
                continue;
            sums.add(energy, node.x, spectrum.direction_moment(node.x));
            sums.m2 += spectrum.m2_diverges() ? 0.0 : energy * node.x * node.x;
        }
        for (const QuadratureNode& node :
             frequency_nodes(spectrum, 0.0, dispersion.omega(finest_k_hi))) {
            const double k = dispersion.wavenumber(node.x);
            const double energy = node.weight * spectrum.frequency_density(node.x);
            sums.add_gradients(energy, k, orbit_aspect(k, sea.depth_m));
            sums.m2 += spectrum.m2_diverges() ? energy * node.x * node.x : 0.0;
        }
    }
    std::map<double, double> lines;
    each_given_wave(sea, [&](const GivenWave& wave) {
        sums.add(wave.energy_m2, wave.omega_radps, std::polar(1.0, wave.towards_rad));
        sums.m2 += wave.energy_m2 * wave.omega_radps * wave.omega_radps;
        sums.add_gradients(wave.energy_m2, wave.k_radpm,
                           wave.still ? 0.0 : orbit_aspect(wave.k_radpm, sea.depth_m));
        lines[wave.omega_radps] += wave.energy_m2;
    });
    const StrongestLine line = strongest_line(lines);
    if (spectra.empty())
        return statistics(sums, line.omega_radps);
    const DirectionalSpectrum::Peak peak = peak_of(spectra);
    if (stands_out(line, spectra, peak.omega_radps))
        return statistics(sums, line.omega_radps);
    peak_bin_period_s = peak.bin_omega_radps > 0.0 ? two_pi / peak.bin_omega_radps : 0.0;
    return statistics(sums, peak.omega_radps);
}

/// Calls f(amplitude, nx, ny, omega) for every mode, whose variance is half of its amplitude's square.
template <class F>
void over_modes(const CascadeModes& cascade, const F& f) {
    const int size = cascade.spec.size;
    for (int iy = 0; iy < size; ++iy)
        for (int ix = 0; ix < size; ++ix) {
            const auto index = static_cast<std::size_t>(iy * size + ix);
            if (const std::complex<double> h0 = cascade.h0[index]; h0 != 0.0)
                f(2.0 * h0, signed_index(ix, size), signed_index(iy, size),
                  omega_from_rate(cascade.rate[index]));
        }
}

/// Stylised waves of one tile, by lattice index and frequency: those that are alike in these add up with their phases.
class LinesOfTile {
  public:
    explicit LinesOfTile(double step_radpm) : step_radpm_(step_radpm) {}

    void add(const SineLine& line) {
        const auto steps = [&](double k_radpm) {
            return static_cast<int>(std::lround(k_radpm / step_radpm_));
        };
        Line& held = lines_[key(steps(line.kx_radpm), steps(line.ky_radpm), line.omega_radps)];
        held.amplitude_m += line.amplitude_m;
        held.omega_radps = line.omega_radps;
    }
    /// Takes a mode in; false: no stylised wave is like it.
    bool take(std::complex<double> amplitude_m, int nx, int ny, double omega_radps) {
        const auto like = lines_.empty() ? lines_.end() : lines_.find(key(nx, ny, omega_radps));
        if (like == lines_.end())
            return false;
        like->second.amplitude_m += amplitude_m;
        return true;
    }
    /// f(variance, nx, ny, omega).
    template <class F>
    void each(const F& f) const {
        for (const auto& [key, line] : lines_)
            f(0.5 * std::norm(line.amplitude_m), std::get<0>(key), std::get<1>(key),
              line.omega_radps);
    }

  private:
    /// The last places of a frequency are rounding's.
    using Key = std::tuple<int, int, float>;
    static Key key(int nx, int ny, double omega_radps) {
        return {nx, ny, static_cast<float>(omega_radps)};
    }
    struct Line {
        std::complex<double> amplitude_m;
        double omega_radps = 0;
    };
    double step_radpm_;
    std::map<Key, Line> lines_;
};

} // namespace

double requested_variance(const SeaState& sea, double omega_lo_radps, double omega_hi_radps) {
    double sum = 0.0;
    for (const DirectionalSpectrum& spectrum : spectra_of(sea))
        sum += variance_between(spectrum, omega_lo_radps, omega_hi_radps);
    each_given_wave(sea, [&](const GivenWave& wave) {
        if (omega_lo_radps <= wave.omega_radps && wave.omega_radps < omega_hi_radps)
            sum += wave.energy_m2;
    });
    return sum;
}

double requested_frequency_density(const SeaState& sea, double omega_radps) {
    double sum = 0.0;
    for (const DirectionalSpectrum& spectrum : spectra_of(sea))
        sum += spectrum.frequency_density(omega_radps);
    return sum;
}

namespace {

/// Energy of the realised waves of one cascade, into `sums` and `peak`; gives its variance.
double add_realised(const CascadeModes& cascade, const Choppiness& choppiness, EnergySums& sums,
                    PeakFinder& peak) {
    double variance = 0.0;
    const double step = cascade.spec.wavenumber_step_radpm();
    const auto add = [&](double energy, double kx, double ky, double omega) {
        const double k = std::hypot(kx, ky);
        if (!(energy > 0.0 && k > 0.0))
            return;
        sums.add(energy, omega, {kx / k, ky / k});
        sums.m2 += energy * omega * omega;
        sums.add_gradients(energy, k, 0.0);
        peak.add(energy, omega);
        variance += energy;
    };
    LinesOfTile lines(step);
    for (const SineField& field : cascade.sines)
        for (const SineLine& line : sine_lines(field))
            if (line.octave)
                add(line.variance_m2(), line.kx_radpm, line.ky_radpm, line.omega_radps);
            else
                lines.add(line);
    over_modes(cascade, [&](std::complex<double> amplitude_m, int nx, int ny, double omega) {
        const double energy = 0.5 * std::norm(amplitude_m), k = step * std::hypot(nx, ny);
        if (const double aspect = orbit_aspect(k, cascade.depth_m); k > 0.0) {
            sums.add_strain(energy, k, aspect); // stylised waves stand still
            sums.add_squeeze(energy, k, aspect, step * nx / k, step * ny / k, choppiness);
        }
        if (!lines.take(amplitude_m, nx, ny, omega))
            add(energy, step * nx, step * ny, omega);
    });
    lines.each([&](double energy, int nx, int ny, double omega) {
        add(energy, step * nx, step * ny, omega);
    });
    return variance;
}

/// What the spectra put outside the bands [k_lo, k_hi), and what fade and cut-offs take within.
void add_losses(std::span<const DirectionalSpectrum> spectra, const Dispersion& dispersion,
                Band all, SeaSummary& summary) {
    const double omega_lo = dispersion.omega(all.k_lo_radpm);
    const double omega_hi = dispersion.omega(all.k_hi_radpm);
    for (const DirectionalSpectrum& s : spectra) {
        summary.lost_below_m2 += variance_between(s, 0.0, omega_lo);
        summary.lost_above_m2 += variance_between(s, omega_hi, infinite);
        summary.lost_fade_m2 += std::max(0.0, variance_between(s, omega_lo, omega_hi) -
                                                  kept_variance(s, dispersion, all));
    }
}

} // namespace

double hs_scatter(const SeaSummary& summary) {
    double squares = 0.0;
    double sum = 0.0;
    for (const CascadeVariance& cascade : summary.cascades) {
        squares += std::pow(cascade.expected_scatter * cascade.requested_m2, 2);
        sum += cascade.requested_m2;
    }
    return sum > 0.0 ? std::sqrt(squares) / sum : 0.0;
}

SeaSummary summarize(const SeaState& sea, const Realization& realization) {
    SeaSummary summary;
    const Dispersion dispersion = sea.dispersion();
    const std::vector<DirectionalSpectrum> spectra = spectra_of(sea);
    Band all{0.0, 0.0};
    for (const CascadeModes& cascade : realization.cascades)
        if (cascade.carries_spectra)
            all = {all.k_hi_radpm > 0.0 ? all.k_lo_radpm : cascade.band.k_lo_radpm,
                   cascade.band.k_hi_radpm};
    summary.requested =
        requested_statistics(sea, spectra, all.k_hi_radpm, summary.peak_bin_period_s);
    for (const DirectionalSpectrum& s : spectra)
        summary.longest_peak_wavelength_m =
            std::max(summary.longest_peak_wavelength_m,
                     two_pi / dispersion.wavenumber(s.peak_omega_radps()));
    EnergySums sums;
    PeakFinder peak;
    for (const CascadeModes& cascade : realization.cascades) {
        CascadeVariance& variance = summary.cascades.emplace_back();
        variance.realised_m2 = add_realised(cascade, realization.choppiness, sums, peak);
        if (!cascade.carries_spectra)
            continue;
        for (const DirectionalSpectrum& s : spectra)
            variance.requested_m2 += kept_variance(s, dispersion, cascade.band);
    }
    add_expected(sea, realization, summary);
    summary.realised = statistics(sums, peak.peak_omega_radps());
    summary.rms_squeeze = std::sqrt(sums.squeeze);
    add_losses(spectra, dispersion, all, summary);
    return summary;
}

} // namespace seaway::sea
