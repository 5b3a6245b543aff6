// SPDX-License-Identifier: Apache-2.0
// Lookup and inverse displacement as engines are shipped with them.
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "sea/basics/lagrangian_point.h"

namespace seaway::naive {

using Field = std::function<sea::LagrangianPoint(double, double)>;

struct Undisplaced {
    double x_m, y_m;
    int steps;
};

/// D2: X = x - D(X) again and again, without damping; contracts only where |grad D| < 1.
inline Undisplaced fixed_point(const Field& field, double x_m, double y_m, double tolerance_m,
                               int steps_max) {
    double X = x_m, Y = y_m;
    for (int step = 1;; ++step) {
        const sea::LagrangianPoint p = field(X, Y);
        const double miss = std::hypot(X + p.displacement_x - x_m, Y + p.displacement_y - y_m);
        if (!(miss > tolerance_m) || step > steps_max)
            return {X, Y, step};
        X = x_m - p.displacement_x;
        Y = y_m - p.displacement_y;
    }
}

/// D4: one Newton step along x, residual over Jacobian, however small that is, m.
inline double newton_step_m(const Field& field, double x_m, double X) {
    const sea::LagrangianPoint p = field(X, 0);
    return (x_m - X - p.displacement_x) / (1 + p.strain_xx);
}

/// D1: the cross product of the tangents as it comes, which looks down where the surface is turned.
/// Its z, not normalised.
inline double normal_z(const sea::LagrangianPoint& p) {
    return (1 + p.strain_xx) * (1 + p.strain_yy) - p.strain_xy * p.strain_xy;
}

/// D5: x = X + D where waves pile up at x = X - D: the other sign.
inline Field turned(const Field& field) {
    return [field](double X, double Y) {
        sea::LagrangianPoint p = field(X, Y);
        for (double* part :
             {&p.displacement_x, &p.displacement_y, &p.strain_xx, &p.strain_yy, &p.strain_xy})
            *part = -*part;
        return p;
    };
}

/// D7: the steepness from slopes alone, as if the grid had not moved. Along x.
inline double angle_of_slope_rad(const sea::LagrangianPoint& p) {
    return std::atan(p.slope_x);
}

/// D6: each cascade inverted by itself, and the heights added.
inline double inverted_apart_m(const std::vector<Field>& cascades, double x_m, double y_m) {
    double height = 0;
    for (const Field& field : cascades) {
        const Undisplaced at = fixed_point(field, x_m, y_m, 1e-9, 1000);
        height += field(at.x_m, at.y_m).height;
    }
    return height;
}

/// G1: coordinates in floats.
inline double in_a_float(double x_m) {
    return static_cast<double>(static_cast<float>(x_m));
}

/// G3: one wrap, by the longest tile, for all cascades.
inline double wrapped_once(double x_m, double longest_m) {
    return x_m - longest_m * std::floor(x_m / longest_m);
}

/// G6: straight lines between grid points, along x: values(i) at i * spacing_m.
inline double linear_lookup(const std::function<double(int)>& values, double x_m,
                            double spacing_m) {
    const double at = x_m / spacing_m, whole = std::floor(at);
    const int i = static_cast<int>(whole);
    return values(i) + (at - whole) * (values(i + 1) - values(i));
}

/// F10: slopes of heights as they were coded, by central differences of grid points.
inline double difference_slope(double before_m, double after_m, double spacing_m) {
    return (after_m - before_m) / (2 * spacing_m);
}

} // namespace seaway::naive
