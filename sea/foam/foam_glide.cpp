// SPDX-License-Identifier: Apache-2.0
#include "sea/foam/foam_glide.h"

#include <algorithm>

namespace seaway::sea {

FoamLawPtr FoamGlide::at(TimeUs time_us) const {
    const double share = glide_share(time_us, change_.start_us(), change_.end_us());
    if (share >= 1.0)
        return to_;
    if (share <= 0.0 || calm())
        return from_;
    const int step = std::min(static_cast<int>(share * steps), steps - 1);
    const std::scoped_lock lock(mutex_);
    FoamLawPtr& law = laws_[static_cast<std::size_t>(step)];
    if (!law) {
        const double middle = (step + 0.5) / steps;
        FoamModel model = to_->model;
        model.gain_per_s = glided(from_->model.gain_per_s, to_->model.gain_per_s, middle);
        model.bias = glided(from_->model.bias, to_->model.bias, middle);
        model.threshold = glided(first_threshold(), last_threshold(), middle);
        law = make_foam_law(*change_.with_share(middle), model);
    }
    return law;
}

} // namespace seaway::sea
