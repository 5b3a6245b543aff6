// SPDX-License-Identifier: Apache-2.0
// The sea itself on one square: all cascades summed, as a keyframe of the longest tile's length.
//
// Each cascade's maps are sampled by the cubic splines that answers use (sea/surface/maps/spline_map.h),
// so a cascade of the same length and size is taken over to rounding. The Jacobian is that of the
// summed strains, foam is coverage 0 .. 1 as sea/foam/foam.h combines it.
//
// The square repeats without a seam only where every tile's length divides the longest
// (summed_tile_repeats). Pure; thread-safe. About 0.1 us a point, cascade and field.
#pragma once

#include <span>
#include <vector>

#include "sea/basics/field.h"
#include "sea/surface/maps/keyframe.h"
#include "sea/waves/realization.h"

namespace seaway::bake {

/// Keyframes of all cascades at one time, and where foam is wanted its ratio maps, one a cascade.
struct CascadeMaps {
    std::span<const sea::KeyframePtr> keyframes;
    std::vector<std::span<const float>> foam_ratios; ///< empty: no foam
    double foam_mean = 0;
};

/// Whether the summed square meets itself at its edges.
bool summed_tile_repeats(const sea::Realization& sea);

/// Points a side: those of the largest cascade.
int summed_size(const sea::Realization& sea);

/// `fields` of the sea. The keyframes must hold the linear ones among them, and the strains where
/// the Jacobian is wanted. Its `cascade` is -1.
sea::Keyframe sum_cascades(const sea::Realization& sea, const CascadeMaps& maps,
                           sea::FieldSet fields);

} // namespace seaway::bake
