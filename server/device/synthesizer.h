// SPDX-License-Identifier: Apache-2.0
// Synthesizer: turns a realised sea into keyframes. One interface, several devices (Vulkan,
// native).
//
// Calls come from one thread (the simulation thread); a synthesizer need not be thread-safe.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "sea/basics/field.h"
#include "sea/surface/maps/keyframe.h"
#include "sea/waves/realization.h"
#include "server/device/synthesis_stage.h"

namespace seaway::server {

/// One keyframe wanted: which fields of which cascade, when. Field::foam is not a synthesizer's: its
/// plane, the last one, is left for the caller to fill.
struct KeyframeRequest {
    int cascade;
    sea::TimeUs time_us;
    sea::FieldSet fields;
    std::uint32_t epoch = 1; ///< of which sea; a synthesizer, which has one, does not look at it
};

/// The fields of a request that a synthesizer fills.
inline constexpr sea::FieldSet synthesized(sea::FieldSet fields) {
    return sea::FieldSet::from_bits(fields.bits() & ~sea::FieldSet{sea::Field::foam}.bits());
}

/// A keyframe that nobody else holds yet: it may still be written to.
using NewKeyframePtr = std::shared_ptr<sea::Keyframe>;

/// Kinds of a device's errors that somebody acts on; all others are of a device that failed.
enum class DeviceError {
    /// No other try would help: it has no kernels of a size, or computes wrongly.
    cannot_do_this_sea = 1,
    /// There is no memory for these requests now; for others, or later, there may be.
    out_of_memory,
};

/// What was done since the start; proves that nothing runs that nobody asked for.
struct SynthesisCounters {
    std::uint64_t dispatches = 0; ///< kernels started (native: passes)
    std::uint64_t transforms = 0; ///< 2-D transforms, one a real field
    std::uint64_t keyframes = 0;
    std::uint64_t cascades = 0; ///< whose waves were taken, a new sea at a time
    double device_seconds = 0;  ///< by the device's own clock where that costs nothing

    friend SynthesisCounters operator+(const SynthesisCounters& a, const SynthesisCounters& b) {
        return {a.dispatches + b.dispatches, a.transforms + b.transforms, a.keyframes + b.keyframes,
                a.cascades + b.cascades, a.device_seconds + b.device_seconds};
    }
    friend SynthesisCounters operator-(const SynthesisCounters& a, const SynthesisCounters& b) {
        return {a.dispatches - b.dispatches, a.transforms - b.transforms, a.keyframes - b.keyframes,
                a.cascades - b.cascades, a.device_seconds - b.device_seconds};
    }
};

class Synthesizer {
  public:
    virtual ~Synthesizer() = default;

    /// Device and variant for logs and /v1/plan: "lavapipe (llvmpipe ...), kernels W".
    virtual std::string description() const = 0;

    /// Takes a new sea; the next keyframes are of it, and of cascades that are there. `epoch` is stamped on them.
    virtual Result<void> set_sea(sea::RealizationPtr sea, std::uint32_t epoch) = 0;

    /// One keyframe a request, in order; requests of equal size may share dispatches. An error
    /// means the device failed (lost): the caller rebuilds or gives up; but for DeviceError::out_of_memory.
    virtual Result<std::vector<NewKeyframePtr>>
    synthesize(std::span<const KeyframeRequest> requests) = 0;

    /// What one keyframe goes through on the way to its maps, pass by pass; without the maps. Slow.
    virtual Result<std::vector<SynthesisStage>> stages(const KeyframeRequest&) {
        return Error{"this device shows no stages"};
    }

    virtual SynthesisCounters counters() const = 0;
};

} // namespace seaway::server
