// SPDX-License-Identifier: Apache-2.0
// Stylised waves that are no modes, added to the maps of a keyframe: what synthesizers do after the
// transforms. Pure; costs sines_at() a node, for plain sines 5 ns a wave and node, and nothing where the
// keyframe has none of their fields.
#pragma once

#include <cstdint>

#include "sea/surface/maps/keyframe.h"
#include "sea/waves/sine_waves.h"

namespace seaway::sea {

/// What stylised waves have: they move up and down alone.
inline constexpr FieldSet sine_fields{Field::height, Field::height_rate, Field::slope_x,
                                      Field::slope_y};

/// One sum a node takes so many terms: waves, or octaves.
inline std::size_t sine_terms(const SineField& field) {
    return field.kind == SineKind::noise ? field.octaves.size() : field.waves.size();
}

/// Adds the field to the maps of a keyframe of the same tile, node by node. Returns how many terms were summed:
/// sine_terms() a node; 0 where the keyframe has no field of theirs.
std::uint64_t add_sines(const SineField& field, TimeUs phase_time, Keyframe& keyframe);

} // namespace seaway::sea
