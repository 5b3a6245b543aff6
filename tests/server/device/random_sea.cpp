// SPDX-License-Identifier: Apache-2.0
#include "tests/server/device/random_sea.h"

#include <bit>
#include <cmath>
#include <numbers>
#include <random>

#include "base/check.h"
#include "tests/support/field_law.h"

namespace seaway::server {

namespace {

constexpr double two_pi = 2 * std::numbers::pi;
using Complex = std::complex<double>;

/// The remainder, of what is negative, too: sizes are powers of two.
std::size_t around(int n, int size) {
    return static_cast<std::size_t>(n & (size - 1));
}

std::size_t slot(int nx, int ny, int size) {
    return around(ny, size) * static_cast<std::size_t>(size) + around(nx, size);
}

sea::CascadeModes empty(int size, double length_m) {
    SEAWAY_CHECK(std::has_single_bit(static_cast<unsigned>(size)), "sizes are powers of two");
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

FieldSums::FieldSums(const sea::CascadeModes& cascade, sea::FieldSet fields, sea::TimeUs time_us,
                     std::span<const GridNode> nodes) {
    const int size = cascade.spec.size;
    SEAWAY_CHECK(std::has_single_bit(static_cast<unsigned>(size)), "sizes are powers of two");
    Turns turns;
    for (int i = 0; i < size; ++i)
        turns.of_node.push_back(std::polar(1.0, two_pi * i / size));
    turns.of_time.resize(cascade.h0.size());
    for (std::size_t i = 0; i < cascade.h0.size(); ++i)
        if (cascade.h0[i] != 0.0)
            turns.of_time[i] = std::polar(1.0, -sea::phase_rad(cascade.rate[i], time_us));
    for (const sea::Field field : fields)
        sums_[static_cast<std::size_t>(field)] = sum_of(cascade, field, turns, nodes);
}

FieldSums::Sum FieldSums::sum_of(const sea::CascadeModes& cascade, sea::Field field,
                                 const Turns& turns, std::span<const GridNode> nodes) {
    const int size = cascade.spec.size;
    Sum sum{std::vector<double>(nodes.size()), 0};
    // A wave h0 exp(i (k.x - w t)) and its mirror, its conjugate, are twice its real part. Waves
    // with wavenumbers k and -k stand on each other: their energy is that of the sum.
    std::vector<Complex> standing(cascade.h0.size());
    for (int ny = -size / 2; ny < size / 2; ++ny)
        for (int nx = -size / 2; nx < size / 2; ++nx) {
            const std::size_t at = slot(nx, ny, size);
            if (cascade.h0[at] == 0.0)
                continue;
            const double dk = cascade.spec.wavenumber_step_radpm();
            Complex m = tests::of_wave(field, nx * dk, ny * dk, cascade.depth_m);
            if (tests::is_rate(field))
                m *= Complex(0, -sea::omega_from_rate(cascade.rate[at]));
            const Complex now = 2.0 * m * cascade.h0[at] * turns.of_time[at];
            for (std::size_t i = 0; i < nodes.size(); ++i) {
                const Complex& unit =
                    turns.of_node[around(nx * nodes[i].first + ny * nodes[i].second, size)];
                sum.at[i] += now.real() * unit.real() - now.imag() * unit.imag();
            }
            standing[at] += now / 2.0;
            standing[slot(-nx, -ny, size)] += std::conj(now) / 2.0;
        }
    for (const Complex& h : standing)
        sum.rms += std::norm(h);
    sum.rms = std::sqrt(sum.rms);
    return sum;
}

std::vector<GridNode> random_nodes(int size, int count) {
    std::mt19937 engine(99);
    std::vector<GridNode> nodes;
    const auto draw = [&] { return static_cast<int>(engine() % static_cast<unsigned>(size)); };
    for (int i = 0; i < count; ++i) {
        const int x = draw();
        nodes.emplace_back(x, draw());
    }
    return nodes;
}

} // namespace seaway::server
