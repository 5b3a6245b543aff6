// SPDX-License-Identifier: Apache-2.0
// Seas and keyframes for tests of foam.
#pragma once

#include "sea/foam/foam.h"
#include "sea/native/native_runner.h"
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

/// Strain keyframes of one cascade from the CPU transform.
class Strains {
  public:
    Strains(sea::RealizationPtr sea, int cascade)
        : sea_(std::move(sea)), cascade_(cascade), transform_(make(*sea_, cascade)), runner_(1) {}

    sea::KeyframePtr at(TimeUs time_us) {
        auto keyframe = std::make_shared<sea::Keyframe>();
        keyframe->cascade = cascade_;
        keyframe->time_us = time_us;
        keyframe->size = transform_.size();
        keyframe->fields = foam_inputs;
        keyframe->values.resize(3 * keyframe->plane_size());
        const sea::NativeTask task{&transform_, sea_->phase_time(time_us), foam_inputs,
                                   keyframe->values};
        runner_.run({&task, 1});
        return keyframe;
    }
    FoamHistory::StrainsAt source() {
        return [this](TimeUs time_us) -> Result<sea::KeyframePtr> {
            ++asked;
            return at(time_us);
        };
    }
    int asked = 0;

  private:
    static sea::NativeTransform make(const sea::Realization& sea, int cascade) {
        Result<sea::NativeTransform> made = sea::NativeTransform::create(
            sea.cascades[static_cast<std::size_t>(cascade)], sea.choppiness);
        return std::move(made).value();
    }
    sea::RealizationPtr sea_;
    int cascade_;
    sea::NativeTransform transform_;
    sea::NativeRunner runner_;
};

} // namespace seaway::sea
