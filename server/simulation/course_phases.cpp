// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/course_phases.h"

#include <iterator>
#include <limits>
#include <utility>

#include "sea/waves/transition.h"

namespace seaway::server {

Result<sea::RealizationPtr> own_clocks(const sea::Scene& scene) {
    SEAWAY_TRY_LET(sea::Realization clocks, sea::realize_clocks(scene));
    return std::make_shared<const sea::Realization>(std::move(clocks));
}

sea::RealizationPtr CoursePhases::of(std::size_t change) const {
    const std::scoped_lock lock(mutex_);
    const auto found = kept_.find(change);
    return found == kept_.end() ? nullptr : found->second;
}

Result<sea::RealizationPtr> CoursePhases::before(sea::RealizationPtr clocks,
                                                 std::span<const PhaseStep> steps) {
    for (std::size_t i = 0; i + 1 < steps.size(); ++i) {
        const PhaseStep &step = steps[i], &next = steps[i + 1];
        SEAWAY_TRY_LET(const sea::RealizationPtr to, own_clocks(*step.scene));
        SEAWAY_TRY_LET(const sea::SeaTransition change,
                       sea::SeaTransition::create(clocks, to, step.start_us, step.end_us));
        keep(step.change, change.after());
        clocks = next.takes_over ? change.gliding(next.start_us) : change.after();
    }
    return clocks;
}

void CoursePhases::keep(std::size_t change, sea::RealizationPtr clocks) {
    const std::scoped_lock lock(mutex_);
    kept_.emplace(change, std::move(clocks));
    if (kept_.size() <= phases_kept)
        return;
    // The newest stays, for the next change follows it; of the others goes the one that leaves the narrowest gap.
    auto gone = kept_.begin();
    std::size_t narrowest = std::numeric_limits<std::size_t>::max();
    std::size_t before = 0;
    for (auto it = kept_.begin(); std::next(it) != kept_.end(); ++it) {
        const std::size_t gap = std::next(it)->first - std::exchange(before, it->first);
        if (gap < narrowest) {
            narrowest = gap;
            gone = it;
        }
    }
    kept_.erase(gone);
}

} // namespace seaway::server
