// SPDX-License-Identifier: Apache-2.0
// Requests of keyframes, sorted by what a Vulkan device makes together. Pure.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "sea/basics/field.h"
#include "sea/waves/realization.h"
#include "server/device/synthesizer.h"
#include "server/device/vulkan_fields.h"

namespace seaway::server {

inline constexpr sea::FieldSet strain_fields{sea::Field::strain_xx, sea::Field::strain_yy,
                                             sea::Field::strain_xy};

/// Requests that one series of dispatches can serve.
struct RequestBatch {
    int size;
    sea::FieldSet fields;
    bool looks; ///< foam does, at strains
    std::vector<std::size_t> requests;

    bool jacobian() const { return fields.contains(sea::Field::jacobian); }
    /// By transforms.
    sea::FieldSet computed() const {
        const sea::FieldSet linear = fields & sea::linear_fields;
        return jacobian() || looks ? linear | strain_fields : linear;
    }
    /// `apart`: as pack() takes it.
    Packing packing(std::size_t apart = 0) const { return pack(computed(), fields, apart); }
};

/// In an order in which turns of one foam map are taken as they were asked for.
std::vector<RequestBatch> sort_requests(std::span<const KeyframeRequest> requests,
                                        const sea::Realization& sea);

} // namespace seaway::server
