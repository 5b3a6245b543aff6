// SPDX-License-Identifier: Apache-2.0
// Maps of one cascade: ours, and the double-precision truth by a plain transform.
#pragma once

#include <algorithm>
#include <complex>
#include <span>
#include <vector>

#include "sea/native/native_runner.h"
#include "tests/naive/transform.h"
#include "tests/sea/native/double_sum.h"
#include "tests/sea/native/random_modes.h"

namespace seaway::hard_cases {

using Spectrum = std::vector<std::complex<double>>;

/// One field per plane, [y][x].
inline std::vector<float> maps(const sea::CascadeModes& modes, sea::FieldSet fields,
                               sea::TimeUs t_us, sea::Choppiness choppiness = {},
                               Instructions instructions = best_instructions(), int threads = 1) {
    const auto cascade = sea::NativeTransform::create(modes, choppiness, instructions);
    const auto n = static_cast<std::size_t>(modes.spec.size);
    std::vector<float> planes(static_cast<std::size_t>(fields.size()) * n * n);
    const sea::NativeTask task{&*cascade, t_us, fields, planes};
    sea::NativeRunner(threads).run({&task, 1});
    return planes;
}

/// h(k,t) of every mode, or another linear field's amplitudes: [iy][ix].
inline Spectrum spectrum(const sea::CascadeModes& modes, sea::TimeUs t_us,
                         sea::Field field = sea::Field::height) {
    const auto n = static_cast<std::size_t>(modes.spec.size);
    Spectrum h(n * n);
    for (std::size_t iy = 0; iy < n; ++iy)
        for (std::size_t ix = 0; ix < n; ++ix)
            h[iy * n + ix] = sea::amplitude(modes, field, ix, iy, t_us);
    return h;
}

inline std::vector<std::complex<float>> in_floats(const Spectrum& h) {
    std::vector<std::complex<float>> out;
    for (const auto& value : h)
        out.emplace_back(value);
    return out;
}

template <class T>
std::vector<double> real_parts(const std::vector<std::complex<T>>& values) {
    std::vector<double> out;
    for (const auto& value : values)
        out.push_back(value.real());
    return out;
}

/// The map in double precision.
inline std::vector<double> true_map(const sea::CascadeModes& modes, sea::Field field,
                                    sea::TimeUs t_us) {
    Spectrum h = spectrum(modes, t_us, field);
    naive::fft_2d(h, static_cast<std::size_t>(modes.spec.size));
    return real_parts(h);
}

/// The map of heights in double precision as a sum of real waves, each by its own amplitude and frequency: what k and -k
/// have to do with each other does not enter.
inline std::vector<double> true_heights(const sea::CascadeModes& modes, sea::TimeUs t_us) {
    Spectrum waves(modes.h0.size());
    for (std::size_t i = 0; i < waves.size(); ++i)
        waves[i] = 2.0 * modes.h0[i] * std::polar(1.0, -sea::phase_rad(modes.rate[i], t_us));
    naive::fft_2d(waves, static_cast<std::size_t>(modes.spec.size));
    return real_parts(waves);
}

template <class T>
double rms(const std::vector<T>& values) {
    double sum = 0;
    for (const T value : values)
        sum += static_cast<double>(value) * value;
    return std::sqrt(sum / static_cast<double>(values.size()));
}

/// Imaginary over real rms of the map that naive code makes of these amplitudes.
inline double imaginary_share(Spectrum h, std::size_t n) {
    naive::fft_2d(h, n);
    std::vector<double> imaginary;
    for (const auto& value : h)
        imaginary.push_back(value.imag());
    return rms(imaginary) / rms(real_parts(h));
}

struct MapError {
    double rms; ///< over the rms of the truth
    double worst;
};
template <class T>
MapError error_of(const std::vector<T>& map, const std::vector<double>& truth) {
    double sum = 0, worst = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        const double error = std::abs(map[i] - truth[i]);
        sum += error * error;
        worst = std::max(worst, error);
    }
    const double scale = rms(truth);
    return {std::sqrt(sum / static_cast<double>(truth.size())) / scale, worst / scale};
}

/// The rms error, over the rms height, that rounding leaves a transform of `size` x `size` points: 2^-24 through log2 N^2
/// stages that add in the square, and a factor of two for amplitudes and sines that are rounded as well.
inline double rounding_of_maps(int size) {
    return 0x1p-24 * 2 * std::sqrt(2 * std::log2(size));
}

/// A wave given by its amplitude and lattice index, beside what is there; both of a pair k, -k get
/// their frequency.
inline void put_wave(sea::CascadeModes& modes, int nx, int ny, std::complex<double> h0) {
    const int size = modes.spec.size;
    const auto index = [size](int x, int y) {
        return static_cast<std::size_t>((y + size) % size * size + (x + size) % size);
    };
    modes.h0[index(nx, ny)] += h0;
    modes.rate[index(nx, ny)] = modes.rate[index(-nx, -ny)] = sea::rate_from_omega(
        std::sqrt(9.81 * std::hypot(nx, ny) * modes.spec.wavenumber_step_radpm()));
}

} // namespace seaway::hard_cases
