// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/foam_maps.h"

namespace seaway::server {

FoamMaps::FoamMaps(const RunningSea& sea) {
    if (!sea.foam_law)
        return;
    for (std::size_t c = 0; c < sea.realization->cascades.size(); ++c)
        histories_.emplace_back(sea.foam_law, static_cast<int>(c),
                                sea.realization->cascades[c].spec.size,
                                sea.budget.cascades[c].interval_us);
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

Result<void> FoamMaps::fill(const NewKeyframePtr& keyframe,
                            const sea::FoamHistory::StrainsAt& strains_at) {
    sea::FoamHistory& foam = history(keyframe->cascade);
    const auto strains = [&](sea::TimeUs time_us) -> Result<sea::KeyframePtr> {
        return time_us == keyframe->time_us ? Result<sea::KeyframePtr>(keyframe)
                                            : strains_at(time_us);
    };
    SEAWAY_TRY(foam.advance_to(keyframe->time_us, strains));
    foam.fill(keyframe->plane(sea::Field::foam));
    return {};
}

} // namespace seaway::server
