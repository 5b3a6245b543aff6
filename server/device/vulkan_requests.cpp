// SPDX-License-Identifier: Apache-2.0
#include "server/device/vulkan_requests.h"

#include <algorithm>
#include <bit>

#include "base/check.h"
#include "gpu/call.h"
#include "server/device/vulkan_foam.h"
#include "shaders/shared/synthesis.h"

namespace seaway::server {

std::vector<RequestBatch> sort_requests(std::span<const KeyframeRequest> requests,
                                        const sea::Realization& sea, bool rounds) {
    std::vector<RequestBatch> batches;
    for (std::size_t i = 0; i < requests.size(); ++i) {
        const KeyframeRequest& request = requests[i];
        const RequestBatch alone{sea.cascades[static_cast<std::size_t>(request.cascade)].spec.size,
                                 request.fields,
                                 request.foam != nullptr && request.foam->looks(request.fields),
                                 rounds && !request.rounding.empty() && !request.fields.empty(),
                                 {i}};
        const auto alike = [&](const RequestBatch& batch) {
            return batch.size == alone.size && batch.fields == alone.fields &&
                   batch.looks == alone.looks && batch.rounds == alone.rounds;
        };
        // The latest that will do, and none before one that holds a turn of the same foam map.
        const auto same =
            std::find_if(batches.rbegin(), batches.rend(), [&](const RequestBatch& batch) {
                return alike(batch) || has_turn_of(batch.requests, requests, request.foam);
            });
        if (same != batches.rend() && alike(*same))
            same->requests.push_back(i);
        else
            batches.push_back(alone);
    }
    return batches;
}

std::vector<sea::RoundedMap> rounded_maps(const KeyframeRequest& request) {
    SEAWAY_CHECK(request.rounding.size() == static_cast<std::size_t>(request.fields.size()),
                 "how far each field may be off");
    // Half a step, and what single precision makes of it: the scale, the product with it and the decoded product are each
    // rounded, by a 2^24th of up to 32767 steps.
    constexpr double error_steps = 0.5 + 3.0 * shaders::rounded_steps_max / 0x1p24;
    std::vector<sea::RoundedMap> maps;
    std::size_t place = 0;
    for (const sea::Field field : request.fields) {
        const float error = request.rounding[place++];
        SEAWAY_CHECK(error > 0, "a field is rounded by something");
        if (field == sea::Field::foam && request.foam == nullptr)
            continue;
        // Twelve bits of the step are none, so that its products with twelve more are exact.
        const auto bits = std::bit_cast<std::uint32_t>(
            static_cast<float>(static_cast<double>(error) / error_steps));
        maps.push_back({field, std::bit_cast<float>(bits & ~0xfffu), error, {}});
    }
    return maps;
}

Error refused_for_now(const Error& error) {
    return gpu::is_out_of_memory(error) ? Error{DeviceError::out_of_memory, error.message} : error;
}

std::optional<VulkanBatch::Rounding> rounding_of(const RequestBatch& batch, const Packing& packing,
                                                 std::span<const KeyframeRequest> requests,
                                                 std::span<const std::size_t> indices) {
    if (!batch.rounds)
        return std::nullopt;
    VulkanBatch::Rounding rounding{batch.fields.size(), {}};
    for (const std::size_t index : indices) {
        const std::size_t first = rounding.scales.size();
        rounding.scales.resize(first + static_cast<std::size_t>(rounding.asked), 0.0f);
        for (const sea::RoundedMap& map : rounded_maps(requests[index]))
            rounding.scales[first + static_cast<std::size_t>(packing.map_of(map.field))] =
                1.0f / map.step;
    }
    return rounding;
}

} // namespace seaway::server
