// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/inverse.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sea/basics/constants.h"
#include "sea/surface/moment_sheets.h"
#include "sea/surface/steepness.h"

namespace seaway::sea {

namespace {

constexpr int newton_steps_max = 12;
constexpr int halvings_max = 10;

struct Sheet {
    Vec2 lagrangian;
    LagrangianPoint point;
    Vec2 residual;
    double residual_m;
};

class Solver {
  public:
    Solver(Vec2 target, const InverseOptions& options, const LagrangianField& field)
        : target_(target), options_(options), field_(field) {}

    Sheet evaluate(Vec2 lagrangian) {
        const LagrangianPoint point = field_(lagrangian.x, lagrangian.y);
        const Vec2 residual{lagrangian.x + options_.choppiness.x * point.displacement_x - target_.x,
                            lagrangian.y + options_.choppiness.y * point.displacement_y -
                                target_.y};
        jacobian_min_ = std::min(jacobian_min_, jacobian(point, options_.choppiness));
        return {lagrangian, point, residual, std::hypot(residual.x, residual.y)};
    }

    /// Damped Newton; ends at the tolerance or at the best point it could reach.
    Sheet solve(Vec2 start, double tolerance_m) {
        Sheet sheet = evaluate(start);
        for (int step = 0; step < newton_steps_max && sheet.residual_m > tolerance_m; ++step) {
            const Vec2 delta = newton_step(sheet);
            Sheet next = sheet;
            double length = 1.0;
            for (int halving = 0; halving <= halvings_max; ++halving, length *= 0.5) {
                next = evaluate(
                    {sheet.lagrangian.x + length * delta.x, sheet.lagrangian.y + length * delta.y});
                if (next.residual_m < sheet.residual_m)
                    break;
            }
            if (!(next.residual_m < sheet.residual_m))
                break;
            sheet = next;
        }
        return sheet;
    }

    double jacobian_min() const { return jacobian_min_; }

  private:
    /// -(I + lambda grad D)^-1 residual, which leads downhill however close to singular the matrix is;
    /// where it is, the plain fixed-point step. Never longer than the reach (D4).
    Vec2 newton_step(const Sheet& sheet) const {
        const double a = 1.0 + options_.choppiness.x * sheet.point.strain_xx;
        const double b = options_.choppiness.x * sheet.point.strain_xy;
        const double c = options_.choppiness.y * sheet.point.strain_xy;
        const double d = 1.0 + options_.choppiness.y * sheet.point.strain_yy;
        const double det = a * d - b * c;
        Vec2 step{-sheet.residual.x, -sheet.residual.y};
        if (std::abs(det) > 1e-9)
            step = {-(d * sheet.residual.x - b * sheet.residual.y) / det,
                    -(a * sheet.residual.y - c * sheet.residual.x) / det};
        const double length = std::hypot(step.x, step.y);
        const double limit = std::max(options_.folds.reach_m, sheet.residual_m);
        if (length > limit)
            step = {step.x * limit / length, step.y * limit / length};
        return step;
    }

