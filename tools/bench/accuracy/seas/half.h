// SPDX-License-Identifier: Apache-2.0
// Numbers of 16 bits, for the comparison: by the bench, and by tests/naive. Pure; thread-safe.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace seaway::bench {

/// Nearest half (IEEE 754 binary16, subnormals kept) as a float; beyond 65504 infinite.
inline float rounded_to_half(float value) {
    constexpr float largest = 65504.0f;
    if (!std::isfinite(value) || value == 0.0f)
        return value;
    if (std::abs(value) >= largest + 16.0f)
        return std::copysign(std::numeric_limits<float>::infinity(), value);
    constexpr int mantissa_bits = 11, exponent_min = -13; // 2^-14 is the smallest normal half
    int exponent = 0;
    std::frexp(value, &exponent);
    const float ulp = std::ldexp(1.0f, std::max(exponent, exponent_min) - mantissa_bits);
    return std::nearbyint(value / ulp) * ulp;
}

} // namespace seaway::bench
