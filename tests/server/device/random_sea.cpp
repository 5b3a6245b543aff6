// SPDX-License-Identifier: Apache-2.0
#include "tests/server/device/random_sea.h"

#include <cmath>
#include <numbers>
#include <random>

#include "tests/support/field_law.h"

namespace seaway::server {

namespace {

constexpr double two_pi = 2 * std::numbers::pi;
using Complex = std::complex<double>;

std::size_t slot(int nx, int ny, int size) {
    return static_cast<std::size_t>((ny + size) % size) * static_cast<std::size_t>(size) +
           static_cast<std::size_t>((nx + size) % size);
}

sea::CascadeModes empty(int size, double length_m) {
    const std::size_t points = static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
    sea::CascadeModes cascade{.spec = {length_m, size},
                              .band = {0, 0.6 * std::numbers::pi * size / length_m},
                              .h0 = {},
                              .rate = {}};
    cascade.h0.resize(points);
    cascade.rate.resize(points);
    return cascade;
}

} // namespace

RandomSea::RandomSea(int size, double length_m, unsigned seed, sea::Choppiness choppiness,
                     double share_of_nyquist)
    : realization_(std::make_shared<sea::Realization>()) {
    sea::CascadeModes cascade = empty(size, length_m);
    std::mt19937_64 engine(seed);
    const auto uniform = [&] { return (static_cast<double>(engine() >> 11) + 0.5) * 0x1p-53; };
    cascade.depth_m = 0.08 * length_m; // coth(kd) runs from 2.1 to 1
    double energy = 0;
    for (int ny = -size / 2 + 1; ny < size / 2; ++ny)
        for (int nx = -size / 2 + 1; nx < size / 2; ++nx) {
            const double n = std::hypot(nx, ny);
            if (n == 0 || n >= share_of_nyquist / 2 * size)
                continue;
            const Complex draw =
                std::polar(std::sqrt(-2 * std::log(uniform())), two_pi * uniform());
            const std::size_t at = slot(nx, ny, size);
            cascade.h0[at] = draw * std::pow(n, -2.0);
            cascade.rate[at] = sea::rate_from_omega(std::sqrt(9.81 * two_pi * n / length_m));
            energy += 2 * std::norm(cascade.h0[at]);
        }
    const double hs_m = 3;
    for (Complex& h0 : cascade.h0)
        h0 *= hs_m / (4 * std::sqrt(energy));
    realization_->cascades.push_back(std::move(cascade));
    realization_->choppiness = choppiness;
}

OneWave::OneWave(int size, double length_m, int nx, int ny, double amplitude_m, double omega_radps)
    : realization_(std::make_shared<sea::Realization>()) {
    sea::CascadeModes cascade = empty(size, length_m);
    cascade.h0[slot(nx, ny, size)] = amplitude_m / 2;
    cascade.rate[slot(nx, ny, size)] = sea::rate_from_omega(omega_radps);
    cascade.rate[slot(-nx, -ny, size)] = sea::rate_from_omega(omega_radps);
    realization_->cascades.push_back(std::move(cascade));
}

FieldSum::FieldSum(const sea::CascadeModes& cascade, sea::Field field, sea::TimeUs time_us)
    : size_(cascade.spec.size) {
    for (int i = 0; i < size_; ++i)
        unit_.push_back(std::polar(1.0, two_pi * i / size_));
    // A wave h0 exp(i (k.x - w t)) and its mirror, its conjugate, are twice its real part. Waves
    // with wavenumbers k and -k stand on each other: their energy is that of the sum.
    std::vector<Complex> standing(cascade.h0.size());
    for (int ny = -size_ / 2; ny < size_ / 2; ++ny)
        for (int nx = -size_ / 2; nx < size_ / 2; ++nx) {
            const std::size_t at = slot(nx, ny, size_);
            if (cascade.h0[at] == 0.0)
                continue;
            const double dk = cascade.spec.wavenumber_step_radpm();
            Complex m = tests::of_wave(field, nx * dk, ny * dk, cascade.depth_m);
            if (tests::is_rate(field))
                m *= Complex(0, -sea::omega_from_rate(cascade.rate[at]));
            const Complex now = 2.0 * m * cascade.h0[at] *
                                std::polar(1.0, -sea::phase_rad(cascade.rate[at], time_us));
            modes_.push_back({nx, ny, now});
            standing[at] += now / 2.0;
            standing[slot(-nx, -ny, size_)] += std::conj(now) / 2.0;
        }
    for (const Complex& h : standing)
        rms_ += std::norm(h);
    rms_ = std::sqrt(rms_);
}

double FieldSum::at(int x, int y) const {
    double sum = 0;
    for (const Mode& mode : modes_) {
        const int turns = ((mode.nx * x + mode.ny * y) % size_ + size_) % size_;
        const Complex& unit = unit_[static_cast<std::size_t>(turns)];
        sum += mode.amplitude.real() * unit.real() - mode.amplitude.imag() * unit.imag();
    }
    return sum;
}

std::vector<std::pair<int, int>> random_nodes(int size, int count) {
    std::mt19937 engine(99);
    std::vector<std::pair<int, int>> nodes;
    const auto draw = [&] { return static_cast<int>(engine() % static_cast<unsigned>(size)); };
    for (int i = 0; i < count; ++i) {
        const int x = draw();
        nodes.emplace_back(x, draw());
    }
    return nodes;
}

} // namespace seaway::server
