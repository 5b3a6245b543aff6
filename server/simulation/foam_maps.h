// SPDX-License-Identifier: Apache-2.0
// Foam maps: the histories of a sea's cascades, and keyframes with a foam map from them. A history
// that starts, or jumps in time, walks through hundreds of ticks: that is done in slices.
// For one thread.
#pragma once

#include <vector>

#include "base/result.h"
#include "sea/foam/foam.h"
#include "server/device/synthesizer.h"
#include "server/simulation/sea_course.h"

namespace seaway::server {

/// Fields with those that foam stands on, where foam is among them.
inline sea::FieldSet with_foam_inputs(sea::FieldSet fields) {
    return fields.contains(sea::Field::foam) ? fields | sea::foam_inputs : fields;
}

inline sea::FieldSet without_foam(sea::FieldSet fields) {
    return sea::FieldSet::from_bits(fields.bits() & ~sea::FieldSet{sea::Field::foam}.bits());
}

class FoamMaps {
  public:
    /// Without a foam law (RunningSea::foam_law) there is nothing to add. Histories tick by the first sea of the course
    /// and go on over its changes.
    explicit FoamMaps(const SeaCoursePtr& course);

    /// Ticks that are left before fill() of a cascade at a time.
    int ticks_to(int cascade, sea::TimeUs time_us) const;

    /// At most `ticks_max` >= 1 of them; true: none is left. `strains_at` gives the same cascade at
    /// earlier times.
    Result<bool> walk_towards(int cascade, sea::TimeUs time_us, int ticks_max,
                              const sea::FoamHistory::StrainsAt& strains_at);

    /// Fills Field::foam of a keyframe that holds it with the foam of a time, mostly its own, and walks what is left.
    Result<void> fill(const NewKeyframePtr& keyframe, sea::TimeUs time_us,
                      const sea::FoamHistory::StrainsAt& strains_at);

    /// The same of its own time, of which it holds sea::foam_inputs.
    Result<void> fill(const NewKeyframePtr& keyframe,
                      const sea::FoamHistory::StrainsAt& strains_at) {
        return fill(keyframe, keyframe->time_us,
                    [&](sea::TimeUs time_us) -> Result<sea::KeyframePtr> {
                        return time_us == keyframe->time_us ? Result<sea::KeyframePtr>(keyframe)
                                                            : strains_at(time_us);
                    });
    }

    /// Goes on from where the other is.
    void take_over(int cascade, const FoamMaps& other) {
        history(cascade) = other.histories_[static_cast<std::size_t>(cascade)];
    }

  private:
    sea::FoamHistory& history(int cascade);

    std::vector<sea::FoamHistory> histories_; ///< one a cascade
};

} // namespace seaway::server
