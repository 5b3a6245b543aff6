// SPDX-License-Identifier: Apache-2.0
// The horizontal displacement and the height of one cascade around a place, as coefficients of a cubic
// B-spline. Where a box is as wide as the tile, its lines come round: none is held twice.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "base/recycled.h"

namespace seaway::sea {

/// Along one axis: which lattice lines a patch holds, and where.
struct PatchLines {
    /// From two below to three above the interval, of a tile of `a_tile` lines.
    PatchLines(double low_m, double high_m, double spacing_m, int a_tile)
        : first(line(low_m, spacing_m) - 2), period(a_tile),
          count(static_cast<int>(
              std::min(line(high_m, spacing_m) + 4 - first, static_cast<long>(a_tile) + 5))) {}

    /// The lattice line at or below a coordinate.
    static long line(double position_m, double spacing_m) {
        return number(std::floor(position_m / spacing_m));
    }
    /// The last one beyond where doubles tell lines apart, 0 of what is no number: nothing overflows.
    static long number(double whole) {
        constexpr double told_apart = 0x1p53;
        return std::isnan(whole) ? 0
                                 : static_cast<long>(std::clamp(whole, -told_apart, told_apart));
    }
    bool round() const { return count == period + 5; } ///< all lines of the tile are held
    /// Where the first of the four lines is held that a spline at `u` lattice steps is made of, and
    /// how far `u` lies beyond the second one, 0 .. 1 within what is held.
    struct Place {
        int first;
        double fraction;
    };
    Place place(double u) const {
        const double second = std::floor(u);
        const long off = number(second) - 1 - first;
        if (round())
            return {turned(off), u - second};
        const long held = std::clamp(off, 0L, static_cast<long>(count) - 4);
        return {static_cast<int>(held), u - static_cast<double>(first + held + 1)};
    }
    /// Lines that splines between two places are made of, as offsets; a whole round at most. All of
    /// them have a neighbour on both sides once turned() has said where they are held.
    struct Range {
        long begin;
        long end;
    };
    Range range(double low_m, double high_m, double spacing_m) const {
        const long begin = line(low_m, spacing_m) - 1 - first;
        const long end = line(high_m, spacing_m) + 3 - first;
        if (round())
            return {begin, std::min(end, begin + period)};
        return {std::max(begin, 1L), std::min(end, static_cast<long>(count) - 1)};
    }
    /// Where an offset is held.
    int turned(long off) const {
        if (!round())
            return static_cast<int>(off);
        const long rest = (off - 1) % period;
        return static_cast<int>(1 + (rest < 0 ? rest + period : rest));
    }

    long first;
    int period;
    int count;
};

struct SheetPatch {
    SheetPatch(double x_low_m, double x_high_m, double y_low_m, double y_high_m, double spacing,
               int lines_a_tile)
        : spacing_m(spacing), x(x_low_m, x_high_m, spacing, lines_a_tile),
          y(y_low_m, y_high_m, spacing, lines_a_tile),
          moved(2 * static_cast<std::size_t>(x.count) * static_cast<std::size_t>(y.count)),
          height(moved.size() / 2) {}

    std::size_t at(int column, int row) const {
        return static_cast<std::size_t>(row) * static_cast<std::size_t>(x.count) +
               static_cast<std::size_t>(column);
    }
    const float* moved_at(int column, int row) const { return moved.data() + 2 * at(column, row); }
    const float* height_at(int column, int row) const { return height.data() + at(column, row); }

    double spacing_m;
    PatchLines x, y;
    RecycledVector<float> moved;  ///< [row][column][D_x, D_y], m
    RecycledVector<float> height; ///< [row][column], m
};

} // namespace seaway::sea
