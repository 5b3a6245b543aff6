// SPDX-License-Identifier: Apache-2.0
// Sheets of a sea that is given cascade by cascade as patches of splines around a place: what the exact
// sum (moment_sheets.h) and sampled maps (surface_sheets.h) have in common.
//
// Solutions lie at X = x - lambda D(X). The longest cascade's patch covers all that points may move;
// what its D takes on there leaves a smaller box for the next one, and so on to the finest. Where the
// strains of all patches over the last box keep X + lambda D(X) one to one, there is one sheet; else
// find_sheets() goes on with the patches.
//
// For one point; not thread-safe. Memory is kept for the next search of the thread (base/recycled.h).
#pragma once

#include <optional>
#include <span>

#include "sea/surface/inverse.h"
#include "sea/waves/sheet_patch.h"

namespace seaway::sea {

class PatchSheets : public SheetBounds {
  public:
    explicit PatchSheets(const Choppiness& choppiness) : choppiness_(choppiness) {}

    LagrangianPoint displaced(Vec2 at) const override;
    double height(Vec2 at) const override;
    RecycledVector<Roughness> roughness(const Box& box) const override;
    RecycledVector<Rise> rises(const Box& box) const override;
    Box left_of(const Box& box, Vec2 target) const override {
        return left_of(box, target, blur_m());
    }
    double spacing_m() const override;

  protected:
    /// The part of a cascade whose splines reach into the box, and a line more on each side.
    virtual SheetPatch patch(std::size_t cascade, const Box& box) const = 0;

    /// Makes the patches; `reach_m`: how far each cascade moves points at most. Returns what is left
    /// of the box: nothing where all of it is one to one and `solved` says that a solution is known.
    std::optional<Box> narrowed(Box box, Vec2 target, std::span<const double> reach_m, bool solved);

  private:
    Box left_of(const Box& box, Vec2 target, double rest_m) const;
    bool one_to_one(const Box& box) const;

    Choppiness choppiness_;
    RecycledVector<SheetPatch> patches_;
};

} // namespace seaway::sea
