// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/vulkan_fields.h"

#include "base/check.h"

namespace seaway::server {

namespace {

constexpr std::size_t row_floats = 4 * shaders::slot_row_texels;
constexpr std::size_t basis_count = 8;
static_assert(static_cast<std::size_t>(sea::Basis::kxy_over_k) + 1 == basis_count);
static_assert(2 * shaders::max_slots >= sea::linear_field_count);

} // namespace

Packing pack(sea::FieldSet fields) {
    Packing packing;
    packing.plane.fill(-1);
    packing.fields = fields.size();
    packing.slots = (fields.size() + 1) / 2;
    packing.rows.assign(static_cast<std::size_t>(packing.slots) * row_floats, 0.0f);
    int plane = 0;
    for (const sea::Field field : fields) {
        SEAWAY_CHECK(sea::is_linear(field), "only linear fields are transforms");
        const sea::FieldInfo& row = sea::info(field);
        const auto part = static_cast<std::size_t>(plane % 2);
        float* slot = packing.rows.data() + static_cast<std::size_t>(plane / 2) * row_floats;
        slot[part * basis_count + static_cast<std::size_t>(row.basis)] =
            static_cast<float>(row.weight);
        float* flags = slot + 2 * basis_count + 2 * part;
        flags[0] = row.time_rate ? 1.0f : 0.0f;
        flags[1] = row.imaginary ? 1.0f : 0.0f;
        packing.plane[static_cast<std::size_t>(field)] = plane++;
    }
    return packing;
}

} // namespace seaway::server
