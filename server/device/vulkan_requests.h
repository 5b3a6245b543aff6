// SPDX-License-Identifier: Apache-2.0
// Requests of keyframes, sorted by what a Vulkan device makes together. Pure.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "sea/basics/field.h"
#include "sea/waves/realization.h"
#include "server/device/synthesizer.h"
#include "server/device/vulkan_batch.h"
#include "server/device/vulkan_fields.h"

namespace seaway::server {

/// Requests that one series of dispatches can serve.
struct RequestBatch {
    int size;
    sea::FieldSet fields;
    bool looks;  ///< foam does, at strains
    bool rounds; ///< maps are to travel as whole steps
    std::vector<std::size_t> requests;

    bool jacobian() const { return fields.contains(sea::Field::jacobian); }
    /// By transforms.
    sea::FieldSet computed() const {
        const sea::FieldSet linear = fields & sea::linear_fields;
        return jacobian() || looks ? linear | sea::strain_fields : linear;
    }
    /// `apart`: as pack() takes it.
    Packing packing(std::size_t apart = 0) const { return pack(computed(), fields, apart); }
};

/// In an order in which turns of one foam map are taken as they were asked for. `rounds`: those that may be are.
std::vector<RequestBatch> sort_requests(std::span<const KeyframeRequest> requests,
                                        const sea::Realization& sea, bool rounds);

/// What the maps of a request are rounded to: a row a field, with its step and its error, and without steps. Foam that is
/// the caller's to fill (KeyframeRequest) has none.
std::vector<sea::RoundedMap> rounded_maps(const KeyframeRequest& request);

/// An error for want of the device's memory as one of DeviceError::out_of_memory: the device is there, and has some for others. Others
/// as they are.
Error refused_for_now(const Error& error);

/// What the kernel is told of requests of a batch; none: it does not round.
std::optional<VulkanBatch::Rounding> rounding_of(const RequestBatch& batch, const Packing& packing,
                                                 std::span<const KeyframeRequest> requests,
                                                 std::span<const std::size_t> indices);

} // namespace seaway::server
