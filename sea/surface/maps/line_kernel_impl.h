// SPDX-License-Identifier: Apache-2.0
// line_kernel.h for W floats a vector. Included once per instruction set: all is of internal linkage, and
// nothing of the standard library is instantiated here.
#pragma once

#include "sea/surface/maps/line_kernel.h"

namespace seaway::sea {
namespace {

template <int W>
struct Lines {
    typedef float F __attribute__((vector_size(W * 4), aligned(4), may_alias));

    struct Complex {
        F re, im;
        Complex operator+(Complex b) const { return {re + b.re, im + b.im}; }
        Complex operator-(Complex b) const { return {re - b.re, im - b.im}; }
        Complex operator*(float s) const { return {re * s, im * s}; }
        /// Times -i.
        Complex turned() const { return {im, -re}; }
        Complex times(float c, float s) const { return {re * c - im * s, re * s + im * c}; }
    };

    static void butterfly(Complex (&z)[2]) {
        const Complex a = z[0] + z[1];
        z[1] = z[0] - z[1];
        z[0] = a;
    }
    static void butterfly(Complex (&z)[3]) {
        constexpr float half = 0.5f, sine = 0.86602540378443865f;
        const Complex sum = z[1] + z[2], turned = ((z[1] - z[2]) * sine).turned();
        const Complex middle = z[0] - sum * half;
        z[0] = z[0] + sum;
        z[1] = middle + turned;
        z[2] = middle - turned;
    }
    static void butterfly(Complex (&z)[4]) {
        const Complex a = z[0] + z[2], b = z[0] - z[2], c = z[1] + z[3];
        const Complex d = (z[1] - z[3]).turned();
        z[0] = a + c;
        z[1] = b + d;
        z[2] = a - c;
        z[3] = b - d;
    }
    static void butterfly(Complex (&z)[5]) {
        constexpr float c1 = 0.30901699437494742f, c2 = -0.80901699437494742f;
        constexpr float s1 = 0.95105651629515357f, s2 = 0.58778525229247313f;
        const Complex outer = z[1] + z[4], inner = z[2] + z[3];
        const Complex x = z[1] - z[4], y = z[2] - z[3];
        const Complex a = z[0] + outer * c1 + inner * c2, b = z[0] + outer * c2 + inner * c1;
        const Complex u = (x * s1 + y * s2).turned(), v = (x * s2 - y * s1).turned();
        z[0] = z[0] + outer + inner;
        z[1] = a + u;
        z[2] = b + v;
        z[3] = b - v;
        z[4] = a - u;
    }

    static constexpr int pitch = 2 * lines_at_once; ///< floats a number

    static Complex load(const float* from) {
        return {*reinterpret_cast<const F*>(from),
                *reinterpret_cast<const F*>(from + lines_at_once)};
    }
    static void store(float* to, Complex z) {
        *reinterpret_cast<F*>(to) = z.re;
        *reinterpret_cast<F*>(to + lines_at_once) = z.im;
    }

    /// `left` is what remains of the length, `stride` what was transformed.
    template <int R>
    static void stage(const float* from, float* to, int left, int stride, const float* twiddles) {
        const int m = left / R;
        for (int p = 0; p < m; ++p, twiddles += 2 * (R - 1))
            for (int q = 0; q < stride; ++q)
                for (int lane = 0; lane < lines_at_once; lane += W) {
                    Complex z[R];
                    for (int k = 0; k < R; ++k)
                        z[k] = load(from + (q + stride * (p + m * k)) * pitch + lane);
                    butterfly(z);
                    store(to + (q + stride * R * p) * pitch + lane, z[0]);
                    for (int j = 1; j < R; ++j)
                        store(to + (q + stride * (R * p + j)) * pitch + lane,
                              z[j].times(twiddles[2 * j - 2], twiddles[2 * j - 1]));
                }
    }

    static float* transform(const LineTransform& transform, float* data, float* other) {
        const float* twiddles = transform.twiddles;
        int left = transform.length, stride = 1;
        for (int i = 0; i < transform.radix_count; ++i) {
            const int r = transform.radices[i];
            if (r == 2)
                stage<2>(data, other, left, stride, twiddles);
            else if (r == 3)
                stage<3>(data, other, left, stride, twiddles);
            else if (r == 4)
                stage<4>(data, other, left, stride, twiddles);
            else
                stage<5>(data, other, left, stride, twiddles);
            twiddles += left / r * 2 * (r - 1);
            left /= r;
            stride *= r;
            float* const result = other;
            other = data;
            data = result;
        }
        return data;
    }
};

} // namespace
} // namespace seaway::sea
