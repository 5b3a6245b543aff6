// SPDX-License-Identifier: Apache-2.0
// Stylised waves that are no modes, added to the maps of a keyframe: what synthesizers do after the
// transforms. Pure; costs sines_at() a node, for plain sines 5 ns a wave and node.
#pragma once

#include "sea/surface/maps/keyframe.h"
#include "sea/waves/sine_waves.h"

namespace seaway::sea {

/// Adds the field to the maps of a keyframe of the same tile, node by node.
void add_sines(const SineField& field, TimeUs phase_time, Keyframe& keyframe);

} // namespace seaway::sea
