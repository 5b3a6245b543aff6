// SPDX-License-Identifier: Apache-2.0
// The loop of foam_kernel.h, without branches, for the compiler to vectorise. In an unnamed
// namespace, and nothing of the standard library: each translation unit that includes it is
// compiled for other instructions, and a linker keeps one copy of what they share.
#pragma once

#include "sea/foam/foam_kernel.h"

namespace seaway::sea {

namespace {

inline float larger(float a, float b) {
    return a < b ? b : a;
}
inline float smaller(float a, float b) {
    return b < a ? b : a;
}

/// Ratios below this are nothing; keeps denormal numbers out (hard case E4).
constexpr float ratio_min = 1e-6f;

/// Beyond this many deviations phi is below 1e-34.
constexpr float deviations_max = 12.5f;

/// phi(t), 0 <= t <= deviations_max; relative error 4e-6. 2^n by exponent bits, 2^f by a
/// polynomial.
inline float normal_density(float t) {
    constexpr float log2_e = 1.44269504f;
    constexpr float round = 12582912.0f; // 1.5 * 2^23: adding it rounds to a whole number
    const float power = t * t * (-0.5f * log2_e);
    const float shifted = power + round;
    const float f = power - (shifted - round);
    const float mantissa =
        1.0f + f * (0.69314718f +
                    f * (0.24022651f + f * (0.05550411f + f * (0.00961813f + f * 0.00133336f))));
    const auto exponent = __builtin_bit_cast(int, shifted) - __builtin_bit_cast(int, round);
    return 0.39894228f * __builtin_bit_cast(float, (exponent + 127) << 23) * mantissa;
}

/// 1 - t M(t) and its companion t (1 - t M) + M, M being Mills' ratio Phi(-t)/phi(t), 0 <= t <=
/// deviations_max; polynomials in 1/(1 + 0.3 t) fitted for relative error: 1e-6 and 6e-6.
struct MillsTerms {
    float linear;
    float square;
};

inline MillsTerms mills_terms(float t) {
    const float k = 1.0f / (1.0f + 0.3f * t);
    const float linear =
        0.089911076f +
        k * (0.18241227f +
             k * (0.22002899f +
                  k * (0.40581092f +
                       k * (-0.24083353f +
                            k * (0.97683328f + k * (-0.85622522f + k * 0.22206299f))))));
    const float square =
        0.60501906f +
        k * (0.51664481f +
             k * (1.05656121f +
                  k * (-1.7316443f + k * (3.97410573f + k * (-4.41947001f + k * 1.25209079f)))));
    return {linear * k * k, square * k};
}

inline float breaking(const FoamTick& tick, float strain_xx, float strain_yy, float strain_xy) {
    const float a = tick.choppiness_x * strain_xx;
    const float b = tick.choppiness_y * strain_yy;
    const float c = tick.choppiness_xy * strain_xy;
    const float difference = a - b;
    const float mean = tick.threshold - (1.0f + a) * (1.0f + b) + c * c;
    const float slope = 0.5f * (2.0f + a + b - tick.difference * difference - tick.shear * c);
    const float rest = difference * difference * tick.difference_rest + c * c * tick.shear_rest +
                       difference * c * tick.cross_rest + tick.constant_rest;
    const float width = __builtin_sqrtf(larger(slope * slope * tick.variance + rest, 0.0f));
    const float top = mean + tick.curvature;
    const float discriminant = width * width + 4.0f * tick.curvature * top;
    const float root = 2.0f * top / (width + __builtin_sqrtf(larger(discriminant, 0.0f)));
    const float t = smaller(__builtin_fabsf(root), deviations_max);
    const MillsTerms mills = mills_terms(t);
    const float side = root > 0.0f ? 1.0f : -1.0f;
    const float density = normal_density(t);
    const float tail = density * (width * mills.linear + side * tick.curvature * mills.square);
    const float excess = tail + (root > 0.0f ? mean : 0.0f);
    // M = (t (1 - t M) + M) - t (1 - t M); P(J < threshold) = Phi(root).
    const float beyond = density * (mills.square - t * mills.linear);
    const float share = root > 0.0f ? 1.0f - beyond : beyond;
    return discriminant > 0.0f ? larger(excess, 0.0f) + tick.bias * share : 0.0f;
}

void advance_ratios(const FoamTick& tick, const float* xx, const float* yy, const float* xy,
                    float* ratio, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
        const float next = ratio[i] * tick.remains +
                           breaking(tick, xx[i], yy[i], xy[i]) * tick.source + tick.added;
        ratio[i] = next >= ratio_min ? next : 0.0f;
    }
}

constexpr FoamKernel kernel{advance_ratios};

} // namespace

} // namespace seaway::sea
