// SPDX-License-Identifier: Apache-2.0
// Local surface: answers from the keyframes that a client holds, with the error that they cost.
//
// error_m of an answer = interpolation in space and time (the sea state says it) + what the tiles'
// codec bounds come to in height, and in sideways displacement times slope + the residual of the
// inverse displacement. The clock is no part of it: an answer is about the sea time that it states.
//
// Pure but for the ring that is read; thread-safe.
#pragma once

#include <cstdint>
#include <span>

#include "base/result.h"
#include "base/short_list.h"
#include "client/held/keyframe_ring.h"
#include "client/link/connection.h"
#include "sea/surface/surface.h"

namespace seaway::client {

struct LocalSurface {
    sea::Surface surface;
    /// Every cascade has keyframes on both sides of the time; otherwise answers are flagged
    /// answer_extrapolated and error_m is no bound.
    bool covers = false;
};

/// Failure::bad_argument for a time at which no sea is computed, here or by a server (sea::time_us_max).
Result<void> check_time(sea::TimeUs time_us);
/// The same, and for a place further out than a server answers (sea::position_max_m); one that is no number is answered as such.
Result<void> check_point(const sea::QueryPoint& point);

/// The keyframes of it, and no surface yet. Their splines are made.
struct HeldPairs {
    ShortList<KeyframePair, sea::surface_pairs_max> pairs;
    bool covers = false;
};
Result<HeldPairs> held_pairs(const SeaState& state, const KeyframeRing& ring, sea::TimeUs time_us,
                             sea::FieldSet fields, std::uint32_t cascades = sea::all_cascades);
sea::Surface surface_of(const SeaState& state, sea::TimeUs time_us, const HeldPairs& held);
/// The surface around one time. `fields`: what keyframes must hold to be used. An error (not_held)
/// names the cascade of which nothing is held. `cascades`: of these alone, a bit each.
Result<LocalSurface> local_surface(const SeaState& state, const KeyframeRing& ring,
                                   sea::TimeUs time_us, sea::FieldSet fields,
                                   std::uint32_t cascades = sea::all_cascades);

/// Are keyframes held on both sides of this time, of every cascade? If so, then for the whole of
/// its time_cell().
bool covers(const SeaState& state, const KeyframeRing& ring, sea::TimeUs time_us,
            sea::FieldSet fields);

/// What the codec bounds of these keyframes add to the error, beside the state's interpolation.
sea::MapError local_map_error(const SeaState& state, std::span<const KeyframePair> pairs);

/// What coding costs heights and displacements of a pair, beside what its sea says of the cascade.
void add_codec(sea::CascadeLoss& loss, const KeyframePair& pair);

/// The largest on the way of a sea that glides.
sea::Choppiness largest_choppiness(const SeaState& state);
double shortest_wave_radpm(const SeaState& state);
/// Of a server that does not say: as if its steepest waves were its shortest.
double told_curvature_per_m(const SeaState& state);

/// Choppiness differs from moment to moment: a surface is of its moment alone.
bool glides_choppiness(const SeaState& state);

/// One keyframe interval of every cascade: times in the same cell need the same keyframes.
using TimeCell = ShortList<sea::TimeUs, sea::surface_pairs_max>;
TimeCell time_cell(const SeaState& state, sea::TimeUs time_us);

} // namespace seaway::client
