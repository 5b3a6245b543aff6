// SPDX-License-Identifier: Apache-2.0
#include "server/device/vulkan_requests.h"

#include <algorithm>

#include "server/device/vulkan_foam.h"

namespace seaway::server {

std::vector<RequestBatch> sort_requests(std::span<const KeyframeRequest> requests,
                                        const sea::Realization& sea) {
    std::vector<RequestBatch> batches;
    for (std::size_t i = 0; i < requests.size(); ++i) {
        const KeyframeRequest& request = requests[i];
        const int size = sea.cascades[static_cast<std::size_t>(request.cascade)].spec.size;
        const bool looks = request.foam != nullptr && request.foam->looks(request.fields);
        const sea::FieldSet fields = request.fields;
        // The latest that will do, and none before one that holds a turn of the same foam map.
        const auto same =
            std::find_if(batches.rbegin(), batches.rend(), [&](const RequestBatch& batch) {
                return (batch.size == size && batch.fields == fields && batch.looks == looks) ||
                       has_turn_of(batch.requests, requests, request.foam);
            });
        if (same != batches.rend() && same->size == size && same->fields == fields &&
            same->looks == looks)
            same->requests.push_back(i);
        else
            batches.push_back({size, fields, looks, {i}});
    }
    return batches;
}

} // namespace seaway::server
