// SPDX-License-Identifier: Apache-2.0
// Maps of a wind sea to feed the codec with: JONSWAP (Hasselmann et al. 1973 growth, gamma 3.3),
// cos-2s spreading with s = 8, random phases, by a plain separable sum. Independent of sea/, so
// that the codec's acceptance numbers do not move with it.
#pragma once

#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <vector>

namespace seaway::protocol::tests {

struct SampleBand {
    double length_m;
    double k_lo_radpm;
    double k_hi_radpm;
};

/// The bands of tiles of 1000, 200 and 40 m: each starts six steps out on its own lattice.
inline std::vector<SampleBand> sample_bands() {
    const double two_pi = 2.0 * std::numbers::pi;
    return {{1000, two_pi / 1000, two_pi * 6 / 200},
            {200, two_pi * 6 / 200, two_pi * 6 / 40},
            {40, two_pi * 6 / 40, std::numbers::pi * 250 / 40}};
}

/// One-sided S(omega), m2 s.
inline double sample_jonswap(double omega, double wind_mps, double fetch_m) {
    const double g = 9.81;
    const double alpha = 0.076 * std::pow(wind_mps * wind_mps / (fetch_m * g), 0.22);
    const double peak = 22.0 * std::cbrt(g * g / (wind_mps * fetch_m));
    const double sigma = omega <= peak ? 0.07 : 0.09;
    const double r = std::exp(-std::pow((omega - peak) / (sigma * peak), 2) / 2);
    return alpha * g * g * std::pow(omega, -5) * std::exp(-1.25 * std::pow(peak / omega, 4)) *
           std::pow(3.3, r);
}

enum class SampleMap { height, displacement_x, displacement_y };

/// size x size samples, m.
inline std::vector<float> sample_map(const SampleBand& band, int size, double wind_mps,
                                     double fetch_m, SampleMap map) {
    using Complex = std::complex<double>;
    const double g = 9.81;
    const double step = 2.0 * std::numbers::pi / band.length_m;
    const double spread_norm =
        std::tgamma(9.0) / (2 * std::sqrt(std::numbers::pi) * std::tgamma(8.5));
    const auto n = static_cast<std::size_t>(size);
    std::mt19937_64 numbers(17);
    std::normal_distribution<double> normal;
    std::vector<Complex> turn(n);
    for (std::size_t i = 0; i < n; ++i)
        turn[i] = std::polar(1.0, 2.0 * std::numbers::pi * static_cast<double>(i) / size);
    std::vector<Complex> rows(n * n); // [ky][x] after the first sum
    const int half = size / 2;
    for (int ny = -half + 1; ny < half; ++ny) {
        Complex* row = &rows[static_cast<std::size_t>(ny & (size - 1)) * n];
        for (int nx = -half + 1; nx < half; ++nx) {
            const double kx = nx * step;
            const double ky = ny * step;
            const double k = std::hypot(kx, ky);
            const Complex draw(normal(numbers), normal(numbers));
            if (k < band.k_lo_radpm || k >= band.k_hi_radpm)
                continue;
            const double omega = std::sqrt(g * k);
            const double spread =
                spread_norm * std::pow(std::abs(std::cos(std::atan2(ky, kx) / 2)), 16);
            const double psi =
                sample_jonswap(omega, wind_mps, fetch_m) * spread * g / (2 * omega * k);
            // eta = Re(2 h): the partner at -k need not be drawn
            Complex h = draw * std::sqrt(psi) * step;
            if (map == SampleMap::displacement_x)
                h *= Complex(0, kx / k);
            if (map == SampleMap::displacement_y)
                h *= Complex(0, ky / k);
            for (std::size_t x = 0; x < n; ++x)
                row[x] += h * turn[(static_cast<std::size_t>(nx & (size - 1)) * x) & (n - 1)];
        }
    }
    std::vector<float> out(n * n);
    std::vector<double> line(n);
    for (std::size_t y = 0; y < n; ++y) {
        line.assign(n, 0);
        for (std::size_t ky = 0; ky < n; ++ky) {
            const Complex t = turn[(ky * y) & (n - 1)];
            for (std::size_t x = 0; x < n; ++x)
                line[x] += rows[ky * n + x].real() * t.real() - rows[ky * n + x].imag() * t.imag();
        }
        for (std::size_t x = 0; x < n; ++x)
            out[y * n + x] = static_cast<float>(line[x]);
    }
    return out;
}

} // namespace seaway::protocol::tests
