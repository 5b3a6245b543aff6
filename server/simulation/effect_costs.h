// SPDX-License-Identifier: Apache-2.0
// Effect costs: what each effect of each cascade has cost so far, and what a plan will cost.
//
// Work is measured a submission at a time. What is counted is shared out by transforms, time by transforms times
// N^2 log2 N, which is what a transform's half costs. A transform that several effects stand on - strains, on which
// both the gradient and foam do - is shared equally among them. Steps of foam have a time of their own, by points. The
// prediction for a plan is the same with the measured seconds a unit of either on this device.
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
    std::uint64_t keyframes = 0; ///< that hold it: ticks of foam histories alone are none
    double dispatches = 0;       ///< shares of shared ones
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

    /// Device seconds that an effect will take of one keyframe of all these fields; 0 before anything was measured.
    double predicted_seconds(std::size_t cascade, std::size_t effect, sea::FieldSet all) const;

  private:
    /// Work of a kind, and what it took.
    struct Measured {
        double work = 0;
        double seconds = 0;

        double of(double more) const { return work > 0 ? more * seconds / work : 0.0; }
    };
    EffectCost& cost_of(const KeyframeRequest& request, std::size_t effect) {
        return costs_[static_cast<std::size_t>(request.cascade) * effect_table().size() + effect];
    }
    double points(std::size_t cascade) const;
    /// Of one transform.
    double weight(std::size_t cascade) const;
    /// By the points of each turn.
    void add_foam_seconds(std::span<const KeyframeRequest> requests, double seconds);

    std::vector<int> sizes_;
    std::vector<EffectCost> costs_; ///< [cascade][effect]
    Measured transforms_;           ///< by weight
    Measured foam_;                 ///< turns, by points
    /// Turns of each cascade so far, and those that looked at strains: of a calm sea none do.
    std::vector<std::uint64_t> turns_, looks_;
};

/// The fields of `fields` that belong to an effect.
inline sea::FieldSet fields_of(const EffectInfo& effect, sea::FieldSet fields) {
    return effect.fields & fields;
}

} // namespace seaway::server
