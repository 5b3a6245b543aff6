// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/patch_sheets.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "sea/surface/maps/spline_weights.h"
#include "sea/surface/patch_hull.h"

namespace seaway::sea {

namespace {

/// Boxes are worked out again within themselves while they shrink by this.
constexpr double worth_another_round = 0.6;

typedef float F4 __attribute__((vector_size(16)));

/// Four coefficients of two channels side by side, by halves.
struct Row {
    F4 west;
    F4 east;
};

void add(LagrangianPoint& sum, const SheetPatch& patch, Vec2 at) {
    const PatchLines::Place x = patch.x.place(at.x / patch.spacing_m);
    const PatchLines::Place y = patch.y.place(at.y / patch.spacing_m);
    F4 wx, dx, wy, dy;
    spline_weights(static_cast<float>(x.fraction), wx, dx);
    spline_weights(static_cast<float>(y.fraction), wy, dy);
    Row column{}, slope{};
    for (int j = 0; j < 4; ++j) {
        Row row;
        std::memcpy(&row, patch.moved_at(x.first, y.first + j), sizeof row);
        column.west += wy[j] * row.west;
        column.east += wy[j] * row.east;
        slope.west += dy[j] * row.west;
        slope.east += dy[j] * row.east;
    }
    const auto mixed = [](const Row& r, const F4& w) {
        const F4 both = r.west * F4{w[0], w[0], w[1], w[1]} + r.east * F4{w[2], w[2], w[3], w[3]};
        return Vec2{static_cast<double>(both[0] + both[2]), static_cast<double>(both[1] + both[3])};
    };
    const Vec2 value = mixed(column, wx), d_dx = mixed(column, dx), d_dy = mixed(slope, wx);
    sum.displacement_x += value.x;
    sum.displacement_y += value.y;
    sum.strain_xx += d_dx.x / patch.spacing_m;
    sum.strain_yy += d_dy.y / patch.spacing_m;
    sum.strain_xy += 0.5 * (d_dy.x + d_dx.y) / patch.spacing_m;
}

double height_of(const SheetPatch& patch, Vec2 at) {
    const PatchLines::Place x = patch.x.place(at.x / patch.spacing_m);
    const PatchLines::Place y = patch.y.place(at.y / patch.spacing_m);
    F4 wx, wy, unused;
    spline_weights(static_cast<float>(x.fraction), wx, unused);
    spline_weights(static_cast<float>(y.fraction), wy, unused);
    F4 column{};
    for (int j = 0; j < 4; ++j) {
        F4 row;
        std::memcpy(&row, patch.height_at(x.first, y.first + j), sizeof row);
        column += wy[j] * row;
    }
    const F4 all = column * wx;
    return static_cast<double>(all[0] + all[1] + all[2] + all[3]);
}

} // namespace

std::optional<Box> PatchSheets::narrowed(Box box, Vec2 target, std::span<const double> reach_m,
                                         bool solved) {
    double rest_m = blur_m();
    for (const double own_m : reach_m)
        rest_m += own_m;
    for (std::size_t c = 0; c < reach_m.size(); ++c) {
        if (!(reach_m[c] > 0))
            continue;
        rest_m -= reach_m[c];
        patches_.push_back(patch(c, box));
        for (bool again = true; again;) {
            const Box less = box.within(left_of(box, target, std::max(rest_m, blur_m())));
            if (less.empty()) // a reach was not enough
                break;
            again = less.area_m2() < worth_another_round * box.area_m2();
            box = less;
        }
    }
    if (solved && one_to_one(box))
        return std::nullopt;
    return box;
}

/// Solutions lie at x - lambda D: what the patches' D over a box leaves of it.
Box PatchSheets::left_of(const Box& box, Vec2 target, double rest_m) const {
    Box left{{target.x - rest_m, target.y - rest_m}, {target.x + rest_m, target.y + rest_m}};
    for (const SheetPatch& patch : patches_) {
        const SplineHull<2, 0> hull = hull_of<2, 0>(patch, patch.moved, box);
        left.low.x -= choppiness_.x * static_cast<double>(hull.value.high[0]);
        left.high.x -= choppiness_.x * static_cast<double>(hull.value.low[0]);
        left.low.y -= choppiness_.y * static_cast<double>(hull.value.high[1]);
        left.high.y -= choppiness_.y * static_cast<double>(hull.value.low[1]);
    }
    return left;
}

bool PatchSheets::one_to_one(const Box& box) const {
    Squeeze squeeze(choppiness_);
    for (const SheetPatch& patch : patches_) {
        const SplineHull<2, 1> hull = hull_of<2, 1>(patch, patch.moved, box);
        const double per_m = 1.0 / patch.spacing_m;
        const float xy_min = hull.y.low[0] + hull.x.low[1];
        const float xy_max = hull.y.high[0] + hull.x.high[1];
        squeeze.add(
            per_m * static_cast<double>(hull.x.low[0]), per_m * static_cast<double>(hull.y.low[1]),
            0.5 * per_m * static_cast<double>(std::max(std::abs(xy_min), std::abs(xy_max))));
    }
    return squeeze.smallest() > strain_blur();
}

LagrangianPoint PatchSheets::displaced(Vec2 at) const {
    LagrangianPoint sum;
    for (const SheetPatch& patch : patches_)
        add(sum, patch, at);
    return sum;
}

double PatchSheets::height(Vec2 at) const {
    double sum_m = 0;
    for (const SheetPatch& patch : patches_)
        sum_m += height_of(patch, at);
    return sum_m;
}

double PatchSheets::spacing_m() const {
    double finest_m = std::numeric_limits<double>::infinity();
    for (const SheetPatch& patch : patches_)
        finest_m = std::min(finest_m, patch.spacing_m);
    return finest_m;
}

RecycledVector<Roughness> PatchSheets::roughness(const Box& box) const {
    RecycledVector<Roughness> all;
    for (const SheetPatch& patch : patches_)
        all.push_back(
            hull_of<2, 2>(patch, patch.moved, box).roughness(0, 1, 1.0 / patch.spacing_m));
    return all;
}

RecycledVector<Rise> PatchSheets::rises(const Box& box) const {
    RecycledVector<Rise> all;
    for (const SheetPatch& patch : patches_)
        all.push_back(hull_of<1, 1>(patch, patch.height, box).rise(0, 1.0 / patch.spacing_m));
    return all;
}

} // namespace seaway::sea
