// SPDX-License-Identifier: Apache-2.0
// SeaFrame: all that the renderer wants to know of the sea at one moment. A value.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "gpu/buffer.h"
#include "sea/basics/cascade.h"
#include "sea/basics/dispersion.h"
#include "sea/basics/water_type.h"
#include "sea/surface/maps/keyframe.h"
#include "sea/surface/surface.h"
#include "sea/waves/realization.h"

namespace seaway::client {

/// A keyframe whose maps stand in the memory of the renderer's device, where no CPU reads them: of each field one map, in
/// the order of the table, one after the other.
struct StandingKeyframe {
    sea::TimeUs time_us = 0;
    int size = 0;                         ///< a power of two
    sea::FieldSet fields;                 ///< height and its rate, what moves sideways, foam
    const gpu::TexelView* maps = nullptr; ///< of four floats
    std::size_t first_texel = 0;
    std::shared_ptr<const void> keeper; ///< until it goes, nothing else is written there
};
using StandingKeyframePtr = std::shared_ptr<const StandingKeyframe>;

struct CascadeFrame {
    sea::CascadeSpec spec;
    sea::Band band;
    sea::SplinePair keyframes{}; ///< around the time; null where they stand on the device
    /// Keyframes of these times with Field::foam; null where the scene has no foam.
    sea::KeyframePtr foam_before{};
    sea::KeyframePtr foam_after{};
    /// In place of all of those: around the time, foam among their maps.
    struct Standing {
        StandingKeyframePtr before, after;
    };
    std::optional<Standing> standing{};

    sea::TimeUs before_us() const {
        return standing ? standing->before->time_us : keyframes.before->time_us();
    }
    sea::TimeUs after_us() const {
        return standing ? standing->after->time_us : keyframes.after->time_us();
    }
    int points() const { return standing ? standing->before->size : keyframes.before->size(); }
};

struct SeaFrame {
    sea::TimeUs time_us = 0;
    std::vector<CascadeFrame> cascades; ///< longest tile first; 1 .. shaders::view_cascades_max
    sea::Choppiness choppiness;
    // Of the sea state, so that nothing that is built from them changes from frame to frame.
    double significant_height_m = 1;
    double mean_from_deg = 0;     ///< bearing that waves come from
    double reach_m = 1;           ///< no point is moved sideways further, choppiness included
    double foam_threshold = 0.45; ///< Jacobian below which a crest breaks
    double foam_mean = 0;         ///< mean coverage by what has broken (docs/foam.md); 0: no foam
    double depth_m = sea::deep_water_m; ///< still
    sea::Water water;
    /// What these keyframes cost in accuracy, as answers state it.
    sea::MapError error{};
    /// Height of the water at a place and time_us, where the maps stand on the device; else empty: they say it.
    std::function<double(double x_m, double y_m)> water_m{};

    /// All of them do, or none.
    bool stands_there() const { return !cascades.empty() && cascades.front().standing.has_value(); }
};

} // namespace seaway::client
