// SPDX-License-Identifier: Apache-2.0
// Keyframe source: any keyframe of the running sea, from the store or from the device, with foam
// where it is wanted; and what all of that has cost.
//
// The first failure of the device that rebuilding does not mend is the last word: from then on every
// call gives that same error, of kind Refusal::gone. For one thread, except report() and failed().
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "sea/surface/surface.h"
#include "server/device/rebuilt_synthesizer.h"
#include "server/simulation/effect_costs.h"
#include "server/simulation/foam_maps.h"
#include "server/simulation/keyframe_store.h"
#include "server/simulation/running_sea.h"

namespace seaway::server {

using SurfacePtr = std::shared_ptr<const sea::Surface>;

/// Two walks through time, each with foam histories of its own: the stream goes step by step,
/// questions jump to where someone asks.
enum class Walk { stream, questions };

class KeyframeSource {
  public:
    KeyframeSource(RunningSeaPtr sea, std::unique_ptr<RebuiltSynthesizer> device);

    /// One keyframe a request, in order, with at least its fields.
    Result<std::vector<sea::KeyframePtr>> keyframes(std::span<const KeyframeRequest> wanted,
                                                    Walk walk);

    /// From the keyframes of every cascade around a time; holds its times up to, without, `end_us`.
    struct SurfaceSpan {
        SurfacePtr surface;
        sea::TimeUs end_us;
    };
    Result<SurfaceSpan> surface_around(sea::TimeUs time_us);

    /// Why there are no more keyframes.
    const std::optional<Error>& failure() const { return failure_; }
    bool failed() const { return failed_; } ///< any thread

    struct Report {
        std::string device;
        SynthesisCounters synthesis;
        StoreCounters store;
        EffectCosts costs;
        std::uint64_t device_rebuilds = 0;
    };
    Report report() const;

  private:
    Result<std::vector<sea::KeyframePtr>> compute(std::span<const KeyframeRequest> requests,
                                                  FoamMaps& foam);
    /// `asked`: the same requests without what foam stands on; for the accounts.
    Result<std::vector<NewKeyframePtr>> synthesize(std::span<const KeyframeRequest> requests,
                                                   std::span<const KeyframeRequest> asked);
    Result<void> fill_foam(const NewKeyframePtr& keyframe, FoamMaps& foam);

    const RunningSeaPtr sea_;
    const std::unique_ptr<RebuiltSynthesizer> device_;
    FoamMaps streamed_foam_;
    FoamMaps asked_foam_;
    KeyframeStore store_;
    std::optional<Error> failure_;
    std::atomic<bool> failed_ = false;

    mutable std::mutex mutex_; ///< of what follows
    std::string description_;
    SynthesisCounters synthesis_;
    EffectCosts costs_;
    std::uint64_t device_rebuilds_ = 0;
};

} // namespace seaway::server
