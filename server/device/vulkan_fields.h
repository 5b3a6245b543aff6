// SPDX-License-Identifier: Apache-2.0
// Packing list: what the kernels are told of a set of fields, as numbers (shaders/shared/
// synthesis.h). Derived from sea::field_table alone; a new linear field needs no line here.
#pragma once

#include <array>
#include <vector>

#include "sea/basics/field.h"
#include "shaders/shared/synthesis.h"

namespace seaway::server {

struct Packing {
    int fields = 0;  ///< transforms along x, and maps
    int sources = 0; ///< transforms along y, at most as many
    std::vector<float> rows;
    /// Where a field comes out, 0 .. fields - 1; -1: nowhere.
    std::array<int, sea::field_count> plane{};

    int plane_of(sea::Field field) const { return plane[static_cast<std::size_t>(field)]; }
};

/// `fields` must be linear.
Packing pack(sea::FieldSet fields);

} // namespace seaway::server
