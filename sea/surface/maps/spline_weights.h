// SPDX-License-Identifier: Apache-2.0
// The cubic B-spline between grid points (Unser 1999), once for everything that samples maps. Nothing
// of the standard library, so that kernels compiled for one instruction set may include it. Pure.
#pragma once

namespace seaway::sea {

/// The four pieces of the spline at fraction f of a cell, by powers: the weight of coefficient i is
/// the sum over n of spline_pieces[n][i] f^n.
inline constexpr float spline_pieces[4][4] = {{1.0f / 6, 2.0f / 3, 1.0f / 6, 0.0f},
                                              {-0.5f, 0.0f, 0.5f, 0.0f},
                                              {0.5f, -1.0f, 0.5f, 0.0f},
                                              {-1.0f / 6, 0.5f, -0.5f, 1.0f / 6}};

/// Weights of coefficients around a point and their derivatives by f, side by side in vectors V of floats: of those whose
/// powers piece(0) to piece(3) hold. F: a float, or a vector V of several points'.
template <class F, class V, class Piece>
[[gnu::always_inline]] inline void spline_weights(const F& f, Piece piece, V& weight,
                                                  V& derivative) {
    const V c0 = piece(0), c1 = piece(1), c2 = piece(2), c3 = piece(3);
    weight = c0 + f * (c1 + f * (c2 + f * c3));
    derivative = c1 + f * (2.0f * c2 + f * (3.0f * c3));
}

/// Of all four, one in each float of V.
template <class V>
[[gnu::always_inline]] inline void spline_weights(float f, V& weight, V& derivative) {
    const auto piece = [](int n) {
        return V{spline_pieces[n][0], spline_pieces[n][1], spline_pieces[n][2],
                 spline_pieces[n][3]};
    };
    spline_weights(f, piece, weight, derivative);
}

} // namespace seaway::sea
