// SPDX-License-Identifier: Apache-2.0
// The warnings of a scene, from the sea that it makes.
#pragma once

#include "sea/scene/scene_warnings.h"

namespace seaway::testing {

inline std::vector<std::string> warnings_of(const sea::Scene& scene) {
    const sea::Realization sea = *sea::realize(scene);
    return sea::scene_warnings(scene, sea, sea::summarize(scene.sea, sea),
                               sea::plan_budget(sea, scene.accuracy.height_error_m));
}

} // namespace seaway::testing
