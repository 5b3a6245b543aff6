// SPDX-License-Identifier: Apache-2.0
// Where a sampled surface may have other sheets: from the windows of its maps (strain_windows.h).
//
// Another solution X' beside X obeys X' - X = -lambda (D(X') - D(X)). Cascades whose strain stays
// gentle around X bring the two together, the others part them by no more than their displacements
// range: |X' - X| <= ranges of the others / smallest eigenvalue of I + lambda grad D of the gentle
// ones. That radius shrinks when it is worked out again within itself; where all cascades are gentle in
// it, there is one sheet. The smallest eigenvalue of a sum is no less than the sum of the smallest ones. Proved for the
// maps; what they miss of the sea comes in as the blur.
//
// For one time; one place after another; not thread-safe but where it is const. Some 20 ns, nothing allocated, where
// there is one sheet.
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

    /// Of a place on the grid of each pair.
    using Cells = std::array<StrainWindows::Cell, surface_pairs_max>;
    Cells cells(Vec2 place) const;

    /// There is no other sheet beside a solution in these cells: others() would be nothing.
    bool alone(const Cells& cells) const { return !(radius_around(cells) > 0); }
    /// The same, asked of patches as well where windows leave it open: 5 us, nothing kept.
    bool single(Vec2 target, Vec2 root, const Cells& cells) const;
    /// What alone() looks at first is fetched from now on.
    void fetch(const Cells& cells) const;
    /// Of each pair at this time.
    const HermiteWeights& weights(std::size_t cascade) const { return weights_[cascade]; }

    std::optional<Box> others(Vec2 target, const Vec2* root, bool suspected) override;
    double blur_m() const override { return blur_m_; }
    double strain_blur() const override { return strain_blur_; }
    double height_blur_m() const override { return height_blur_m_; }

  private:
    typedef float F4 __attribute__((vector_size(16)));

    /// What one cascade does at most within a window at this time.
    struct Gentleness {
        double range_m; ///< lambda |D(a) - D(b)|
        double
            stretch; ///< what it adds to the smallest eigenvalue of I + lambda grad D, below 0 where it squeezes
    };
    /// Of the bounds before and after: carried on, carried back, and rates beside them.
    struct BoundWeights {
        F4 before;
        F4 after;
    };
    Gentleness mixed(std::size_t cascade, const StrainBounds& before,
                     const StrainBounds& after) const;
    /// The radius in which others may lie, less than `radius_m` where `of` says of each cascade what it does within that;
    /// 0: there are none.
    template <class Of>
    double less_than(double radius_m, Of of) const;
    /// How far from a solution in these cells others may lie; 0: there is none.
    double radius_around(const Cells& cells) const;
    SheetPatch patch(std::size_t cascade, const Box& box) const override;

    const Surface& surface_;
    std::array<HermiteWeights, surface_pairs_max> weights_; ///< one a pair
    std::array<BoundWeights, surface_pairs_max> bound_weights_;
    std::array<double, surface_pairs_max> reach_m_; ///< of each pair, anywhere
    double reach_all_m_;                            ///< how far apart sheets are at most, anywhere
    double more_sideways_;                          ///< the larger choppiness
    double less_sideways_;                          ///< the smaller one
    double blur_m_;
    double strain_blur_;
    double height_blur_m_;
};

} // namespace seaway::sea
