// SPDX-License-Identifier: Apache-2.0
#include "server/device/vulkan_fields.h"

#include <algorithm>

#include "base/check.h"

namespace seaway::server {

namespace {

constexpr std::size_t texel_floats = 4; // floats
constexpr std::size_t row_floats = texel_floats * static_cast<std::size_t>(shaders::row_texels_max);
static_assert(shaders::max_fields >= sea::linear_field_count);
static_assert(shaders::max_sources >= sea::linear_field_count);

/// A basis function is a power of kx times one of 1, ky, 1/k, ky/k, ky^2/k.
struct Factors {
    std::size_t power_x;
    std::size_t rest; ///< in that order, as in the rows of sources
};

Factors factors(sea::Basis basis) {
    switch (basis) {
    case sea::Basis::one:
        return {0, 0};
    case sea::Basis::kx:
        return {1, 0};
    case sea::Basis::ky:
        return {0, 1};
    case sea::Basis::kx_over_k:
        return {1, 2};
    case sea::Basis::kxx_over_k:
        return {2, 2};
    case sea::Basis::ky_over_k:
        return {0, 3};
    case sea::Basis::kxy_over_k:
        return {1, 3};
    case sea::Basis::kyy_over_k:
        return {0, 4};
    }
    SEAWAY_CHECK(false, "a basis function that no kernel knows");
    return {};
}

struct Source {
    std::size_t rest;
    bool time_rate;
    std::vector<sea::Field> fields;
};

std::vector<Source> sources_of(sea::FieldSet fields) {
    std::vector<Source> sources;
    for (const sea::Field field : fields) {
        SEAWAY_CHECK(sea::is_linear(field), "only linear fields are transforms");
        const sea::FieldInfo& row = sea::info(field);
        const std::size_t rest = factors(row.basis).rest;
        const auto same = std::find_if(sources.begin(), sources.end(), [&](const Source& source) {
            return source.rest == rest && source.time_rate == row.time_rate;
        });
        if (same != sources.end())
            same->fields.push_back(field);
        else
            sources.push_back({rest, row.time_rate, {field}});
    }
    return sources;
}

} // namespace

Packing pack(sea::FieldSet computed, sea::FieldSet asked, std::size_t apart) {
    Packing packing;
    packing.plane.fill(-1);
    packing.map.fill(-1);
    for (const sea::Field field : asked)
        packing.map[static_cast<std::size_t>(field)] = packing.maps++;
    packing.asked = packing.maps;
    for (const sea::Field field : computed.without(asked))
        packing.map[static_cast<std::size_t>(field)] = packing.maps++ + static_cast<int>(apart);
    packing.rows.assign(row_floats, 0.0f);
    for (const Source& source : sources_of(computed)) {
        float* row =
            packing.rows.data() + 2 * texel_floats * static_cast<std::size_t>(packing.sources++);
        row[source.rest] = 1.0f;
        row[5] = source.time_rate ? 1.0f : 0.0f;
        row[6] = static_cast<float>(packing.fields);
        row[7] = row[6] + static_cast<float>(source.fields.size());
        for (const sea::Field field : source.fields) {
            const sea::FieldInfo& info = sea::info(field);
            float* field_row =
                packing.rows.data() + texel_floats * (shaders::first_field_texel +
                                                      static_cast<std::size_t>(packing.fields));
            field_row[factors(info.basis).power_x] = static_cast<float>(info.weight);
            field_row[3] = info.imaginary ? 1.0f : 0.0f;
            packing.rows[texel_floats *
                         (shaders::first_map_texel + static_cast<std::size_t>(packing.fields))] =
                static_cast<float>(packing.map_of(field));
            packing.plane[static_cast<std::size_t>(field)] = packing.fields++;
        }
    }
    return packing;
}

} // namespace seaway::server
