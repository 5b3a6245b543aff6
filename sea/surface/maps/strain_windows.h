// SPDX-License-Identifier: Apache-2.0
// How strongly a map squeezes the surface around a place: what tells at the price of a table look-up
// that no second sheet lies near, and what bounds the search where one may (sea/surface/sheets.h).
//
// The derivative of a B-spline is a weighted mean of the differences of its coefficients, so within a cell
// their smallest and largest bound it (the convex hull property), and with them the smallest eigenvalue of the
// strain: these bounds are proved, and a tenth to a third wider than what they bound.
//
// A sea between two keyframes is a mean of what they are when carried on, or back, by their time rates (Hermite's cubic in Bernstein's
// form; G. Farin, "Curves and Surfaces for CAGD", 5th ed., 2002, 4.2 and 4.6), so it is the carried maps that are bounded: bounds of
// values and of rates by themselves add up as if both were at their largest at once, which no wave's are.
//
// Immutable; thread-safe. A tenth of a map's memory; 1.3 ms for a map of 256 x 256.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "base/large_vector.h"
#include "sea/surface/maps/pauses.h"

namespace seaway::sea {

/// Bounds of strains and displacements at choppiness 1 over a window of a map, carried on by its time rates for
/// StrainWindows::carried_s() and carried back, and of these rates, 1/s. Half a line of a cache.
struct alignas(16) StrainBounds {
    float range_on_m = 0;   ///< |D(a) - D(b)| within the window, carried on
    float range_back_m = 0; ///< carried back
    float range_rate = 0;   ///< of dD/dt, m/s
    float unused = 0;
    float strain_on = 0;   ///< the smallest eigenvalue of the symmetric part of grad D, carried on
    float strain_back = 0; ///< carried back
    float strain_rate = 0; ///< the largest absolute eigenvalue of its time rate
    float unused_too = 0;

    /// Of the map as it is: it is the mean of both.
    float range_m() const { return 0.5f * (range_on_m + range_back_m); }
    float strain_min() const { return 0.5f * (strain_on + strain_back); }
};

class StrainWindows {
  public:
    /// Of the coefficients of a SplineMap, as SplineMap::coefficients() lays them out.
    StrainWindows(const float* coefficients, int size, double length_m, Pauses& pauses);

    /// A cell of the grid: that of all maps of the same size and length.
    struct Cell {
        int x;
        int y;
    };
    Cell cell(double x_m, double y_m) const {
        const auto along = [this](double position_m) {
            const double turns = position_m / length_m_;
            const double line = (turns - std::floor(turns)) * size_;
            return line < size_ - 1 ? static_cast<int>(line) : size_ - 1; // of no number, too
        };
        return {along(x_m), along(y_m)};
    }
    /// Holds everywhere within `radius_m` of any place of the cell. The index is that of all maps of the same
    /// size and length.
    std::size_t place(const Cell& cell, double radius_m) const {
        const double radius = radius_m * cells_a_metre_;
        std::size_t i = 0;
        while (i + 1 < levels_.size() && !(radius <= levels_[i].reach))
            ++i;
        const Level& level = levels_[i];
        return level.first + static_cast<std::size_t>((cell.y >> level.shift) * level.blocks +
                                                      (cell.x >> level.shift));
    }
    const StrainBounds& at(std::size_t place) const { return windows_[place]; }
    const StrainBounds& around(double x_m, double y_m, double radius_m) const {
        return at(place(cell(x_m, y_m), radius_m));
    }

    const StrainBounds& whole_tile() const { return windows_.back(); }
    /// For how long bounds are carried: what is mixed of keyframes as far apart as budgets have them is carried about as far.
    double carried_s() const { return carried_s_; }
    std::size_t bytes() const { return windows_.size() * sizeof(StrainBounds); }
    /// Of a map of this size.
    static std::size_t bytes_of(int size);

  private:
    struct Level {
        double reach; ///< cells beyond a block that its window holds
        int shift;    ///< of a cell's number to its block's
        int blocks;   ///< a side
        std::size_t first;
    };

    int size_;
    double length_m_;
    double cells_a_metre_;
    double carried_s_;
    std::vector<Level> levels_;
    LargeVector<StrainBounds> windows_; ///< [level][y][x]: a block and those around it
};

} // namespace seaway::sea
