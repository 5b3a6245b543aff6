// SPDX-License-Identifier: Apache-2.0
// Fourier transforms as they are first written, each with the mistake that its line names. In double
// with exact twiddles there is no mistake in fft(): that is the truth for the others.
#pragma once

#include <cmath>
#include <complex>
#include <numbers>
#include <utility>
#include <vector>

namespace seaway::naive {

/// C1: `recurrent` twiddles, w *= w1, drift with the length of the transform.
enum class Twiddles { exact, recurrent };

/// Radix 2, exp(+i), not normalised, in place; every `stride`-th of n values.
template <class T>
void fft(std::complex<T>* values, std::size_t n, std::size_t stride, Twiddles twiddles) {
    for (std::size_t i = 1, j = 0; i < n; ++i) {
        std::size_t bit = n / 2;
        for (; j & bit; bit /= 2)
            j ^= bit;
        j ^= bit;
        if (i < j)
            std::swap(values[i * stride], values[j * stride]);
    }
    for (std::size_t length = 2; length <= n; length *= 2) {
        const auto angle = 2 * std::numbers::pi / static_cast<double>(length);
        const std::complex<T> step(std::polar(1.0, angle));
        std::complex<T> product(1);
        for (std::size_t k = 0; k < length / 2; ++k, product *= step) {
            const auto w = twiddles == Twiddles::recurrent
                               ? product
                               : std::complex<T>(std::polar(1.0, angle * static_cast<double>(k)));
            for (std::size_t i = k; i < n; i += length) {
                auto& a = values[i * stride];
                auto& b = values[(i + length / 2) * stride];
                const std::complex<T> turned = b * w;
                b = a - turned;
                a += turned;
            }
        }
    }
}

/// n x n, in place.
template <class T>
void fft_2d(std::vector<std::complex<T>>& values, std::size_t n,
            Twiddles twiddles = Twiddles::exact) {
    for (std::size_t row = 0; row < n; ++row)
        fft(&values[row * n], n, 1, twiddles);
    for (std::size_t column = 0; column < n; ++column)
        fft(&values[column], n, n, twiddles);
}

/// C2: x and y exchanged; nobody sees it in a sea that looks alike from both sides.
template <class T>
std::vector<T> transposed(const std::vector<T>& values, std::size_t n) {
    std::vector<T> out(values.size());
    for (std::size_t y = 0; y < n; ++y)
        for (std::size_t x = 0; x < n; ++x)
            out[x * n + y] = values[y * n + x];
    return out;
}

/// C3: the inverse transform of a library divides by the number of points.
template <class T>
void divide_by_points(std::vector<std::complex<T>>& values) {
    for (std::complex<T>& value : values)
        value /= static_cast<T>(values.size());
}

/// C4: two fields in one transform as a + i b, both spectra one-sided: "the real part is the field"
/// is true of one alone, packed together each leaks into the other.
inline std::vector<std::complex<float>> packed(const std::vector<std::complex<float>>& a,
                                               const std::vector<std::complex<float>>& b) {
    std::vector<std::complex<float>> both(a.size());
    for (std::size_t i = 0; i < a.size(); ++i)
        both[i] = a[i] + std::complex<float>(0, 1) * b[i];
    return both;
}

/// C11: the wavenumber of array index i of a centred lattice, summed up in floats: that of -k is not
/// minus that of k.
inline float centred_wavenumber(int i, int size, double length_m) {
    const auto first = static_cast<float>(-std::numbers::pi * size / length_m);
    const auto step = static_cast<float>(2 * std::numbers::pi / length_m);
    float k = first;
    for (int n = 0; n < i; ++n)
        k += step;
    return k;
}

} // namespace seaway::naive
