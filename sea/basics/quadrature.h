// SPDX-License-Identifier: Apache-2.0
// Gauss-Legendre quadrature, 16 points a panel. For smooth integrands 8 panels reach rounding.
#pragma once

#include <array>

namespace seaway::sea {

struct QuadratureNode {
    double x; ///< in (0, 1); the rule is symmetric about 0
    double weight;
};

inline constexpr std::array<QuadratureNode, 8> gauss_legendre_16{{
    {0.989400934991649932, 0.027152459411754094},
    {0.944575023073232576, 0.062253523938647892},
    {0.865631202387831743, 0.095158511682492784},
    {0.755404408355003033, 0.124628971255533872},
    {0.617876244402643748, 0.149595988816576732},
    {0.458016777657227386, 0.169156519395002538},
    {0.281603550779258913, 0.182603415044923588},
    {0.095012509837637440, 0.189450610455068496},
}};

/// Integral of f over [a, b] in `panels` equal panels.
template <class F>
double integrate(const F& f, double a, double b, int panels) {
    double sum = 0.0;
    const double half = 0.5 * (b - a) / panels;
    for (int p = 0; p < panels; ++p) {
        const double middle = a + (2 * p + 1) * half;
        for (const QuadratureNode& node : gauss_legendre_16)
            sum += node.weight * (f(middle - half * node.x) + f(middle + half * node.x));
    }
    return sum * half;
}

} // namespace seaway::sea
