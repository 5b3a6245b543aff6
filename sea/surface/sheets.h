// SPDX-License-Identifier: Apache-2.0
// The sheets of a folded surface above a world point: X in a box with X + lambda D(X) = x.
//
// The box is halved again and again. With the singular values s1 <= s2 of I + lambda grad D at the
// middle of a box, and bounds on how D and its gradient change over it (Roughness), a box is put away
// where no X in it can solve the equation; where s1 exceeds what the gradient can change by, the map is
// one to one in the box and Newton finds its one solution or shows that there is none (Kantorovich).
// What is left when boxes are small lies at the edge of a fold.
//
// Sheets come in pairs, one of them turned over (J < 0): the solutions counted with the sign of J add
// up to one. So a point is folded where, and only where, a turned sheet comes down upon it. Once that
// is known, the highest sheet is all that is still asked for: boxes are taken highest first, and what
// cannot reach as high as the best solution is left.
//
// Thread-safe. Memory is kept for the next search of the thread (base/recycled.h). Cost: 20 to 200 evaluations, sheet_evaluations_max at most.
#pragma once

#include <optional>

#include "base/recycled.h"
#include "sea/basics/lagrangian_point.h"
#include "sea/surface/maps/roughness.h"
#include "sea/waves/realization.h"

namespace seaway::sea {

struct Vec2 {
    double x = 0;
    double y = 0;
};

/// A box of undisplaced coordinates, m.
struct Box {
    Vec2 low;
    Vec2 high;
    Vec2 middle() const { return {0.5 * (low.x + high.x), 0.5 * (low.y + high.y)}; }
    double area_m2() const { return (high.x - low.x) * (high.y - low.y); }
    bool empty() const { return !(low.x <= high.x && low.y <= high.y); }
    Box within(const Box& other) const;
    static Box around(Vec2 middle, double half_x_m, double half_y_m);
};

/// A field that knows its own roughness: what the search works on.
class SheetField {
  public:
    virtual ~SheetField() = default;
    /// Displacements and strains; the rest need not be set. Anywhere near the box.
    virtual LagrangianPoint displaced(Vec2 at) const = 0;
    virtual double height(Vec2 at) const = 0;
    /// How much each part varies over the box, one a cascade, at choppiness 1.
    virtual RecycledVector<Roughness> roughness(const Box& box) const = 0;
    virtual RecycledVector<Rise> rises(const Box& box) const = 0;
    /// What is left of the box for solutions by how far points in it are moved.
    virtual Box left_of(const Box& box, Vec2 target) const = 0;
    /// Smaller boxes have bounds that are no tighter.
    virtual double spacing_m() const = 0;
};

struct SheetSearch {
    Choppiness choppiness;
    Vec2 target;              ///< x
    Box box;                  ///< where X is looked for
    double blur_m = 1e-6;     ///< the field may be wrong by this: so near a fold counts as folded
    double strain_blur = 0;   ///< and its lambda grad D by this
    double height_blur_m = 0; ///< and its heights by this
    double solved_m = 1e-6;   ///< residual that counts as solved
    std::optional<Vec2> known{}; ///< a solution
};

struct Sheets {
    /// Solutions, and places on both sides of the edge of a fold. Those that are lower than the highest
    /// may be missing.
    RecycledVector<Vec2> found;
    bool folded = false; ///< there is a turned sheet, or there may be one within the blur
    /// A sheet as high as the highest may begin or end within the blur: which one is the highest is left
    /// open.
    bool open = false;
    bool ended_early = false; ///< at sheet_evaluations_max
    int evaluations = 0;
};

/// Beyond these a search ends with what it has found, and the point counts as folded.
inline constexpr int sheet_evaluations_max = 20'000;

Sheets find_sheets(const SheetSearch& search, const SheetField& field);

} // namespace seaway::sea
