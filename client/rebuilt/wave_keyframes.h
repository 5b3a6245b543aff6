// SPDX-License-Identifier: Apache-2.0
// WaveKeyframes: keyframes for sampling of a sea whose waves this client has, the same as its server makes of them: in a glide
// of the waves of that moment, with what they grow by in their time rates (server/simulation/course_synthesis.h).
//
// One caller at a time. Nothing is held before the first is made; of a steady sea its transforms from then on, a megabyte at 256 x 256.
// Cost: 1 ms at 256 x 256, in a glide 2.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "client/rebuilt/rebuilt_sea.h"
#include "sea/native/native_runner.h"
#include "sea/surface/maps/keyframe.h"

namespace seaway::client {

class WaveKeyframes {
  public:
    explicit WaveKeyframes(OwnSeaPtr waves) : waves_(std::move(waves)) {}

    /// With sea::surface_fields. Nothing: a tile has a size without a transform.
    std::optional<sea::Keyframe> make(std::uint32_t epoch, int cascade, sea::TimeUs time_us);

  private:
    /// These fields of one cascade of this sea, to the keyframe's.
    bool put_maps(const sea::Realization& sea, const sea::NativeTransform* transform,
                  sea::Keyframe& keyframe);
    bool put_steady(sea::Keyframe& keyframe);
    bool put_gliding(const sea::SeaTransition& change, sea::Keyframe& keyframe);
    bool add_growth(const sea::SeaTransition& change, const sea::Realization& growth,
                    sea::FieldSet values, sea::Keyframe& keyframe);

    const OwnSeaPtr waves_;
    sea::RealizationPtr steady_; ///< with the next
    std::vector<std::optional<sea::NativeTransform>> transforms_;
    std::unique_ptr<sea::NativeRunner> runner_;
};

} // namespace seaway::client
