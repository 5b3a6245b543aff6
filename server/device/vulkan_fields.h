// SPDX-License-Identifier: Apache-2.0
// Packing list: what the kernels are told of a set of fields, as numbers (shaders/shared/
// synthesis.h). Derived from sea::field_table alone; a new linear field needs no line here.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "sea/basics/field.h"
#include "shaders/shared/synthesis.h"

namespace seaway::server {

/// Of a texel, four floats: maps are read and copied by these.
inline constexpr std::size_t vec4_bytes = 16;
inline constexpr std::size_t complex_bytes = 8;

struct Packing {
    int fields = 0;  ///< transforms along x, and maps
    int sources = 0; ///< transforms along y, at most as many
    int maps = 0;    ///< a job leaves: those asked for in table order, then what they are made of
    int asked = 0;   ///< of these
    std::vector<float> rows;
    /// Which field comes out, 0 .. fields - 1, between the passes; -1: none.
    std::array<int, sea::field_count> plane{};
    /// Which of the maps of a job it is; -1: none.
    std::array<int, sea::field_count> map{};

    int plane_of(sea::Field field) const { return plane[static_cast<std::size_t>(field)]; }
    int map_of(sea::Field field) const { return map[static_cast<std::size_t>(field)]; }
};

/// `computed` must be linear: what transforms make. `asked`: the maps wanted, any. What they are made of stands `apart` maps
/// further on than right behind them; above 0 of one job alone.
Packing pack(sea::FieldSet computed, sea::FieldSet asked, std::size_t apart = 0);
inline Packing pack(sea::FieldSet fields) {
    return pack(fields, fields);
}

} // namespace seaway::server
