// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/moment_sheets.h"

#include <algorithm>

namespace seaway::sea {

std::optional<Box> MomentSheets::others(Vec2 target, const Vec2* root, bool suspected) {
    const bool any_place = options_.folds.always || strain_blur() >= fold_suspected_below;
    if (root != nullptr && !suspected && !any_place)
        return std::nullopt;
    const double sideways = options_.choppiness.largest();
    RecycledVector<double> reach_m;
    double all_m = 0;
    blur_m_ = options_.tolerance_m + sideways * options_.blur.displacement_m;
    height_blur_m_ = options_.tolerance_m + options_.blur.height_m;
    for (std::size_t c = 0; c < moment_.sea().cascades.size(); ++c) {
        const DirectSum::Moment::PatchScale scale = moment_.patch_scale(static_cast<int>(c));
        reach_m.push_back(sideways * scale.displacement_m);
        all_m += reach_m.back();
        blur_m_ += sideways * scale.missed_m;
        height_blur_m_ += scale.missed_height_m;
        for (const SineField& sines : moment_.sea().cascades[c].sines)
            height_blur_m_ += 2 * sine_height_max_m(sines); // patches are of modes alone
    }
    all_m += blur_m_;
    return narrowed(Box::around(target, all_m, all_m), target, reach_m, root != nullptr);
}

SheetPatch MomentSheets::patch(std::size_t cascade, const Box& box) const {
    return moment_.patch(static_cast<int>(cascade), box.low.x, box.high.x, box.low.y, box.high.y);
}

} // namespace seaway::sea
