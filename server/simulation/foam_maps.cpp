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

Result<void> FoamMaps::fill(const NewKeyframePtr& keyframe,
                            const sea::FoamHistory::StrainsAt& strains_at) {
    SEAWAY_CHECK(!histories_.empty(), "foam is offered only where the scene has a law for it");
    sea::FoamHistory& history = histories_[static_cast<std::size_t>(keyframe->cascade)];
    const auto strains = [&](sea::TimeUs time_us) -> Result<sea::KeyframePtr> {
        return time_us == keyframe->time_us ? Result<sea::KeyframePtr>(keyframe)
                                            : strains_at(time_us);
    };
    SEAWAY_TRY(history.advance_to(keyframe->time_us, strains));
    history.fill(keyframe->plane(sea::Field::foam));
    return {};
}

} // namespace seaway::server
