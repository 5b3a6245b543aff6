// SPDX-License-Identifier: Apache-2.0
// The evolve step of the FFTW yardsticks: one row of modes to four packed complex spectra.
#pragma once

#include <cstddef>
#include <cstdint>

namespace seaway::bench {

inline constexpr int packed_fields = 4;

/// The modes of one cascade as a plain program keeps them, [ky][kx].
struct PlainModes {
    int size;
    const float* cosine;     ///< re, im of h0(k) + conj h0(-k)
    const float* sine;       ///< re, im of i (conj h0(-k) - h0(k))
    const float* over_k;     ///< coth(kd) / k
    const float* wavenumber; ///< by index
    const std::uint64_t* rate;
};

/// Row iy at time_us into out[field][iy][ix] (re, im): height + i D_x, D_y + i slope_x,
/// slope_y + i strain_xx, strain_yy + i strain_xy.
using EvolveRow = void (*)(const PlainModes& modes, std::uint64_t time_us, int iy,
                           float* const (&out)[packed_fields]);

void evolve_row_vectorised(const PlainModes&, std::uint64_t, int, float* const (&)[packed_fields]);
void evolve_row_plain(const PlainModes&, std::uint64_t, int, float* const (&)[packed_fields]);

/// Sine and cosine of 2 pi turns / 2^32.
template <void (*sincos)(std::uint32_t turns, float& sine, float& cosine)>
inline void evolve_row(const PlainModes& modes, std::uint64_t time_us, int iy,
                       float* const (&out)[packed_fields]) {
    const std::size_t begin = static_cast<std::size_t>(iy) * static_cast<std::size_t>(modes.size);
    const float* __restrict p = modes.cosine + 2 * begin;
    const float* __restrict q = modes.sine + 2 * begin;
    const float* __restrict over_k = modes.over_k + begin;
    const std::uint64_t* __restrict rate = modes.rate + begin;
    float* __restrict out0 = out[0] + 2 * begin;
    float* __restrict out1 = out[1] + 2 * begin;
    float* __restrict out2 = out[2] + 2 * begin;
    float* __restrict out3 = out[3] + 2 * begin;
    const float ky = modes.wavenumber[iy];
    for (int ix = 0; ix < modes.size; ++ix) {
        float s, c;
        sincos(static_cast<std::uint32_t>(rate[ix] * time_us >> 32), s, c);
        const float re = p[2 * ix] * c + q[2 * ix] * s;
        const float im = p[2 * ix + 1] * c + q[2 * ix + 1] * s;
        const float kx = modes.wavenumber[ix];
        const float x = kx * over_k[ix], y = ky * over_k[ix];
        out0[2 * ix] = re - x * re;
        out0[2 * ix + 1] = im - x * im;
        out1[2 * ix] = -y * im - kx * re;
        out1[2 * ix + 1] = y * re - kx * im;
        out2[2 * ix] = -(ky - kx * x) * im;
        out2[2 * ix + 1] = (ky - kx * x) * re;
        out3[2 * ix] = kx * y * im - ky * y * re;
        out3[2 * ix + 1] = -ky * y * im - kx * y * re;
    }
}

/// Interleaved (re, im) to two planes, rows begin .. end-1 of `size`.
void split_rows_vectorised(const float* packed, float* re, float* im, std::size_t values);
void split_rows_plain(const float* packed, float* re, float* im, std::size_t values);

inline void split(const float* __restrict packed, float* __restrict re, float* __restrict im,
                  std::size_t values) {
    for (std::size_t i = 0; i < values; ++i) {
        re[i] = packed[2 * i];
        im[i] = packed[2 * i + 1];
    }
}

} // namespace seaway::bench
