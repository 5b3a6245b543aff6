// SPDX-License-Identifier: Apache-2.0
// Foam maps: the histories of a sea's cascades, and keyframes with a foam map from them. A history
// that starts, or jumps in time, walks through hundreds of ticks: that is done in slices. The maps themselves are
// where the device has them; one that was lost with its device is walked for anew.
//
// A copy is for free: histories share a map until one of them goes on.
// For one thread.
#pragma once

#include <functional>
#include <span>
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

class FoamMaps {
  public:
    /// Without a foam law (RunningSea::foam_law) there is nothing to add. Histories tick by the first sea of the course
    /// and go on over its changes.
    explicit FoamMaps(SeaCoursePtr course);

    /// Ticks that are left before the map of a cascade is that of a time.
    int ticks_to(int cascade, sea::TimeUs time_us) const;
    /// All that are left are done by the turn() of a keyframe of that time.
    bool is_near(int cascade, sea::TimeUs time_us) const;

    /// Is the sea of this time there, so that its law and its strains can be looked at? Empty: each is made that is not.
    using IsThere = std::function<bool(sea::TimeUs)>;
    /// At most `ticks_max` >= 1 of those ticks, `until_us` at the latest, and none of a sea that is not there; true: none
    /// of these is left.
    Result<bool> walk(KeyframeMaker& device, int cascade, sea::TimeUs time_us, int ticks_max,
                      sea::TimeUs until_us, const IsThere& is_there = {});
    Result<bool> walk_towards(KeyframeMaker& device, int cascade, sea::TimeUs time_us,
                              int ticks_max) {
        return walk(device, cascade, time_us, ticks_max, time_us);
    }
    Result<bool> walk_near(KeyframeMaker& device, int cascade, sea::TimeUs time_us, int ticks_max) {
        return walk(device, cascade, time_us, ticks_max, time_us - 1);
    }

    /// What a keyframe of that time does to the map, which is_near(). Counts as done: where it comes to nothing, and
    /// after any error of the device, restart(). There may be one turn of a cascade in a call of synthesize().
    Result<FoamTurn> turn(KeyframeMaker& device, int cascade, sea::TimeUs time_us);
    void restart(int cascade) { history(cascade).walk.restart(); }

    /// Keyframes with foam where it is asked for, one a cascade: walks what is left, then makes them all at once.
    Result<std::vector<NewKeyframePtr>> synthesize(KeyframeMaker& device,
                                                   std::vector<KeyframeRequest> requests);

    /// Histories that are past the start of a change that was added since the last call walked through a sea that will
    /// not be: they start anew.
    void follow_changes();
    /// Before a cascade is walked: until then its sea is taken for the only one, so that what walk() found near is so for the
    /// turn() that follows, whatever is added in between.
    void look_for_changes(int cascade);

    /// Goes on from where the other is.
    void take_over(int cascade, const FoamMaps& other) {
        history(cascade) = other.histories_[static_cast<std::size_t>(cascade)];
    }

  private:
    struct History {
        int size;
        sea::FoamWalk walk;
        FoamMapPtr map; ///< null until there is something to keep

        bool lost() const { return map != nullptr && map->lost(); }
    };
    History& history(int cascade);
    /// It has a map that no other history stands on.
    static Result<void> own(History& history, KeyframeMaker& device);

    SeaCoursePtr course_;
    std::vector<History> histories_; ///< one a cascade
    std::uint32_t epochs_;           ///< of the course, at the last follow_changes()
};

} // namespace seaway::server
