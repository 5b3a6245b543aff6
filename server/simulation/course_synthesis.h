// SPDX-License-Identifier: Apache-2.0
// Keyframes of any epoch of a course from one device, which holds one sea at a time.
//
// In a glide the device is given the waves of each moment anew, of the cascades that are asked for. Their time rates, by which keyframes are joined, are
// those of waves that stand; what their growth adds to them is made of a second sea, the growth itself
// (SeaTransition::growth), so that the maps between two keyframes hold the same bounds as those of a steady sea.
//
// For one thread.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "server/device/rebuilt_synthesizer.h"
#include "server/simulation/sea_course.h"

namespace seaway::server {

class CourseSynthesis final : public KeyframeMaker {
  public:
    /// The device holds the course's first sea.
    CourseSynthesis(SeaCoursePtr course, std::unique_ptr<RebuiltSynthesizer> device)
        : course_(std::move(course)), device_(std::move(device)), held_{{course_->first()->epoch}} {
    }

    Result<FoamMapPtr> open_foam(int size, const FoamMap* from) override {
        return device_->open_foam(size, from);
    }
    /// Those of one sea and moment share dispatches. Turns of one foam map must come in the order of time.
    Result<std::vector<NewKeyframePtr>>
    synthesize(std::span<const KeyframeRequest> requests) override;

    const RebuiltSynthesizer& device() const { return *device_; }
    void trim() { device_->trim(); }

  private:
    /// What the device holds: an epoch, and of a glide the moment, or what that grows by.
    enum class Part { waves, growth, displacement_growth };
    struct Held {
        std::uint32_t epoch;
        std::optional<sea::TimeUs> time_us = {};
        Part part = Part::waves;
        std::uint32_t cascades =
            sea::all_cascades; ///< of a glide those that were asked for, a bit each
        bool is_alike(const Held& other) const {
            return epoch == other.epoch && time_us == other.time_us && part == other.part;
        }
        bool serves(const Held& wanted) const {
            return is_alike(wanted) && (wanted.cascades & ~cascades) == 0;
        }
    };
    Held sea_of(const KeyframeRequest& request) const;
    Result<void> hold(const Held& sea);
    Result<std::vector<NewKeyframePtr>> of_one_sea(const Held& sea,
                                                   std::span<const KeyframeRequest> requests);
    /// What the waves grow by.
    Result<void> add_growth(const Held& sea, std::span<const KeyframeRequest> requests,
                            std::span<const NewKeyframePtr> keyframes);
    /// To the rates of these maps.
    Result<void> add_growth_of(sea::FieldSet maps, const Held& grown,
                               std::span<const KeyframeRequest> requests,
                               std::span<const NewKeyframePtr> keyframes);
    sea::RealizationPtr waves_of(const Held& held) const;

    const SeaCoursePtr course_;
    const std::unique_ptr<RebuiltSynthesizer> device_;
    std::optional<Held> held_;
};

} // namespace seaway::server
