// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/accuracy/measure/octaves.h"

#include <array>
#include <cmath>
#include <complex>
#include <map>

#include "sea/basics/constants.h"
#include "tools/bench/accuracy/truth/in_threads.h"

namespace seaway::bench {

namespace {

using Complex = std::complex<double>;

/// Octaves with less of the variance are waves that nobody asked for.
constexpr double least_share = 1e-8;

/// exp(-i 2 pi n x / count), unnormalised, in place; `count` a power of two, `stride` apart.
void transform(Complex* values, std::size_t count, std::size_t stride) {
    for (std::size_t i = 1, j = 0; i < count; ++i) {
        std::size_t bit = count >> 1;
        for (; j & bit; bit >>= 1)
            j ^= bit;
        j ^= bit;
        if (i < j)
            std::swap(values[i * stride], values[j * stride]);
    }
    for (std::size_t length = 2; length <= count; length *= 2)
        for (std::size_t k = 0; k < length / 2; ++k) {
            const Complex w = std::polar(1.0, -sea::two_pi * static_cast<double>(k) /
                                                  static_cast<double>(length));
            for (std::size_t i = k; i < count; i += length) {
                Complex& a = values[i * stride];
                Complex& b = values[(i + length / 2) * stride];
                const Complex turned(w.real() * b.real() - w.imag() * b.imag(),
                                     w.real() * b.imag() + w.imag() * b.real());
                b = a - turned;
                a += turned;
            }
        }
}

/// Sums over the waves of an octave at one moment.
struct Sum {
    double truth = 0;
    double shown = 0;
    double phase2 = 0; ///< squares of phase errors, by energy

    Sum& operator+=(const Sum& more) {
        truth += more.truth;
        shown += more.shown;
        phase2 += more.phase2;
        return *this;
    }
    double energy_error_pct() const { return 100.0 * (shown / truth - 1.0); }
};

/// By octave, each by how far into an interval.
using SumsByOctave = std::map<int, std::array<Sum, octave_moments>>;

/// What the sea shows of a cascade at its time: sums over its waves.
void add_cascade(const ConfiguredSea& sea, int c, std::size_t moment, SumsByOctave& octaves) {
    const sea::CascadeModes& modes = sea.waves().used->cascades[static_cast<std::size_t>(c)];
    const int size = modes.spec.size, fine = 2 * size;
    const auto count = static_cast<std::size_t>(fine);
    const double spacing = modes.spec.length_m / fine;
    std::vector<Complex> values(count * count);
    in_threads(fine, [&](int row) {
        const auto y = static_cast<std::size_t>(row);
        for (std::size_t x = 0; x < count; ++x)
            values[y * count + x] =
                sea.at(c, static_cast<double>(x) * spacing, static_cast<double>(y) * spacing)
                    .height;
        transform(&values[y * count], count, 1);
    });
    in_threads(fine, [&](int column) {
        transform(&values[static_cast<std::size_t>(column)], count, count);
    });
    const double scale = 1.0 / static_cast<double>(count * count);
    const sea::TimeUs t = sea.waves().used->phase_time(sea.shown_us());
    const auto wrapped = [](int n, int side) {
        return static_cast<std::size_t>((n + side) % side);
    };
    for_each_wave(modes, [&](std::size_t i, double kx, double ky, double, double) {
        const int nx = sea::signed_index(static_cast<int>(i) % size, size);
        const int ny = sea::signed_index(static_cast<int>(i) / size, size);
        const std::size_t opposite =
            wrapped(-ny, size) * static_cast<std::size_t>(size) + wrapped(-nx, size);
        const Complex turn = std::polar(1.0, -sea::phase_rad(modes.rate[i], t));
        const Complex truth = modes.h0[i] * turn + std::conj(modes.h0[opposite] * turn);
        const Complex shown = scale * values[wrapped(ny, fine) * count + wrapped(nx, fine)];
        Sum& sum = octaves[static_cast<int>(std::floor(std::log2(std::hypot(kx, ky))))][moment];
        sum.truth += std::norm(truth);
        sum.shown += std::norm(shown);
        const double phase = std::arg(shown * std::conj(truth));
        sum.phase2 += std::norm(truth) * phase * phase;
    });
}

Octave octave_of(int exponent, const std::array<Sum, octave_moments>& moments) {
    Sum all;
    Octave octave{.k_radpm = std::ldexp(1.0, exponent)};
    for (const Sum& moment : moments) {
        all += moment;
        if (std::abs(moment.energy_error_pct()) > std::abs(octave.energy_error_worst_pct))
            octave.energy_error_worst_pct = moment.energy_error_pct();
    }
    octave.variance_m2 = all.truth / octave_moments;
    octave.energy_error_pct = all.energy_error_pct();
    octave.phase_error_rad = std::sqrt(all.phase2 / all.truth);
    return octave;
}

} // namespace

Result<std::vector<Octave>> octaves(ConfiguredSea& sea, sea::TimeUs time_us) {
    std::vector<Octave> all;
    if (sea.configuration().evaluator != Evaluator::maps)
        return all;
    SumsByOctave sums;
    for (int c = 0; c < static_cast<int>(sea.waves().used->cascades.size()); ++c) {
        const sea::TimeUs interval_us =
            sea.waves().budget.cascades[static_cast<std::size_t>(c)].interval_us;
        const sea::TimeUs start_us = sea.keyframe_before_us(c, time_us);
        for (int moment = 0; moment < octave_moments; ++moment) {
            SEAWAY_TRY(sea.go_to(start_us + (2 * moment + 1) * interval_us / (2 * octave_moments)));
            add_cascade(sea, c, static_cast<std::size_t>(moment), sums);
        }
    }
    double whole_m2 = 0;
    for (const auto& [exponent, moments] : sums)
        whole_m2 += octave_of(exponent, moments).variance_m2;
    for (const auto& [exponent, moments] : sums)
        if (const Octave octave = octave_of(exponent, moments);
            octave.variance_m2 > least_share * whole_m2)
            all.push_back(octave);
    return all;
}

} // namespace seaway::bench
