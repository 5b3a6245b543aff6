// SPDX-License-Identifier: Apache-2.0
// Effect costs: what each effect of each cascade has cost so far, and what a plan will cost.
//
// Work is measured a submission at a time; within it, time and transforms are shared out by
// field * N^2 log2 N, which is what a transform's half costs. The prediction for a plan is the same
// weight times the measured seconds a unit of weight on this device.
//
// Not thread-safe; the simulation guards it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "server/device/synthesizer.h"
#include "server/simulation/effect_plan.h"

namespace seaway::server {

/// Of one effect (a row of effect_table()) of one cascade.
struct EffectCost {
    std::uint64_t keyframes = 0;
    double dispatches = 0; ///< shares of shared ones
    double transforms = 0;
    double device_seconds = 0;
};

class EffectCosts {
  public:
    /// `sizes`: grid points a side of each cascade.
    explicit EffectCosts(std::vector<int> sizes);

    /// What was asked of a device in one call, and by how much its counters grew. Foam is what turns of
    /// foam maps took, with the strains that they look at.
    void add(std::span<const KeyframeRequest> requests, const SynthesisCounters& growth);

    const EffectCost& cost(std::size_t cascade, std::size_t effect) const {
        return costs_[cascade * effect_table().size() + effect];
    }

    /// Device seconds of one keyframe of these fields of one effect; 0 before anything was
    /// measured.
    double predicted_seconds(std::size_t cascade, sea::FieldSet fields) const;

  private:
    /// By the points of each turn.
    void add_foam_seconds(std::span<const KeyframeRequest> requests, double seconds);
    double weight(std::size_t cascade, sea::FieldSet fields) const;

    std::vector<int> sizes_;
    std::vector<EffectCost> costs_; ///< [cascade][effect]
    double weight_done_ = 0;
    double seconds_done_ = 0;
};

/// The fields of `fields` that belong to an effect.
inline sea::FieldSet fields_of(const EffectInfo& effect, sea::FieldSet fields) {
    return sea::FieldSet::from_bits(effect.fields.bits() & fields.bits());
}

} // namespace seaway::server
