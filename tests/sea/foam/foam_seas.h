// SPDX-License-Identifier: Apache-2.0
// Seas and keyframes for tests of foam.
#pragma once

#include "sea/foam/foam.h"
#include "tests/support/explicit_sea.h"

namespace seaway::sea {

/// A short-crested storm sea on two tiles; sigma of J about 0.25.
inline sea::RealizationPtr storm(double steepness = 0.03, unsigned seed = 1) {
    return tests::make_sea({tests::random_cascade(211.0, 64, 12, 60, steepness, seed),
                            tests::random_cascade(37.0, 64, 18, 60, steepness, seed + 1)});
}

inline const sea::FoamModel foam_model{0.6, 4.0, 3.0};

/// Of keyframes; a tick is as long.
inline constexpr TimeUs interval_us = 200'000;

/// A keyframe with the same strains everywhere.
inline sea::Keyframe uniform_strains(int size, float xx, float yy = 0, float xy = 0) {
    sea::Keyframe keyframe;
    keyframe.size = size;
    keyframe.fields = foam_inputs;
    for (const float value : {xx, yy, xy})
        keyframe.values.insert(keyframe.values.end(), keyframe.plane_size(), value);
    return keyframe;
}

} // namespace seaway::sea
