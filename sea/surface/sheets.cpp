// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/sheets.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace seaway::sea {

namespace {

constexpr int newton_steps_max = 20;
/// Solutions this many tolerances apart are two.
constexpr double apart_tolerances = 10;
constexpr std::size_t edges_max = 16;

/// Kantorovich: Newton from the middle of a box converges to its one solution where the gradient
/// changes by less than this share of its smallest singular value. What the field may be wrong by does
/// not keep Newton from converging; it is one to one all the same while both together stay below s1.
constexpr double kantorovich = 0.4;

/// X + lambda D(X) - x and its gradient at a place.
struct Local {
    Vec2 residual;
    double a, b, c, d; ///< rows of I + lambda grad D
    double determinant() const { return a * d - b * c; }
};

/// Left vectors u, right vectors v and singular values of the gradient, the smaller one first.
struct Singular {
    double value[2];
    Vec2 u[2];
    Vec2 v[2];

    explicit Singular(const Local& l) {
        // Eigenvectors of A^T A.
        const double xx = l.a * l.a + l.c * l.c;
        const double yy = l.b * l.b + l.d * l.d;
        const double xy = l.a * l.b + l.c * l.d;
        const double half = 0.5 * (xx - yy);
        const double radius = std::sqrt(half * half + xy * xy);
        const double cosine = radius > 0 ? half / radius : 1; // of twice the angle
        v[1] = {std::sqrt(0.5 * (1 + cosine)), std::copysign(std::sqrt(0.5 * (1 - cosine)), xy)};
        v[0] = {-v[1].y, v[1].x};
        const Vec2 image{l.a * v[1].x + l.b * v[1].y, l.c * v[1].x + l.d * v[1].y};
        value[1] = std::sqrt(image.x * image.x + image.y * image.y);
        value[0] = value[1] > 0 ? std::abs(l.determinant()) / value[1] : 0;
        u[1] = value[1] > 0 ? Vec2{image.x / value[1], image.y / value[1]} : v[1];
        const double turn = l.determinant() < 0 ? -1 : 1;
        u[0] = {-turn * u[1].y, turn * u[1].x};
    }
};

class Search {
  public:
    Search(const SheetSearch& search, const SheetField& field)
        : search_(search), field_(field), roughness_(field.roughness(search.box)),
          sideways_(std::max(search.choppiness.x, search.choppiness.y)) {
        double bend = 0;
        for (const Roughness& r : roughness_)
            bend += sideways_ * r.bend_per_m;
        // At the edge of a fold the residual stays within the blur over sqrt(2 blur / bend).
        smallest_m_ = 0.25 * std::sqrt(search.blur_m / std::max(bend, 1e-9));
    }

    Sheets run() {
        std::vector<Box> open{search_.box};
        while (!open.empty()) {
            const Box box = open.back();
            open.pop_back();
            if (sheets_.evaluations >= sheet_evaluations_max) {
                sheets_.folded = true;
                break;
            }
            if (settled(box))
                continue;
            const Vec2 m = box.middle();
            Box low = box, high = box;
            if (box.high.x - box.low.x > box.high.y - box.low.y)
                low.high.x = high.low.x = m.x;
            else
                low.high.y = high.low.y = m.y;
            open.push_back(low);
            open.push_back(high);
        }
        return std::move(sheets_);
    }

  private:
    Local evaluate(Vec2 at) {
        ++sheets_.evaluations;
        const LagrangianPoint p = field_.displaced(at);
        const Choppiness& l = search_.choppiness;
        return {{at.x + l.x * p.displacement_x - search_.target.x,
                 at.y + l.y * p.displacement_y - search_.target.y},
                1 + l.x * p.strain_xx,
                l.x * p.strain_xy,
                l.y * p.strain_xy,
                1 + l.y * p.strain_yy};
    }

