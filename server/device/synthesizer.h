// SPDX-License-Identifier: Apache-2.0
// Synthesizer: turns a realised sea into keyframes. One interface, several devices (Vulkan,
// native).
//
// Calls come from one thread (the simulation thread); a synthesizer need not be thread-safe.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "sea/basics/field.h"
#include "sea/foam/foam_walk.h"
#include "sea/surface/maps/keyframe.h"
#include "sea/waves/realization.h"
#include "server/device/synthesis_stage.h"

namespace seaway::server {

/// The map of a foam history, ratios of one cascade, where a device keeps it. Its memory is given back when the last
/// holder lets go, on any thread.
class FoamMap {
  public:
    virtual ~FoamMap() = default;
    /// Its device is gone, and what stood here with it.
    virtual bool lost() const = 0;
};
using FoamMapPtr = std::shared_ptr<FoamMap>;

/// What the strains of a request do to a foam map: first it takes the tick that is to be kept, then the keyframe is
/// given what it shows.
struct FoamTurn {
    FoamMap* map = nullptr;
    std::optional<sea::FoamTick> kept;
    sea::FoamView shown; ///< where the request has Field::foam

    bool looks(sea::FieldSet fields) const {
        return (kept && kept->looks()) || (fields.contains(sea::Field::foam) && shown.tick.looks());
    }
};

/// One keyframe wanted: which fields of which cascade, when. It has these and no other. With a turn Field::foam is filled
/// too; without one the plane of Field::foam, the last, is left for the caller. Turns of one map are taken in the order
/// of their requests.
struct KeyframeRequest {
    int cascade;
    sea::TimeUs time_us;
    sea::FieldSet fields;
    std::uint32_t epoch = 1; ///< of which sea; a synthesizer, which has one, does not look at it
    const FoamTurn* foam = nullptr; ///< valid during the call
    /// How far samples of each field, in table order, may be off what is computed, in its unit; > 0. A device whose memory
    /// the CPU cannot read may then round them to 16 bits and send half the bytes (Keyframe::rounded); fields for which
    /// these are too few come as they are. None: nothing is rounded. Valid during the call.
    std::span<const float> rounding = {};
};

/// The fields of a request that transforms fill, and the Jacobian.
inline constexpr sea::FieldSet synthesized(sea::FieldSet fields) {
    return fields.without({sea::Field::foam});
}

/// Those that ask for a keyframe, and not for a tick of a foam history alone.
inline std::uint64_t with_fields(std::span<const KeyframeRequest> requests) {
    return static_cast<std::uint64_t>(std::ranges::count_if(
        requests, [](const KeyframeRequest& request) { return !request.fields.empty(); }));
}

/// A keyframe that nobody else holds yet: it may still be written to.
using NewKeyframePtr = std::shared_ptr<sea::Keyframe>;

/// Kinds of a device's errors that somebody acts on; all others are of a device that failed.
enum class DeviceError {
    /// No other try would help: it has no kernels of a size, or computes wrongly.
    cannot_do_this_sea = 1,
    /// There is no memory for these requests now; for others, or later, there may be.
    out_of_memory,
    /// The device was made anew, and has none of its foam maps (FoamMap::lost): histories start again.
    foam_lost,
};

/// What was done since the start; proves that nothing runs that nobody asked for.
struct SynthesisCounters {
    std::uint64_t dispatches = 0; ///< kernels started (native: passes)
    std::uint64_t transforms = 0; ///< 2-D transforms, one a real field
    std::uint64_t keyframes = 0;  ///< that have a field: a tick of a foam history alone is none
    std::uint64_t cascades = 0;   ///< whose waves were taken, a new sea at a time
    double device_seconds = 0;    ///< by the device's own clock where that costs nothing
    std::uint64_t copies = 0;     ///< of keyframes, out of a device's memory
    std::uint64_t foam_ticks = 0; ///< of all histories, and steps that were shown and not kept
    double foam_seconds =
        0; ///< what they took, where it can be told apart; then not in device_seconds
    std::uint64_t readback_bytes = 0; ///< that travelled from device memory the CPU cannot read
    std::uint64_t maps_rounded = 0;   ///< of those that travelled
    std::array<std::uint64_t, sea::field_count> maps_too_large =
        {}; ///< that were to be rounded and travelled as floats, by field
    std::uint64_t readbacks_beside =
        0; ///< runs whose maps were waited for when the next run had been submitted
    std::uint64_t stylised_sums = 0; ///< of one wave at one point (sea/surface/maps/sine_maps.h)

    friend SynthesisCounters operator+(SynthesisCounters a, const SynthesisCounters& b) {
        return a.each(b, [](auto& own, auto other) { own += other; });
    }
    friend SynthesisCounters operator-(SynthesisCounters a, const SynthesisCounters& b) {
        return a.each(b, [](auto& own, auto other) { own -= other; });
    }

  private:
    template <class Work>
    SynthesisCounters each(const SynthesisCounters& other, const Work& work) {
        work(dispatches, other.dispatches);
        work(transforms, other.transforms);
        work(keyframes, other.keyframes);
        work(cascades, other.cascades);
        work(device_seconds, other.device_seconds);
        work(copies, other.copies);
        work(foam_ticks, other.foam_ticks);
        work(foam_seconds, other.foam_seconds);
        work(readback_bytes, other.readback_bytes);
        work(maps_rounded, other.maps_rounded);
        for (std::size_t i = 0; i < maps_too_large.size(); ++i)
            work(maps_too_large[i], other.maps_too_large[i]);
        work(readbacks_beside, other.readbacks_beside);
        work(stylised_sums, other.stylised_sums);
        return *this;
    }
};

/// What keyframes and foam are made with: a device, or whoever accounts for one.
class KeyframeMaker {
  public:
    virtual ~KeyframeMaker() = default;

    /// A foam map of so many points a side: that of another, which is not lost, or 1 everywhere.
    virtual Result<FoamMapPtr> open_foam(int size, const FoamMap* from) = 0;

    /// One keyframe a request, in order; requests of equal size may share dispatches. An error
    /// means the device failed (lost): the caller rebuilds or gives up; but for DeviceError::out_of_memory.
    /// After any error maps of the requests' turns are of no known time.
    virtual Result<std::vector<NewKeyframePtr>>
    synthesize(std::span<const KeyframeRequest> requests) = 0;
};

class Synthesizer : public KeyframeMaker {
  public:
    /// Device and variant for logs and /v1/plan: "lavapipe (llvmpipe ...), kernels W".
    virtual std::string description() const = 0;

    /// Takes a new sea; the next keyframes are of it, and of cascades that are there. `epoch` is stamped on them.
    virtual Result<void> set_sea(sea::RealizationPtr sea, std::uint32_t epoch) = 0;

    /// What one keyframe goes through on the way to its maps, pass by pass; without the maps. Slow.
    virtual Result<std::vector<SynthesisStage>> stages(const KeyframeRequest&) {
        return Error{"this device shows no stages"};
    }

    virtual SynthesisCounters counters() const = 0;

    /// From time to time: lets go of memory for work that has not been needed over the last few of these calls.
    virtual void trim() {}
};

} // namespace seaway::server
