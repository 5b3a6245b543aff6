// SPDX-License-Identifier: Apache-2.0
// A two-dimensional array of numbers as a PNG (scaled, with the scale in the picture) and as an EXR
// (the numbers).
#pragma once

#include <optional>
#include <span>
#include <string>

#include "base/result.h"
#include "sea/basics/time.h"

namespace seaway::inspect {

struct Array2d {
    std::string title; ///< what it is, with its unit
    int rows = 0;
    int columns = 0;
    bool complex = false;
    double middle = 0.0;                ///< of real numbers: drawn white
    bool north_up = false;              ///< row 0 is drawn at the bottom
    double length_m = 0;                ///< of the tile that it is of
    std::optional<sea::TimeUs> time_us; ///< nothing: it is of no time
    std::span<const float> values;      ///< [row][column], complex ones [row][column][re, im]
};

/// Real numbers from blue over white to red, symmetric about the middle; magnitudes of complex ones over
/// six decades down from the largest.
Result<void> draw_array(const Array2d& array, const std::string& path);

/// Channels Y, or re and im; rows as they are in the array: where it has north up the first line is the south, and
/// `seaway.rows` says so. `seaway.length_m` and `seaway.time_us` are as in the files of seaway-bake.
Result<void> save_array(const Array2d& array, const std::string& path);

} // namespace seaway::inspect
