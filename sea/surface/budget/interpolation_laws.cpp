// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/budget/interpolation_laws.h"

#include <algorithm>
#include <cmath>

namespace seaway::sea {

namespace {

/// Bounded errors at the grid points on the gradient, per grid spacing: 3 along and 1.549 across, both of
/// them most in the middle of a cell, and two components along two axes.
constexpr double spline_slope_gain = 2.0 * 3.0 * 1.549;

/// Sum of the amplitudes of the images of a wave beyond Nyquist, over its own, to a power.
double aliases_of(double q, int power) {
    double sum = 0;
    for (int j = 1; j <= 8; ++j) {
        const double shift = 2.0 * std::numbers::pi * j;
        const double before = q / (shift + q), after = q / (shift - q);
        double before_to = before, after_to = after;
        for (int factor = 1; factor < power; ++factor) { // std::pow takes twenty times as long
            before_to *= before;
            after_to *= after;
        }
        sum += before_to + after_to;
    }
    return sum;
}

} // namespace

double hermite_error(double u) {
    const double x2 = 0.25 * u * u; // (u/2)^2
    if (x2 < 0.01)                  // where the difference below is rounding, whose sign is any
        return x2 * x2 * (1.0 / 24.0 - x2 * (1.0 / 360.0 - x2 / 13440.0));
    if (u <= hermite_phase_max)
        return 1.0 - std::cos(0.5 * u) - 0.25 * u * std::sin(0.5 * u);
    // The wave itself, the two values, whose weights add up to one, and the two rates: to 1/4.
    return 2.0 + 0.25 * u;
}

double gliding_error(double u, double q) {
    // Where it ends between two keyframes the third derivative falls from 60 to nothing: 1/192 of that (Peano's kernel).
    const double end = 2.0 * 60.0 * q * q * q / 192.0;
    constexpr int steps = 32; // of the way: what is missed grows and falls with it smoothly
    const double steady = hermite_error(u);
    double worst = steady;
    for (int i = 0; i <= steps; ++i) {
        const double x = static_cast<double>(i) / steps, r = 1.0 - x;
        const double first = 30.0 * x * x * r * r, second = 60.0 * x * r * std::abs(r - x);
        const double third = 60.0 * std::abs(1.0 - 6.0 * x * r), fourth = 360.0 * std::abs(r - x);
        const double even = q * q * (6.0 * second * u * u + q * q * fourth);
        const double odd = 4.0 * q * u * (first * u * u + q * q * third);
        worst = std::max(worst, std::hypot(steady + 2.0 * even / 384.0, 2.0 * odd / 384.0));
    }
    // Beyond what keyframes tell: the wave itself, the two values, and a quarter of the interval of rates, the glide's among them.
    return std::min(worst + end, 2.0 + 0.25 * u + 0.25 * 2.0 * 15.0 / 8.0 * q);
}

double spline_error(double q) {
    const double aliases = aliases_of(q, 4);
    return 2.0 * aliases / (1.0 + aliases);
}

double spline_slope_error(double q) {
    // Each alias is steeper than the wave by the ratio of their wavenumbers.
    const double aliases = aliases_of(q, 4);
    return (aliases + aliases_of(q, 3)) / (1.0 + aliases);
}

double sampled_slope_error(double sampled_error, double spacing_m) {
    return sampled_error * spline_slope_gain / (spline_gain * spacing_m);
}

} // namespace seaway::sea
