// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/sheets.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace seaway::sea {

namespace {

constexpr int sheet_steps_max = 20;
/// Solutions this many tolerances apart are two.
constexpr double apart_tolerances = 10;
constexpr std::size_t edges_max = 16;
/// Bounds are worked out anew for boxes this much smaller than what they were made for, in searches
/// that take longer than this.
constexpr double worth_new_bounds = 1.0 / 12;
constexpr int known_bounds_do = 500;

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

/// What is known of all places in a box.
struct Region {
    Box box;
    RecycledVector<Roughness> parts;
    RecycledVector<Rise> rises{};
    double bend_per_m = 0; ///< of lambda grad D
    double smallest_m = 0; ///< smaller boxes are not halved
};

/// A box that may hold solutions, none of them above `upper_m`.
struct Node {
    double upper_m;
    Box box;
    std::size_t region;
    bool operator<(const Node& other) const { return upper_m < other.upper_m; }
};

class Search {
  public:
    Search(const SheetSearch& search, const SheetField& field)
        : search_(search), field_(field), sideways_(search.choppiness.largest()),
          finest_m2_(field.spacing_m() * field.spacing_m()) {
        if (search.known) {
            best_m_ = field.height(*search.known);
            sheets_.folded = evaluate(*search.known).determinant() < 0;
        }
    }

    Sheets run() {
        halve_or_settle({unbounded, search_.box, add_region(search_.box)});
        while (!open_.empty()) {
            std::pop_heap(open_.begin(), open_.end());
            const Node node = open_.back();
            open_.pop_back();
            if (too_low(node.upper_m))
                break;
            if (sheets_.evaluations >= sheet_evaluations_max) {
                sheets_.folded = sheets_.ended_early = true;
                break;
            }
            halve_or_settle(node);
        }
        sheets_.open = !(doubtful_m_ + search_.height_blur_m < best_m_);
        return std::move(sheets_);
    }

  private:
    static constexpr double unbounded = std::numeric_limits<double>::infinity();

    std::size_t add_region(const Box& box) {
        Region region{box, field_.roughness(box)};
        region.bend_per_m = bend_of(region.parts);
        // At the edge of a fold the residual stays within the blur over sqrt(2 blur / bend).
        region.smallest_m = 0.25 * std::sqrt(search_.blur_m / std::max(region.bend_per_m, 1e-9));
        regions_.push_back(std::move(region));
        return regions_.size() - 1;
    }

    /// What is folded in any case is asked for its highest sheet alone.
    bool too_low(double upper_m) const {
        return sheets_.folded && upper_m + search_.height_blur_m < best_m_;
    }

    void halve_or_settle(Node node) {
        const double known_m2 = regions_[node.region].box.area_m2();
        if (sheets_.evaluations > known_bounds_do &&
            node.box.area_m2() < worth_new_bounds * known_m2 && known_m2 > finest_m2_) {
            node.box = node.box.within(field_.left_of(node.box, search_.target));
            if (node.box.empty())
                return;
            node.region = add_region(node.box);
        }
        if (settled(node))
            return;
        const Box& box = node.box;
        const Vec2 m = box.middle();
        Node low = node, high = node;
        if (box.high.x - box.low.x > box.high.y - box.low.y)
            low.box.high.x = high.box.low.x = m.x;
        else
            low.box.high.y = high.box.low.y = m.y;
        for (const Node& half : {low, high}) {
            open_.push_back(half);
            std::push_heap(open_.begin(), open_.end());
        }
    }

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

    /// No place within the radius is higher than this.
    double upper_m(Region& region, Vec2 middle, double radius_m) const {
        if (region.rises.empty())
            region.rises = field_.rises(region.box);
        double upper = field_.height(middle);
        for (const Rise& r : region.rises)
            upper += std::min(r.slope * radius_m, r.range_m);
        return upper;
    }