    Vec2 target_;
    const InverseOptions& options_;
    const LagrangianField& field_;
    double jacobian_min_ = std::numeric_limits<double>::infinity();
};

/// Sheets that solve the equation this far apart are two.
constexpr double sheets_apart_m = 1e-3;

/// The search works in single precision; Newton goes on from what it finds.
constexpr double start_tolerance_m = 1e-4;
/// Beside the edge of a fold a residual of 0.1 mm is a centimetre along the surface, and would make a
/// sheet the highest that is not.
constexpr double compared_tolerance_m = 3e-6;

double slope_of(const LagrangianPoint& p, const Choppiness& l) {
    const Normal<double> normal = normal_of(gradients_of(p), l);
    return slope_of(Normal<double>{normal.x, normal.y, std::abs(normal.z)});
}

struct Highest {
    Sheet sheet;
    std::uint32_t flags = 0;
    double error_m =
        0; ///< beyond that of the sheet: a steeper one may rise above it within the blur
};

/// Of all sheets that `sheets` leaves room for, the highest one that solves the equation, or `found`
/// if none does.
Highest highest_sheet(Solver& solver, const Sheet& found, Vec2 target,
                      const InverseOptions& options, SheetBounds& sheets) {
    const bool solved = found.residual_m <= options.tolerance_m;
    const std::optional<Box> box = sheets.others(target, solved ? &found.lagrangian : nullptr,
                                                 solver.jacobian_min() < fold_suspected_below);
    if (!box)
        return {found};
    SheetSearch search{options.choppiness,
                       target,
                       *box,
                       sheets.blur_m(),
                       sheets.strain_blur(),
                       sheets.height_blur_m(),
                       std::max(options.tolerance_m, start_tolerance_m)};
    if (solved)
        search.known = found.lagrangian;
    const Sheets others = find_sheets(search, sheets);
    bool folded = others.folded;
    const double tolerance_m = std::min(options.tolerance_m, compared_tolerance_m);
    Sheet best =
        found.residual_m > tolerance_m ? solver.solve(found.lagrangian, tolerance_m) : found;
    // Where a sheet stays over the blur, its gradient falls to half at most: so steep it may become.
    const auto reaches_m = [&](const Sheet& sheet) {
        return sheet.point.height + 2 * slope_of(sheet.point, options.choppiness) * sheets.blur_m();
    };
    double reached_m = reaches_m(best);
    for (const Vec2& start : others.found) {
        const Sheet sheet = solver.solve(start, tolerance_m);
        if (sheet.residual_m > options.tolerance_m)
            continue;
        const bool best_solves = best.residual_m <= options.tolerance_m;
        const double distance_m = std::hypot(sheet.lagrangian.x - best.lagrangian.x,
                                             sheet.lagrangian.y - best.lagrangian.y);
        folded |= best_solves && distance_m > sheets_apart_m;
        reached_m = std::max(reached_m, reaches_m(sheet));
        if (!best_solves || sheet.point.height > best.point.height)
            best = sheet;
    }
    if (!folded)
        return {best};
    const bool open = others.ended_early || (others.open && !sheets.newton_decides());
    return {best, answer_folded | (open ? answer_open : 0u),
            sheets.newton_decides() ? 0.0 : reached_m - best.point.height};
}

} // namespace

Answer invalid_answer() {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    return {nan, {nan, nan, nan}, {nan, nan, nan}, nan, answer_invalid};
}

FoldSearch fold_search(double reach_m, const Choppiness& choppiness, double rms_strain) {
    constexpr double reach_min_m = 1e-3;
    const double squeeze = choppiness.largest() * rms_strain;
    return {std::max(reach_m, reach_min_m), squeeze > folds_searched_above};
}

double exact_tolerance_m(const QueryPoint& point) {
    constexpr double last_digits = 32 * 0.5 * std::numeric_limits<double>::epsilon();
    return 1e-9 + last_digits * std::max(std::abs(point.x_m), std::abs(point.y_m));
}

double folded_share(double squeeze) {
    if (!(squeeze > 0))
        return 0;
    const double z = 1.0 / squeeze;
    const double density = std::exp(-0.5 * z * z) / std::sqrt(two_pi);
    return squeeze * density - 0.5 * std::erfc(z / std::numbers::sqrt2);
}

double jacobian(const LagrangianPoint& point, const Choppiness& choppiness) {
    return jacobian(gradients_of(point), choppiness);
}

Answer answer_of(const LagrangianPoint& p, const Choppiness& choppiness) {
    const Normal<double> normal = upright(normal_of(gradients_of(p), choppiness));
    Answer answer;
    answer.height_m = p.height;
    answer.normal[0] = normal.x;
    answer.normal[1] = normal.y;
    answer.normal[2] = normal.z;
    answer.velocity_mps[0] = p.displacement_x_rate; // the water's: choppiness is the picture's
    answer.velocity_mps[1] = p.displacement_y_rate;
    answer.velocity_mps[2] = p.height_rate;
    return answer;
}

double surface_slope(const Answer& answer) {
    constexpr double steepest = 1e9; // upright
    const Normal<double> n{answer.normal[0], answer.normal[1], answer.normal[2]};
    return answer.flags & answer_folded ? slope_of(n) : std::min(gentle_slope(n), steepest);
}

Answer surface_at(const QueryPoint& point, const InverseOptions& options, LagrangianField field,
                  SheetBounds* sheets, Vec2* lagrangian, double* area) {
    if (!std::isfinite(point.x_m) || !std::isfinite(point.y_m))
        return invalid_answer();
    Solver solver({point.x_m, point.y_m}, options, field);
    Highest highest{solver.solve({point.x_m, point.y_m}, options.tolerance_m)};
    if (sheets != nullptr)
        highest = highest_sheet(solver, highest.sheet, {point.x_m, point.y_m}, options, *sheets);
    else if (solver.jacobian_min() < fold_suspected_below)
        highest.flags = answer_folded | answer_open;
    if (lagrangian != nullptr)
        *lagrangian = highest.sheet.lagrangian;

    const LagrangianPoint& p = highest.sheet.point;
    const double found_area = jacobian(p, options.choppiness);
    if (area != nullptr)
        *area = found_area;
    Answer answer = answer_of(p, options.choppiness);
    answer.flags = highest.flags;
    // Turned sheets are never alone.
    if (found_area <= 0 && !(answer.flags & answer_folded))
        answer.flags |= answer_folded | answer_open;
    if (highest.sheet.residual_m > options.tolerance_m)
        answer.flags |= answer_not_converged;
    const double residual_m = highest.sheet.residual_m;
    answer.error_m =
        residual_m * surface_slope(answer) +
        bent_m(options.curvature_per_m, residual_m, std::max(found_area, fold_suspected_below)) +
        highest.error_m;
    return answer;
}

Answer surface_at(const QueryPoint& point, const InverseOptions& options,
                  const DirectSum::Moment& moment, Vec2* lagrangian, double* area) {
    MomentSheets sheets(moment, options);
    Answer answer = surface_at(point, options, LagrangianField(moment), &sheets, lagrangian, area);
    if (!moment.moves_sideways() && !(answer.flags & answer_invalid))
        answer.flags |= answer_vertical_velocity;
    return answer;
}

} // namespace seaway::sea
