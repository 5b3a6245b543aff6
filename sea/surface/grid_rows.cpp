// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/grid_rows.h"

#include <cstring>
#include <utility>

namespace seaway::sea {

GridRows::GridRows(const SplinePair& pair, TimeUs time_us)
    : before_(*pair.before), after_(*pair.after), size_(before_.size()),
      cells_a_metre_(static_cast<float>(size_ / before_.length_m())),
      weights_(hermite_weights(before_.time_us(), after_.time_us(), time_us)), rows_{mixed(-1),
                                                                                     mixed(0),
                                                                                     {}},
      points_(static_cast<std::size_t>(size_)) {}

/// From the column -1 to size.
std::vector<GridRows::Mixed> GridRows::mixed(int row) const {
    const auto count = static_cast<std::size_t>(size_ + 2);
    const auto pitch = static_cast<std::size_t>(size_ + SplineMap::border) * SplineMap::channels;
    const std::size_t first = static_cast<std::size_t>(row + 1) * pitch;
    const float* before = before_.coefficients().data() + first;
    const float* after = after_.coefficients().data() + first;
    F4 value[4], rate[4];
    for (int i = 0; i < 4; ++i) {
        value[i] = F4{} + static_cast<float>(weights_.value[i]);
        rate[i] = F4{} + static_cast<float>(weights_.rate[i]);
    }
    std::vector<Mixed> row_of(count);
    for (Mixed& one : row_of) {
        F4 parts[4]; // values and rates, before and after
        std::memcpy(parts, before, 2 * sizeof(F4));
        std::memcpy(parts + 2, after, 2 * sizeof(F4));
        one.value =
            value[0] * parts[0] + value[1] * parts[1] + value[2] * parts[2] + value[3] * parts[3];
        one.rate =
            rate[0] * parts[0] + rate[1] * parts[1] + rate[2] * parts[2] + rate[3] * parts[3];
        before += SplineMap::channels;
        after += SplineMap::channels;
    }
    return row_of;
}

std::span<const LagrangianPoint> GridRows::next() {
    if (row_ == size_)
        return {};
    using spline_channel::height, spline_channel::displacement_x, spline_channel::displacement_y;
    rows_[2] = mixed(row_ + 1);
    const auto &south = rows_[0], &here = rows_[1], &north = rows_[2];
    const auto between = [](const F4& a, const F4& b, const F4& c) {
        return (a + c) * (1.0f / 6) + b * (2.0f / 3);
    };
    struct Column {
        F4 value, rate, d_dy;
    };
    const auto column = [&](std::size_t x) {
        return Column{between(south[x].value, here[x].value, north[x].value),
                      between(south[x].rate, here[x].rate, north[x].rate),
                      (north[x].value - south[x].value) * (0.5f * cells_a_metre_)};
    };
    Column west = column(0), middle = column(1);
    for (std::size_t x = 0; x < points_.size(); ++x) {
        const Column east = column(x + 2);
        const F4 value = between(west.value, middle.value, east.value);
        const F4 rate = between(west.rate, middle.rate, east.rate);
        const F4 d_dx = (east.value - west.value) * (0.5f * cells_a_metre_);
        const F4 d_dy = between(west.d_dy, middle.d_dy, east.d_dy);
        const auto of = [](const F4& channels, int c) { return static_cast<double>(channels[c]); };
        points_[x] = {.height = of(value, height),
                      .displacement_x = of(value, displacement_x),
                      .displacement_y = of(value, displacement_y),
                      .height_rate = of(rate, height),
                      .displacement_x_rate = of(rate, displacement_x),
                      .displacement_y_rate = of(rate, displacement_y),
                      .slope_x = of(d_dx, height),
                      .slope_y = of(d_dy, height),
                      .strain_xx = of(d_dx, displacement_x),
                      .strain_yy = of(d_dy, displacement_y),
                      .strain_xy = 0.5 * (of(d_dy, displacement_x) + of(d_dx, displacement_y))};
        west = middle;
        middle = east;
    }
    rows_[0] = std::move(rows_[1]);
    rows_[1] = std::move(rows_[2]);
    ++row_;
    return points_;
}

} // namespace seaway::sea
