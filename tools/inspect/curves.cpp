// SPDX-License-Identifier: Apache-2.0
#include "tools/inspect/curves.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace seaway::inspect {

SeaSpectrum::SeaSpectrum(const sea::SeaState& sea) : dispersion_(sea.dispersion()) {
    for (const sea::WaveSystem& system : sea.systems) {
        sea::DirectionalSpectrum spectrum(system, sea);
        if (!spectrum.empty())
            systems_.push_back(std::move(spectrum));
    }
}

double SeaSpectrum::density(double omega) const {
    double sum = 0.0;
    for (const sea::DirectionalSpectrum& s : systems_)
        sum += s.frequency_density(omega);
    return sum;
}

double SeaSpectrum::kept_density(double omega) const {
    const double k = dispersion_.wavenumber(omega);
    double sum = 0.0;
    for (const sea::DirectionalSpectrum& s : systems_)
        sum += s.ring(k).density * k / dispersion_.group_speed(k);
    return sum;
}

double SeaSpectrum::spreading(double omega, double towards_rad) const {
    const double k = dispersion_.wavenumber(omega);
    double here = 0.0;
    double around = 0.0;
    for (const sea::DirectionalSpectrum& s : systems_) {
        here += s.density(k * std::cos(towards_rad), k * std::sin(towards_rad));
        around += s.ring(k).density;
    }
    return around > 0.0 ? here / around : 0.0;
}

double SeaSpectrum::lowest_peak_radps() const {
    double lowest = std::numeric_limits<double>::infinity();
    for (const sea::DirectionalSpectrum& s : systems_)
        lowest = std::min(lowest, s.peak_omega_radps());
    return lowest;
}

double SeaSpectrum::highest_peak_radps() const {
    double highest = 0.0;
    for (const sea::DirectionalSpectrum& s : systems_)
        highest = std::max(highest, s.peak_omega_radps());
    return highest;
}

std::vector<plot::Point> realised_density(const sea::CascadeModes& modes,
                                          const sea::Dispersion& dispersion) {
    const int size = modes.spec.size;
    const double step = modes.spec.wavenumber_step_radpm();
    std::vector<double> rings(static_cast<std::size_t>(size));
    for (int iy = 0; iy < size; ++iy)
        for (int ix = 0; ix < size; ++ix) {
            const double n = std::hypot(sea::signed_index(ix, size), sea::signed_index(iy, size));
            rings[static_cast<std::size_t>(std::lround(n))] +=
                2.0 * std::norm(modes.h0[static_cast<std::size_t>(iy * size + ix)]);
        }
    std::vector<plot::Point> points;
    for (int first = 1; first < size;) {
        const int last = std::max(first, static_cast<int>(first * 1.1));
        double energy = 0.0;
        for (int n = first; n <= std::min(last, size - 1); ++n)
            energy += rings[static_cast<std::size_t>(n)];
        double lo = std::max((first - 0.5) * step, modes.band.k_lo_radpm);
        double hi = std::min((last + 0.5) * step, modes.band.k_hi_radpm);
        if (hi <= lo) { // explicit waves live outside the band, too
            lo = (first - 0.5) * step;
            hi = (last + 0.5) * step;
        }
        // A ring that the band only grazes holds too few modes to say anything.
        if (energy > 0.0 && hi - lo > 0.5 * (last + 1 - first) * step)
            points.push_back({dispersion.omega(0.5 * (lo + hi)),
                              energy / (dispersion.omega(hi) - dispersion.omega(lo))});
        first = last + 1;
    }
    return points;
}

std::vector<ExplicitWave> explicit_waves(const sea::Realization& sea) {
    std::vector<ExplicitWave> waves;
    for (const sea::CascadeModes& modes : sea.cascades) {
        const int size = modes.spec.size;
        for (int i = 0; i < size * size; ++i) {
            const auto index = static_cast<std::size_t>(i);
            if (modes.h0[index] != std::complex<double>{})
                waves.push_back({sea::omega_from_rate(modes.rate[index]),
                                 std::atan2(sea::signed_index(i / size, size),
                                            sea::signed_index(i % size, size)),
                                 2.0 * std::abs(modes.h0[index])});
        }
        for (const sea::SineField& field : modes.sines)
            for (const sea::SineLine& line : sine_lines(field))
                waves.push_back({line.omega_radps, std::atan2(line.ky_radpm, line.kx_radpm),
                                 std::sqrt(2.0 * line.variance_m2())});
    }
    return waves;
}

FrequencyRange frequency_range(const Report& report, const SeaSpectrum& spectrum) {
    const sea::Dispersion dispersion = report.scene.sea.dispersion();
    double k_lo = std::numeric_limits<double>::infinity();
    double k_hi = 0.0;
    for (const sea::CascadeModes& modes : report.sea->cascades) {
        k_lo = std::min(k_lo, modes.band.k_lo_radpm);
        k_hi = std::max(k_hi, modes.band.k_hi_radpm);
    }
    const double begin = dispersion.omega(k_lo);
    const double end = dispersion.omega(k_hi);
    if (spectrum.empty())
        return {0.8 * begin, 1.3 * end};
    return {std::max(0.5 * begin, 0.45 * spectrum.lowest_peak_radps()),
            std::max(1.4 * end, 3.0 * spectrum.highest_peak_radps())};
}

} // namespace seaway::inspect