    /// Nothing more to be learnt from this box. If there is, its upper bound is renewed.
    bool settled(Node& node) {
        Region& region = regions_[node.region];
        const Box& box = node.box;
        const Vec2 middle = box.middle();
        const double half_x = box.high.x - middle.x, half_y = box.high.y - middle.y;
        const double radius_m = std::sqrt(half_x * half_x + half_y * half_y);
        const Local here = evaluate(middle);
        const Singular s(here);
        double bent = 0, shifted_m = 0; // of the gradient, and beyond what it says
        for (const Roughness& r : region.parts) {
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
        if (sheets_.folded) {
            node.upper_m = std::min(node.upper_m, upper_m(region, middle, radius_m));
            if (too_low(node.upper_m))
                return true;
        }
        if (bent < kantorovich * s.value[0] && bent + search_.strain_blur < s.value[0]) {
            add_solution(middle, here, radius_m, region);
            return true;
        }
        if (radius_m > region.smallest_m)
            return false;
        doubtful_m_ = std::max(doubtful_m_, upper_m(region, middle, radius_m));
        add_edge(middle, region.smallest_m);
        return true;
    }

    /// The map is one to one here.
    void add_solution(Vec2 start, Local local, double radius_m, const Region& region) {
        const bool turned = local.determinant() < 0;
        const std::optional<Vec2> at = newton(start, local, 4 * radius_m);
        if (!at)
            return;
        sheets_.folded |= turned;
        const double height_m = field_.height(*at);
        best_m_ = std::max(best_m_, height_m);
        if (!stays(*at, Singular(local).value[0] - search_.strain_blur, region))
            doubtful_m_ = std::max(doubtful_m_, height_m);
        const bool known =
            std::any_of(sheets_.found.begin(), sheets_.found.end(), [&](const Vec2& other) {
                return std::hypot(other.x - at->x, other.y - at->y) <
                       apart_tolerances * search_.solved_m;
            });
        if (!known)
            sheets_.found.push_back(*at);
    }

    /// The sea has a sheet that the field has, where the blur is less than what the gradient leaves of it
    /// over some radius (Kantorovich again): its smallest singular value is `steep` at the solution.
    bool stays(Vec2 at, double steep, const Region& region) const {
        const auto holds = [&](double bend_per_m) {
            return steep * steep > 4 * bend_per_m * search_.blur_m;
        };
        if (!(steep > 0))
            return false;
        if (holds(region.bend_per_m))
            return true;
        const double radius_m = 2 * search_.blur_m / steep;
        return holds(bend_of(field_.roughness(Box::around(at, radius_m, radius_m))));
    }

    double bend_of(const RecycledVector<Roughness>& parts) const {
        double bend_per_m = 0;
        for (const Roughness& r : parts)
            bend_per_m += sideways_ * r.bend_per_m;
        return bend_per_m;
    }

    /// Leaves in `local` what there is at the solution.
    std::optional<Vec2> newton(Vec2 at, Local& local, double leash_m) {
        const Vec2 start = at;
        for (int step = 0; step < sheet_steps_max; ++step) {
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

    /// Too small to tell: near the edge of a fold. Where two sheets meet, they lie on either side of the
    /// edge, along the direction that the gradient nearly puts to nothing.
    void add_edge(Vec2 near, double smallest_m) {
        sheets_.folded = true;
        const double apart_m = 4 * smallest_m;
        if (edges_.size() >= edges_max || !add_once(near_edges_, near, apart_m))
            return;
        const Edge edge = edge_at(near, smallest_m);
        if (!add_once(edges_, edge.at, apart_m))
            return;
        for (const double side_m : {-apart_m, apart_m})
            sheets_.found.push_back(
                {edge.at.x + side_m * edge.across.x, edge.at.y + side_m * edge.across.y});
    }

    /// False: there is one nearer than that.
    static bool add_once(RecycledVector<Vec2>& places, Vec2 place, double apart_m) {
        for (const Vec2& other : places)
            if (std::hypot(other.x - place.x, other.y - place.y) < apart_m)
                return false;
        places.push_back(place);
        return true;
    }

    struct Edge {
        Vec2 at;
        Vec2 across;
    };
    /// Newton to J = 0 across the edge, and to no residual in the other direction. Where several
    /// sheets lie within the blur, boxes near an edge may all lie on one side of it.
    Edge edge_at(Vec2 at, double smallest_m) {
        constexpr int steps = 4;
        Vec2 across;
        for (int step = 0; step < steps; ++step) {
            const Local here = evaluate(at);
            const Singular s(here);
            across = s.v[0];
            const Local beside =
                evaluate({at.x + smallest_m * across.x, at.y + smallest_m * across.y});
            const double leash_m = 8 * smallest_m;
            const auto held = [&](double way_m) {
                return std::isfinite(way_m) ? std::clamp(way_m, -leash_m, leash_m) : 0.0;
            };
            const double to_edge_m = held(-here.determinant() * smallest_m /
                                          (beside.determinant() - here.determinant()));
            const double along_m =
                held(-(s.u[1].x * here.residual.x + s.u[1].y * here.residual.y) / s.value[1]);
            at.x += to_edge_m * across.x + along_m * s.v[1].x;
            at.y += to_edge_m * across.y + along_m * s.v[1].y;
        }
        return {at, across};
    }

    const SheetSearch& search_;
    const SheetField& field_;
    const double sideways_;
    const double finest_m2_;
    RecycledVector<Region> regions_;
    RecycledVector<Node> open_; ///< a heap, highest first
    double best_m_ = -unbounded;
    double doubtful_m_ = -unbounded; ///< the highest that a sheet may be which the blur leaves open
    RecycledVector<Vec2> near_edges_, edges_;
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
