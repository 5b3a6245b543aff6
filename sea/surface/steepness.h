// SPDX-License-Identifier: Apache-2.0
// How a surface lies where its gradients are known: its normal, and how steep it is. Real: double, or a vector of them, of
// several points side by side, with the same bits.
//
// Normals are the cross product of the two tangents (traps T44, F16). Pure.
#pragma once

#include <cmath>
#include <cstddef>
#include <type_traits>

#include "sea/basics/lagrangian_point.h"
#include "sea/waves/realization.h"

namespace seaway::sea {

template <class Real>
[[gnu::always_inline]] inline Real root(const Real& value) {
    if constexpr (std::is_same_v<Real, double>)
        return std::sqrt(value);
    else {
        Real roots;
        for (std::size_t p = 0; p < sizeof(Real) / sizeof(double); ++p)
            roots[p] = __builtin_sqrt(value[p]);
        return roots;
    }
}

/// By the undisplaced place, choppiness not in it.
template <class Real>
struct Gradients {
    Real slope_x, slope_y;
    Real strain_xx, strain_yy, strain_xy;
};

inline Gradients<double> gradients_of(const LagrangianPoint& p) {
    return {p.slope_x, p.slope_y, p.strain_xx, p.strain_yy, p.strain_xy};
}

/// det(I + lambda grad D).
template <class Real>
[[gnu::always_inline]] inline Real jacobian(const Gradients<Real>& g, const Choppiness& l) {
    return (1.0 + l.x * g.strain_xx) * (1.0 + l.y * g.strain_yy) -
           l.x * l.y * g.strain_xy * g.strain_xy;
}

template <class Real>
struct Normal {
    Real x, y, z;
};

/// Tangent d/dX x tangent d/dY, not normalised. Its z is the Jacobian.
template <class Real>
[[gnu::always_inline]] inline Normal<Real> normal_of(const Gradients<Real>& g,
                                                     const Choppiness& l) {
    return {l.y * g.strain_xy * g.slope_y - (1.0 + l.y * g.strain_yy) * g.slope_x,
            l.x * g.strain_xy * g.slope_x - (1.0 + l.x * g.strain_xx) * g.slope_y, jacobian(g, l)};
}

/// Of length 1, turned up where it points down: on the underside of a fold. (0, 0, 1) where there is none.
template <class Real>
[[gnu::always_inline]] inline Normal<Real> upright(const Normal<Real>& n) {
    const Real none = Real{}, one = Real{} + 1;
    const Real length = root(n.x * n.x + n.y * n.y + n.z * n.z);
    const Real scale = length > none ? (n.z < none ? -one : one) / length : none;
    return {n.x * scale, n.y * scale, length > none ? n.z * scale : one};
}

/// The steepness |grad eta| in world coordinates of a normal that points up, capped at 10.
template <class Real>
[[gnu::always_inline]] inline Real capped_slope(const Real& horizontal, const Real& vertical) {
    const Real most = Real{} + 10;
    return horizontal < most * vertical ? horizontal / vertical : most;
}
/// Of normal_of() where J is above 0.4: as steep as it is.
template <class Real>
[[gnu::always_inline]] inline Real gentle_slope(const Normal<Real>& n) {
    return root(n.x * n.x + n.y * n.y) / n.z;
}

/// A height beside a place `residual_m` off that solves the equation, of a surface that bends by `curvature_per_m` at choppiness 0
/// and is squeezed to J: beyond what the slope there says.
template <class Real>
[[gnu::always_inline]] inline Real bent_m(double curvature_per_m, const Real& residual_m,
                                          const Real& j) {
    return curvature_per_m * residual_m * residual_m / (j * j * j);
}

template <class Real>
[[gnu::always_inline]] inline Real slope_of(const Normal<Real>& n) {
    return capped_slope(root(n.x * n.x + n.y * n.y), n.z);
}

} // namespace seaway::sea
