// SPDX-License-Identifier: Apache-2.0
// The horizontal displacement of one cascade around a place, as coefficients of a cubic B-spline.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

namespace seaway::sea {

struct DisplacementPatch {
    /// Lattice lines from two below to three above a box, all coefficients zero.
    DisplacementPatch(double x_low_m, double x_high_m, double y_low_m, double y_high_m,
                      double spacing)
        : spacing_m(spacing), column0(line(x_low_m) - 2), row0(line(y_low_m) - 2),
          columns(static_cast<int>(line(x_high_m) + 4 - column0)),
          rows(static_cast<int>(line(y_high_m) + 4 - row0)),
          coefficients(2 * static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows)) {}

    /// The lattice line at or below a coordinate.
    long line(double position_m) const {
        return static_cast<long>(std::floor(position_m / spacing_m));
    }

    double spacing_m;
    long column0; ///< coefficient [0][0] belongs to (column0, row0) * spacing
    long row0;
    int columns;
    int rows;
    std::vector<float> coefficients; ///< [row][column][D_x, D_y], m

    const float* at(int column, int row) const {
        return coefficients.data() +
               2 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                    static_cast<std::size_t>(column));
    }
};

} // namespace seaway::sea
