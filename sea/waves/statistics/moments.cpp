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
    double east = 0;
    double north = 0;

    /// `direction`: mean of e^{i phi} over this energy.
    void add(double energy, double omega, std::complex<double> direction) {
        m0 += energy;
        m1 += energy * omega;
        m2 += energy * omega * omega;
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

/// Waves given one by one. Rows of one wave are one wave: they add up with their phases, as they do in a tile.
struct GivenWaves {
    double length_m;
    std::map<std::pair<int, int>, std::complex<double>> amplitudes_m;
};

std::vector<GivenWaves> given_waves(const SeaState& sea) {
    std::vector<GivenWaves> tiles;
    for (const WaveSystem& system : sea.systems) {
        const auto* modes = std::get_if<ExplicitModes>(&system);
        if (!modes)
            continue;
        auto tile = std::ranges::find_if(tiles, [&](const GivenWaves& held) {
            return same_tile_length(held.length_m, modes->length_m);
        });
        if (tile == tiles.end())
            tile = tiles.insert(tile, {modes->length_m, {}});
        for (const ExplicitMode& mode : modes->modes)
            tile->amplitudes_m[{mode.nx, mode.ny}] +=
                mode.amplitude_m * std::polar(1.0, mode.phase_rad);
    }
    return tiles;
}

/// Waves that are not drawn from a spectrum: f(variance, omega, k, direction, still) for each;
/// `still`: it moves nothing sideways.
template <class F>
void over_explicit(const SeaState& sea, const F& f) {
    const Dispersion dispersion = sea.dispersion();
    for (const GivenWaves& tile : given_waves(sea))
        for (const auto& [at, amplitude_m] : tile.amplitudes_m) {
            const double k = two_pi / tile.length_m * std::hypot(at.first, at.second);
            const double amplitude = sea.height_scale * std::abs(amplitude_m);
            if (k > 0.0 && amplitude > 0.0)
                f(0.5 * amplitude * amplitude, dispersion.omega(k), k,
                  std::atan2(at.second, at.first), false);
        }
    for (std::size_t s = 0; s < sea.systems.size(); ++s) {
        if (const auto* ramps = std::get_if<SineRamps>(&sea.systems[s])) {
            SineField field = sine_field(*ramps, sea.seed, static_cast<std::uint32_t>(s),
                                         dispersion, sea.height_scale, 0);
            for (NoiseOctave& octave : field.octaves)
                octave.variance = noise_variance; // expected, whatever the seed
            for (const SineLine& line : sine_lines(field))
                if (line.variance_m2() > 0.0)
                    f(line.variance_m2(), line.omega_radps,
                      std::hypot(line.kx_radpm, line.ky_radpm),
                      std::atan2(line.ky_radpm, line.kx_radpm), true);
        }
    }
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

/// Of energies by frequency, whatever the directions, where most of those that move is; 0: none does. Waves of one length on tiles of several
/// lengths differ in their last bits: they are one line.
double strongest_line(const std::map<double, double>& energy_by_omega) {
    double best_omega = 0.0, best = 0.0, line_omega = 0.0, sum = 0.0;
    for (const auto& [omega, energy] : energy_by_omega) {
        if (!moves(omega))
            continue;
        if (omega > line_omega * (1.0 + 1e-9)) {
            line_omega = omega;
            sum = 0.0;
        }
        sum += energy;
        if (sum > best) {
            best = sum;
            best_omega = line_omega;
        }
    }
    return best_omega;
}

SeaStatistics requested_statistics(const SeaState& sea,
                                   std::span<const DirectionalSpectrum> spectra, double finest_k_hi,
                                   double& peak_bin_period_s) {
    const Dispersion dispersion = sea.dispersion();
    EnergySums sums;
    for (const DirectionalSpectrum& spectrum : spectra) {
        for (const QuadratureNode& node : frequency_nodes(spectrum, 0.0, infinite)) {
            const double energy = node.weight * spectrum.frequency_density(node.x);
            if (energy > 0.0)
                sums.add(energy, node.x, spectrum.direction_moment(node.x));
        }
        for (const QuadratureNode& node :
             frequency_nodes(spectrum, 0.0, dispersion.omega(finest_k_hi))) {
            const double k = dispersion.wavenumber(node.x);
            sums.add_gradients(node.weight * spectrum.frequency_density(node.x), k,
                               orbit_aspect(k, sea.depth_m));
        }
    }
    std::map<double, double> lines;
    over_explicit(sea, [&](double energy, double omega, double k, double direction, bool still) {
        sums.add(energy, omega, std::polar(1.0, direction));
        sums.add_gradients(energy, k, still ? 0.0 : orbit_aspect(k, sea.depth_m));
        lines[omega] += energy;
    });
    if (spectra.empty())
        return statistics(sums, strongest_line(lines));
    const DirectionalSpectrum::Peak peak = peak_of(spectra);
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
    over_explicit(sea, [&](double energy, double omega, double, double, bool) {
        sum += omega_lo_radps <= omega && omega < omega_hi_radps ? energy : 0.0;
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
double add_realised(const CascadeModes& cascade, EnergySums& sums, PeakFinder& peak) {
    double variance = 0.0;
    const double step = cascade.spec.wavenumber_step_radpm();
    const auto add = [&](double energy, double kx, double ky, double omega) {
        const double k = std::hypot(kx, ky);
        if (!(energy > 0.0 && k > 0.0))
            return;
        sums.add(energy, omega, {kx / k, ky / k});
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
        sums.add_strain(energy, k, orbit_aspect(k, cascade.depth_m)); // stylised waves stand still
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
        variance.realised_m2 = add_realised(cascade, sums, peak);
        if (!cascade.carries_spectra)
            continue;
        for (const DirectionalSpectrum& s : spectra)
            variance.requested_m2 += kept_variance(s, dispersion, cascade.band);
    }
    add_expected(sea, realization, summary);
    summary.realised = statistics(sums, peak.peak_omega_radps());
    add_losses(spectra, dispersion, all, summary);
    return summary;
}

} // namespace seaway::sea
