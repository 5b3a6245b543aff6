// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/budget/interpolation_laws.h"

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
    constexpr double first = 15.0 / 8.0, second = 5.773502691896258, third = 60.0, fourth = 360.0;
    const double change = q * (4.0 * first * u * u * u +
                               q * (6.0 * second * u * u + q * (4.0 * third * u + q * fourth)));
    return hermite_error(u) + 2.0 * change / 384.0;
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