    /// Nothing more to be learnt from this box.
    bool settled(const Box& box) {
        const Vec2 middle = box.middle();
        const double half_x = box.high.x - middle.x, half_y = box.high.y - middle.y;
        const double radius_m = std::sqrt(half_x * half_x + half_y * half_y);
        const Local here = evaluate(middle);
        const Singular s(here);
        double bent = 0, shifted_m = 0; // of the gradient, and beyond what it says
        for (const Roughness& r : roughness_) {
            const double gradient = std::min(r.bend_per_m * radius_m, r.strain_range);
            bent += sideways_ * gradient;
            shifted_m +=
                sideways_ * std::min({0.5 * r.bend_per_m * radius_m * radius_m, gradient * radius_m,
                                      r.range_m + r.strain_range * radius_m});
        }
        for (int i = 0; i < 2; ++i) {
            const double off_m = std::abs(s.u[i].x * here.residual.x + s.u[i].y * here.residual.y);
            const double spans_m = std::abs(s.v[i].x) * half_x + std::abs(s.v[i].y) * half_y;
            if (off_m > s.value[i] * spans_m + shifted_m + search_.blur_m)
                return true;
        }
        if (bent < kantorovich * s.value[0] && bent + search_.strain_blur < s.value[0]) {
            add_solution(middle, here, radius_m);
            return true;
        }
        if (radius_m > smallest_m_)
            return false;
        add_edge(middle, s.v[0]);
        return true;
    }

    /// The map is one to one here.
    void add_solution(Vec2 start, const Local& middle, double radius_m) {
        const std::optional<Vec2> at = newton(start, middle, 4 * radius_m);
        if (!at)
            return;
        if (middle.determinant() < 0)
            sheets_.folded = true;
        const bool known =
            std::any_of(sheets_.found.begin(), sheets_.found.end(), [&](const Vec2& other) {
                return std::hypot(other.x - at->x, other.y - at->y) <
                       apart_tolerances * search_.solved_m;
            });
        if (!known)
            sheets_.found.push_back(*at);
    }

    std::optional<Vec2> newton(Vec2 at, Local local, double leash_m) {
        const Vec2 start = at;
        for (int step = 0; step < newton_steps_max; ++step) {
            const Vec2& r = local.residual;
            if (std::hypot(r.x, r.y) <= search_.solved_m)
                return at;
            const double det = local.determinant();
            at.x -= (local.d * r.x - local.b * r.y) / det;
            at.y -= (local.a * r.y - local.c * r.x) / det;
            if (!(std::hypot(at.x - start.x, at.y - start.y) <= leash_m))
                return std::nullopt;
            local = evaluate(at);
        }
        return std::nullopt;
    }

    /// Too small to tell: the edge of a fold. One place stands for those around it. Where two sheets
    /// meet, they lie on either side along the direction that the gradient nearly puts to nothing.
    void add_edge(Vec2 at, Vec2 across) {
        sheets_.folded = true;
        const bool known = std::any_of(edges_.begin(), edges_.end(), [&](const Vec2& other) {
            return std::hypot(other.x - at.x, other.y - at.y) < 16 * smallest_m_;
        });
        if (known || edges_.size() >= edges_max)
            return;
        edges_.push_back(at);
        const double apart_m = 4 * smallest_m_;
        for (const double side_m : {-apart_m, apart_m})
            sheets_.found.push_back({at.x + side_m * across.x, at.y + side_m * across.y});
    }

    const SheetSearch& search_;
    const SheetField& field_;
    std::vector<Roughness> roughness_;
    double sideways_;
    double smallest_m_;
    std::vector<Vec2> edges_;
    Sheets sheets_;
};

} // namespace

Box Box::within(const Box& other) const {
    return {{std::max(low.x, other.low.x), std::max(low.y, other.low.y)},
            {std::min(high.x, other.high.x), std::min(high.y, other.high.y)}};
}

Box Box::around(Vec2 middle, double half_x_m, double half_y_m) {
    return {{middle.x - half_x_m, middle.y - half_y_m}, {middle.x + half_x_m, middle.y + half_y_m}};
}

Sheets find_sheets(const SheetSearch& search, const SheetField& field) {
    return Search(search, field).run();
}

} // namespace seaway::sea
