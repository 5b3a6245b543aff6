// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/foam_maps.h"

namespace seaway::server {

FoamMaps::FoamMaps(const SeaCoursePtr& course) {
    const RunningSea& sea = *course->first();
    if (!sea.foam_law)
        return;
    for (std::size_t c = 0; c < sea.realization->cascades.size(); ++c) {
        histories_.emplace_back(sea.foam_law, static_cast<int>(c),
                                sea.realization->cascades[c].spec.size,
                                sea.budget.cascades[c].interval_us);
        histories_.back().follow(
            [course](sea::TimeUs time_us) { return course->at(time_us)->foam_law_at(time_us); });
    }
}

sea::FoamHistory& FoamMaps::history(int cascade) {
    SEAWAY_CHECK(!histories_.empty(), "foam is offered only where the scene has a law for it");
    return histories_[static_cast<std::size_t>(cascade)];
}

int FoamMaps::ticks_to(int cascade, sea::TimeUs time_us) const {
    return histories_[static_cast<std::size_t>(cascade)].ticks_to(time_us);
}

Result<bool> FoamMaps::walk_towards(int cascade, sea::TimeUs time_us, int ticks_max,
                                    const sea::FoamHistory::StrainsAt& strains_at) {
    return history(cascade).walk_towards(time_us, ticks_max, strains_at);
}

Result<void> FoamMaps::fill(const NewKeyframePtr& keyframe, sea::TimeUs time_us,
                            const sea::FoamHistory::StrainsAt& strains_at) {
    sea::FoamHistory& foam = history(keyframe->cascade);
    SEAWAY_TRY(foam.advance_to(time_us, strains_at));
    foam.fill(keyframe->plane(sea::Field::foam));
    return {};
}

} // namespace seaway::server
