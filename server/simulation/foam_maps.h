// SPDX-License-Identifier: Apache-2.0
// Foam maps: the histories of a sea's cascades, and keyframes with a foam map from them.
// For one thread.
#pragma once

#include <vector>

#include "base/result.h"
#include "sea/foam/foam.h"
#include "server/device/synthesizer.h"
#include "server/simulation/running_sea.h"

namespace seaway::server {

/// Fields with those that foam stands on, where foam is among them.
inline sea::FieldSet with_foam_inputs(sea::FieldSet fields) {
    return fields.contains(sea::Field::foam) ? fields | sea::foam_inputs : fields;
}

class FoamMaps {
  public:
    /// Without a foam law (RunningSea::foam_law) there is nothing to add.
    explicit FoamMaps(const RunningSea& sea);

    /// Fills Field::foam of a keyframe that holds it and sea::foam_inputs. `strains_at` gives the
    /// same cascade at earlier times, for a history that starts.
    Result<void> fill(const NewKeyframePtr& keyframe,
                      const sea::FoamHistory::StrainsAt& strains_at);

  private:
    std::vector<sea::FoamHistory> histories_; ///< one a cascade
};

} // namespace seaway::server
