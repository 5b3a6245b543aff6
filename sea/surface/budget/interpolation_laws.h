// SPDX-License-Identifier: Apache-2.0
// What a wave loses between keyframes and between grid points, and what rounding at the samples becomes
// between them.
//
// Cubic Hermite in time (Hermite's remainder): a wave of phase step u = omega * interval is missed by
// 1 - cos(u/2) - (u/4) sin(u/2) ~ u^4/384 of its amplitude in the middle, and by no more than
// 16 s^2 (1-s)^2 of that a share s after the first keyframe. Cubic splines in space (Unser 1999): one of
// phase step q = k dx by 2 r / (1 + r) in the middle of a cell, r = sum_{j != 0} (q / (q + 2 pi j))^4.
//
// Pure functions; thread-safe.
#pragma once

#include <numbers>

namespace seaway::sea {

inline double square(double x) {
    return x * x;
}

/// Bound on the amplitude share that cubic Hermite misses between two keyframes at phase step
/// u = omega * interval >= 0: at every time between them and at every phase of the wave. Never falls
/// as u grows. Up to hermite_phase_max it is met, in the middle; beyond, keyframes know nothing of
/// the wave, and no interval is chosen there while there is a shorter one.
double hermite_error(double u);
/// The same of a wave that glides to another (sea/basics/glide.h) in 1/q intervals, as a share of the larger of both: Hermite's
/// remainder of the product, to which each derivative of the glide (at most 15/8, 10/sqrt(3), 60 and 360) comes by Leibniz's rule,
/// of the difference of the two waves, at most twice the larger; or, where it is less, what any two keyframes can miss at most.
double gliding_error(double u, double q);
inline constexpr double hermite_phase_max = 2.0 * std::numbers::pi;

/// Amplitude share that a cubic spline misses at phase step q = k dx, 0 .. pi.
double spline_error(double q);

/// Largest error of the derivative of a cubic spline at phase step q, as a share of q.
double spline_slope_error(double q);

/// Largest gain of two-dimensional cubic spline interpolation on bounded errors at the grid points
/// (Lebesgue constant 1.549 a dimension).
inline constexpr double spline_gain = 1.549 * 1.549;
/// Independent errors at the grid points: their variance grows at no place, and falls to 0.77 of it, by
/// dimension, on average 0.88. The variance of the derivative, in squares of the grid spacing: 3.42 at
/// most, in the middle of a cell, and 2.46 on average.
inline constexpr double spline_slope_variance_gain = 3.4217;
/// The same of even noise on the disc of waves that a grid holds (sea/surface/maps/regrid.h): the mean of kx^2,
/// (pi / spacing)^2 / 4, everywhere.
inline constexpr double disc_slope_variance_gain = std::numbers::pi * std::numbers::pi / 4.0;

/// Of a gradient, per m, when the sampled value may be wrong by that much: samples `spacing_m` apart.
double sampled_slope_error(double sampled_error, double spacing_m);

/// What single precision costs a sampled value, from the transform to the sum over cascades, as a share
/// of four times the rms of its map: twice the largest that random points showed on any device.
inline constexpr double single_precision_share = 5e-7;
/// What a smaller grid and back adds, over that (sea/surface/maps/regrid.h).
inline constexpr double regrid_over_single = 2.0;

} // namespace seaway::sea
