// SPDX-License-Identifier: Apache-2.0
// Where the exact sum may have other sheets. A value of it costs 10 us, so the search works on
// patches of its displacement (DirectSum::Moment::patch), and Newton solves the exact sum from every
// sheet that they show.
//
// How far a cascade moves points at most is taken as six times its rms over the tile: statistical, one
// point in 1e8 of a Gaussian sea. Searched are points where Newton met J < fold_suspected_below or did
// not converge, and all of seas that fold more often than above one place of 2e7 (FoldSearch::always,
// folded_share()).
//
// Of waves that were rounded (InverseOptions::blur) Newton solves a sum that is off itself: where that leaves another sheet open
// it stays so. Where rounding alone may squeeze as much as makes Newton suspect a fold, every point is searched.
//
// For one point; not thread-safe. Cost: 0.2 to 5 ms where it searches, nothing elsewhere.
#pragma once

#include <algorithm>

#include "sea/surface/patch_sheets.h"

namespace seaway::sea {

class MomentSheets final : public PatchSheets {
  public:
    MomentSheets(const DirectSum::Moment& moment, const InverseOptions& options)
        : PatchSheets(options.choppiness), moment_(moment), options_(options) {}

    std::optional<Box> others(Vec2 target, const Vec2* root, bool suspected) override;
    double blur_m() const override { return blur_m_; }
    double strain_blur() const override {
        return options_.choppiness.largest() * options_.blur.strain;
    }
    double height_blur_m() const override { return height_blur_m_; }
    bool newton_decides() const override { return !(options_.blur.strain > 0); }

  private:
    SheetPatch patch(std::size_t cascade, const Box& box) const override;

    const DirectSum::Moment& moment_;
    const InverseOptions options_;
    double blur_m_ = 0;
    double height_blur_m_ = 0;
};

} // namespace seaway::sea
