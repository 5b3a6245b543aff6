// SPDX-License-Identifier: Apache-2.0
// Foam maps: the histories of a sea's cascades, and keyframes with a foam map from them.
// For one thread.
#pragma once

#include <vector>

#include "base/result.h"
#include "sea/foam/foam.h"
#include "server/simulation/running_sea.h"

namespace seaway::server {

/// What a synthesizer must compute so that foam can be added: foam itself replaced by the strains
/// that it stands on.
inline sea::FieldSet foam_replaced(sea::FieldSet fields) {
    if (!fields.contains(sea::Field::foam))
        return fields;
    const sea::FieldSet foam{sea::Field::foam};
    return sea::FieldSet::from_bits(fields.bits() & ~foam.bits()) | sea::foam_inputs;
}

class FoamMaps {
  public:
    /// Without a foam law (RunningSea::foam_law) there is nothing to add.
    explicit FoamMaps(const RunningSea& sea);

    /// The keyframe, which holds sea::foam_inputs, with Field::foam after its fields. `strains_at` gives
    /// the same cascade at earlier times, for a history that starts.
    Result<sea::KeyframePtr> add(const sea::KeyframePtr& keyframe,
                                 const sea::FoamHistory::StrainsAt& strains_at);

  private:
    std::vector<sea::FoamHistory> histories_; ///< one a cascade
};

} // namespace seaway::server
