// SPDX-License-Identifier: Apache-2.0
#include "server/device/vulkan_parts.h"

#include <algorithm>

namespace seaway::server {

namespace {

constexpr sea::FieldSet derived{sea::Field::jacobian, sea::Field::foam};

/// Maps of a run: those that were asked for, and what they are made of.
int maps_of(const KeyframeRequest& request) {
    const bool of_strains = request.fields.contains(sea::Field::jacobian) ||
                            (request.foam != nullptr && request.foam->looks(request.fields));
    return (of_strains ? request.fields | sea::strain_fields : request.fields).size();
}

} // namespace

std::vector<KeyframeRequest> parts_of(const KeyframeRequest& request, int maps_at_once) {
    if (maps_of(request) <= maps_at_once)
        return {request};
    KeyframeRequest first = request;
    first.fields = request.fields & (derived | sea::strain_fields);
    first.rounding = {};
    std::vector<KeyframeRequest> parts{first};
    KeyframeRequest next = request;
    next.foam = nullptr;
    next.rounding = {};
    next.fields = {};
    for (const sea::Field field : request.fields) {
        if (first.fields.contains(field))
            continue;
        if (next.fields.size() == maps_at_once) {
            parts.push_back(next);
            next.fields = {};
        }
        next.fields |= sea::FieldSet{field};
    }
    parts.push_back(next);
    return parts;
}

void join(std::span<const NewKeyframePtr> parts, sea::Keyframe& whole) {
    for (const NewKeyframePtr& part : parts)
        for (const sea::Field field : part->fields)
            std::ranges::copy(part->plane(field), whole.plane(field).begin());
}

} // namespace seaway::server
