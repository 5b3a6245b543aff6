// SPDX-License-Identifier: Apache-2.0
// Where a sampled surface may have other sheets: from the windows of its maps (strain_windows.h).
//
// Another solution X' beside X obeys X' - X = -lambda (D(X') - D(X)). Cascades whose strain stays
// gentle around X bring the two together, the others part them by no more than their displacements
// range: |X' - X| <= ranges of the others / smallest eigenvalue of I + lambda grad D of the gentle
// ones. That radius shrinks when it is worked out again within itself; where all cascades are gentle in
// it, there is one sheet. Proved for the maps; what they miss of the sea comes in as the blur.
//
// For one point and time; not thread-safe. About 0.1 us, nothing allocated, where there is one sheet.
#pragma once

#include <array>
#include <optional>

#include "sea/surface/maps/hermite.h"
#include "sea/surface/patch_sheets.h"
#include "sea/surface/surface.h"

namespace seaway::sea {

class SurfaceSheets final : public PatchSheets {
  public:
    SurfaceSheets(const Surface& surface, TimeUs time_us);

    /// There is no other sheet beside this solution: others() would be nothing.
    bool alone(Vec2 root) const { return !(radius_around(root, reach_all_m_) > 0); }
    /// The same, asked of patches as well where windows leave it open: 5 us, nothing kept.
    bool single(Vec2 target, Vec2 root) const;
    /// What alone() looks at is fetched from now on.
    void fetch(Vec2 root) const;
    /// Of each pair at this time.
    const HermiteWeights& weights(std::size_t cascade) const { return weights_[cascade]; }

    std::optional<Box> others(Vec2 target, const Vec2* root, bool suspected) override;
    double blur_m() const override { return blur_m_; }
    double strain_blur() const override { return strain_blur_; }
    double height_blur_m() const override { return height_blur_m_; }

  private:
    /// What one cascade does at most within a window at this time.
    struct Gentleness {
        double range_m; ///< lambda |D(a) - D(b)|
        double xx_min;
        double yy_min;
        double xy_size;
    };
    Gentleness mixed(std::size_t cascade, const StrainBounds& before,
                     const StrainBounds& after) const;
    /// How far from a solution others may lie; 0: there is none.
    double radius_around(Vec2 root, double radius_m) const;
    SheetPatch patch(std::size_t cascade, const Box& box) const override;

    const Surface& surface_;
    std::array<HermiteWeights, surface_pairs_max> weights_; ///< one a pair
    std::array<double, surface_pairs_max> reach_m_;         ///< of each pair, anywhere
    double reach_all_m_;                                    ///< of all together, and the blur
    double sideways_;
    double blur_m_;
    double strain_blur_;
    double height_blur_m_;
};

} // namespace seaway::sea
