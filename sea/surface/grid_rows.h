// SPDX-License-Identifier: Apache-2.0
// GridRows: one cascade at one time, at all of its grid points: what Surface::at() says there, row by row. At a grid point the
// weights of a spline are 1/6, 2/3, 1/6, so a row takes nine sums where a place takes sixteen products of each of two maps.
//
// Single precision. Some 10 ns a point, which is a tenth of Surface::at(); row after row, from the first. Not thread-safe.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "sea/basics/lagrangian_point.h"
#include "sea/surface/maps/hermite.h"
#include "sea/surface/surface.h"

namespace seaway::sea {

class GridRows {
  public:
    /// The pair's maps stay until it ends.
    GridRows(const SplinePair& pair, TimeUs time_us);

    int size() const { return size_; }
    /// The next row towards north, [x]; until the one after. `size` rows, then none.
    std::span<const LagrangianPoint> next();

  private:
    typedef float F4 __attribute__((vector_size(16)));
    /// Coefficients mixed in time: channels of spline_channels.h, and their time rates.
    struct Mixed {
        F4 value;
        F4 rate;
    };
    std::vector<Mixed> mixed(int row) const;

    const SplineMap& before_;
    const SplineMap& after_;
    const int size_;
    const float cells_a_metre_;
    HermiteWeights weights_;
    int row_ = 0;
    std::array<std::vector<Mixed>, 3> rows_; ///< south of, at and north of the next one
    std::vector<LagrangianPoint> points_;
};

} // namespace seaway::sea
