// SPDX-License-Identifier: Apache-2.0
// What each linear field is of a wave a exp(i (k.X - w t)), written out from the definitions and from nothing that the product has: D = i k/|k| coth(kd)
// eta, so that crests sharpen where points move by +D; slopes, strains and rates are derivatives.
#pragma once

#include <cmath>
#include <complex>

#include "sea/basics/field.h"

namespace seaway::tests {

/// Of its rate of change instead of the wave.
inline bool is_rate(sea::Field field) {
    using sea::Field;
    return field == Field::height_rate || field == Field::displacement_x_rate ||
           field == Field::displacement_y_rate;
}

/// By what a wave, or its rate, is multiplied. k = 0: nothing.
inline std::complex<double> of_wave(sea::Field field, double kx, double ky, double depth_m) {
    using sea::Field;
    using Complex = std::complex<double>;
    const double k = std::hypot(kx, ky);
    if (k == 0)
        return 0;
    const Complex i(0, 1), dx = i * kx, dy = i * ky; // derivatives
    const Complex sideways = i / (k * std::tanh(k * depth_m));
    switch (field) {
    case Field::height:
    case Field::height_rate:
        return 1;
    case Field::displacement_x:
    case Field::displacement_x_rate:
        return sideways * kx;
    case Field::displacement_y:
    case Field::displacement_y_rate:
        return sideways * ky;
    case Field::slope_x:
        return dx;
    case Field::slope_y:
        return dy;
    case Field::strain_xx:
        return dx * sideways * kx;
    case Field::strain_yy:
        return dy * sideways * ky;
    case Field::strain_xy:
        return dy * sideways * kx;
    case Field::jacobian:
    case Field::foam:
        break;
    }
    return 0;
}

} // namespace seaway::tests
