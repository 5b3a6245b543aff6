// SPDX-License-Identifier: Apache-2.0
// Packing list: which two real fields share which complex transform, as the numbers that the
// kernels take. Derived from sea::field_table alone; a new linear field needs no line here.
#pragma once

#include <array>
#include <vector>

#include "sea/field.h"
#include "shaders/shared/synthesis.h"

namespace seaway::server {

struct Packing {
    int fields = 0;          ///< number of them
    int slots = 0;           ///< complex transforms: half the number of fields, rounded up
    std::vector<float> rows; ///< [slot][4 * slot_row_texels], as shaders/shared/synthesis.h says
    /// Where a field comes out: plane 2 slot + 0 (real part) or + 1 (imaginary part); -1: nowhere.
    std::array<int, sea::linear_field_count> plane{};

    int plane_of(sea::Field field) const { return plane[static_cast<std::size_t>(field)]; }
};

/// `fields` must be linear. An odd number leaves the last imaginary part zero.
Packing pack(sea::FieldSet fields);

} // namespace seaway::server
