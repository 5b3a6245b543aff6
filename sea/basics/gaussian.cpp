// SPDX-License-Identifier: Apache-2.0
#include "sea/basics/gaussian.h"

#include <array>
#include <bit>
#include <cmath>
#include <utility>

#include "sea/basics/constants.h"
#include "sea/basics/philox.h"

namespace seaway::sea {

namespace {

/// ln x for normal x > 0, by ln m = 2 atanh((m-1)/(m+1)), m in [sqrt(1/2), sqrt(2)); 2e-16.
double portable_log(double x) {
    const auto bits = std::bit_cast<std::uint64_t>(x);
    int exponent = static_cast<int>(bits >> 52) - 1023;
    double m = std::bit_cast<double>((bits & 0x000FFFFFFFFFFFFFull) | 0x3FF0000000000000ull);
    if (m > 1.4142135623730951) {
        m *= 0.5;
        ++exponent;
    }
    const double s = (m - 1.0) / (m + 1.0);
    const double s2 = s * s;
    double series = 0.0;
    for (int n = 11; n >= 0; --n)
        series = series * s2 + 1.0 / (2 * n + 1);
    return exponent * 0.6931471805599453 + 2.0 * s * series;
}

/// cos and sin of 2 pi u, u in [0, 1): octant reduction, Taylor series on [-pi/4, pi/4]; 2e-16.
std::pair<double, double> portable_cos_sin_turns(double u) {
    const int quarter = static_cast<int>(4.0 * u + 0.5);
    const double a = two_pi * (u - 0.25 * quarter);
    const double a2 = a * a;
    double sine = 1.0;
    double cosine = 1.0;
    for (int n = 9; n >= 1; --n) {
        cosine = 1.0 - cosine * a2 / ((2 * n - 1) * (2 * n));
        sine = 1.0 - sine * a2 / ((2 * n) * (2 * n + 1));
    }
    sine *= a;
    switch (quarter & 3) {
    case 0:
        return {cosine, sine};
    case 1:
        return {-sine, cosine};
    case 2:
        return {-cosine, -sine};
    default:
        return {sine, -cosine};
    }
}

double uniform(std::uint32_t word) {
    return (word + 0.5) * 0x1p-32;
}

} // namespace

std::uint32_t cascade_key(double length_m) {
    return static_cast<std::uint32_t>(std::llround(length_m * 1000.0));
}

GaussianPair gaussian_from_words(std::uint32_t radius_word, std::uint32_t angle_word) {
    const double radius = std::sqrt(-2.0 * portable_log(uniform(radius_word)));
    const auto [cosine, sine] = portable_cos_sin_turns(uniform(angle_word));
    return {radius * cosine, radius * sine};
}

GaussianPair gaussian_pair(const ModeKey& key) {
    const PhiloxCounter words = philox4x32_10(
        {static_cast<std::uint32_t>(key.nx), static_cast<std::uint32_t>(key.ny), key.system,
         key.cascade},
        {static_cast<std::uint32_t>(key.seed), static_cast<std::uint32_t>(key.seed >> 32)});
    return gaussian_from_words(words[0], words[1]);
}

} // namespace seaway::sea
