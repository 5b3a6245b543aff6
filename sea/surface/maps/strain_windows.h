// SPDX-License-Identifier: Apache-2.0
// How strongly a map squeezes the surface around a place: what tells at the price of a table look-up
// that no second sheet lies near, and what bounds the search where one may (sea/surface/sheets.h).
//
// The derivative of a B-spline is a weighted mean of the differences of its coefficients, so their
// smallest and largest bound it everywhere (the convex hull property): these bounds are proved, and a
// tenth to a third wider than what they bound.
//
// Immutable; thread-safe. A tenth of a map's memory; about 1 ms for a map of 256 x 256.
#pragma once

#include <cstddef>
#include <vector>

namespace seaway::sea {

/// Bounds of strains and displacements at choppiness 1 over a window of a map, and of their time
/// rates, 1/s. Half a line of a cache.
struct alignas(32) StrainBounds {
    float range_m = 0; ///< |D(a) - D(b)| within the window
    float xx_min = 0;
    float yy_min = 0;
    float xy_size = 0;    ///< largest absolute value, as those of the rates
    float range_rate = 0; ///< as range_m, m/s
    float xx_rate = 0;
    float yy_rate = 0;
    float xy_rate = 0;
};

class StrainWindows {
  public:
    /// Of the coefficients of a SplineMap, as SplineMap::coefficients() lays them out.
    StrainWindows(const float* coefficients, int size, double length_m);

    /// Holds everywhere within `radius_m` of the place.
    const StrainBounds& around(double x_m, double y_m, double radius_m) const {
        return at(place(x_m, y_m, radius_m));
    }
    /// The same in two steps: the place is that of all maps of the same size and length.
    std::size_t place(double x_m, double y_m, double radius_m) const;
    const StrainBounds& at(std::size_t place) const { return windows_[place]; }

    const StrainBounds& whole_tile() const { return windows_.back(); }
    std::size_t bytes() const { return windows_.size() * sizeof(StrainBounds); }
    /// Of a map of this size.
    static std::size_t bytes_of(int size);

  private:
    struct Level {
        int block; ///< grid points a side
        int blocks;
        std::size_t first;
    };

    int size_;
    double length_m_;
    std::vector<Level> levels_;
    std::vector<StrainBounds> windows_; ///< [level][y][x]: a block and those around it
};

} // namespace seaway::sea
