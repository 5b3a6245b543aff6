// SPDX-License-Identifier: Apache-2.0
// A sea of two tiles that folds, its maps and its exact sum, and its sheets by force.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "sea/surface/budget/error_budget.h"
#include "sea/surface/surface.h"
#include "tests/support/explicit_sea.h"

namespace seaway::sea::tests_of_folds {

inline constexpr TimeUs interval_us = 100'000;
inline constexpr TimeUs moment_us = 40'000;

/// A sea of two tiles that folds on some per cent of its surface, its maps and its exact sum.
struct FoldingSea {
    RealizationPtr sea;
    Surface surface;
    DirectSum sum;
    DirectSum::Moment moment;

    explicit FoldingSea(Choppiness choppiness, double steepness = 0.04)
        : sea(seaway::tests::make_sea(
              {seaway::tests::random_cascade(200.0, 64, 9, 60, steepness, 5),
               seaway::tests::random_cascade(31.0, 64, 9, 40, 0.75 * steepness, 6)},
              choppiness)),
          surface(surface_of(*this)), sum(sea), moment(sum.at_time(moment_us)) {}

    static Surface surface_of(const FoldingSea& self) {
        std::vector<SplinePair> pairs;
        for (int c = 0; c < 2; ++c) {
            const auto map = [&](TimeUs t) {
                return std::make_shared<const SplineMap>(
                    *seaway::tests::exact_keyframe(self.sea, c, t));
            };
            pairs.push_back({map(0), map(interval_us)});
        }
        const TimeUs intervals_us[] = {interval_us, interval_us};
        const ErrorBudget budget = plan_budget(*self.sea, 0.01, intervals_us);
        return Surface(std::move(pairs), self.sea->choppiness, fold_search(budget),
                       map_error(budget, 0));
    }
    Vec2 landed(Vec2 X, const LagrangianPoint& p) const {
        return {X.x + sea->choppiness.x * p.displacement_x,
                X.y + sea->choppiness.y * p.displacement_y};
    }
};

inline const FoldingSea& folding_sea() {
    static const FoldingSea sea({2.2, 2.2});
    return sea;
}

/// Heights of all sheets of the maps above x: Newton from every cell of a lattice, twice as fine as
/// the finest grid, that x may lie in the image of.
inline std::vector<double> sheets_by_force(const FoldingSea& sea, Vec2 x, double reach_m = 12) {
    constexpr double step_m = 31.0 / 128;
    const int n = static_cast<int>(2 * reach_m / step_m);
    std::vector<Vec2> off(static_cast<std::size_t>(n * n));
    const auto place = [&](double i, double j) {
        return Vec2{x.x - reach_m + i * step_m, x.y - reach_m + j * step_m};
    };
    const auto residual = [&](Vec2 X, LagrangianPoint& p) {
        p = sea.surface.at(X.x, X.y, moment_us);
        const Vec2 at = sea.landed(X, p);
        return Vec2{at.x - x.x, at.y - x.y};
    };
    LagrangianPoint p;
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i)
            off[static_cast<std::size_t>(j * n + i)] = residual(place(i, j), p);
    std::vector<Vec2> roots;
    std::vector<double> heights;
    for (int j = 0; j + 1 < n; ++j)
        for (int i = 0; i + 1 < n; ++i) {
            Vec2 low{1e9, 1e9}, high{-1e9, -1e9};
            for (const int corner : {0, 1, n, n + 1}) {
                const Vec2& r = off[static_cast<std::size_t>(j * n + i + corner)];
                low = {std::min(low.x, r.x), std::min(low.y, r.y)};
                high = {std::max(high.x, r.x), std::max(high.y, r.y)};
            }
            const double mx = 0.5 * (high.x - low.x), my = 0.5 * (high.y - low.y); // it is curved
            if (low.x - mx > 0 || high.x + mx < 0 || low.y - my > 0 || high.y + my < 0)
                continue;
            Vec2 X = place(i + 0.5, j + 0.5);
            for (int step = 0; step < 20; ++step) {
                const Vec2 r = residual(X, p);
                if (std::hypot(r.x, r.y) < 2e-6) {
                    const bool known = std::any_of(roots.begin(), roots.end(), [&](Vec2 other) {
                        return std::hypot(other.x - X.x, other.y - X.y) < 2e-3;
                    });
                    if (!known) {
                        roots.push_back(X);
                        heights.push_back(p.height);
                    }
                    break;
                }
                const Choppiness& l = sea.sea->choppiness;
                const double a = 1 + l.x * p.strain_xx, b = l.x * p.strain_xy;
                const double c = l.y * p.strain_xy, d = 1 + l.y * p.strain_yy;
                Vec2 move{-(d * r.x - b * r.y) / (a * d - b * c),
                          -(a * r.y - c * r.x) / (a * d - b * c)};
                const double shorten = std::min(1.0, 2 * step_m / std::hypot(move.x, move.y));
                X = {X.x + shorten * move.x, X.y + shorten * move.y};
            }
        }
    return heights;
}

} // namespace seaway::sea::tests_of_folds
