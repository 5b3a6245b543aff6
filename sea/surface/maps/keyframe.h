// SPDX-License-Identifier: Apache-2.0
// Keyframe: the maps of one cascade at one sea time. The central word of Seaway: tiles are encoded
// keyframes, and queries and renderers interpolate between two of them. Immutable once built.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "base/check.h"
#include "sea/basics/field.h"
#include "sea/basics/time.h"
#include "sea/surface/maps/map_values.h"

namespace seaway::sea {

/// A map whose samples were rounded to whole steps where they were computed.
struct RoundedMap {
    Field field = Field::height;
    float step = 0;  ///< in the field's unit; its products with integers below 4096 are exact
    float error = 0; ///< no sample is further from what was computed
    /// [y][x]: values are these times the step. Empty: something has been added to the values since.
    std::vector<std::int16_t> steps;
};

struct Keyframe {
    std::uint32_t epoch = 0; ///< sea state that it belongs to
    int cascade = 0;
    TimeUs time_us = 0;
    int size = 0;          ///< grid points a side
    double length_m = 0;   ///< side of the tile
    FieldSet fields;       ///< what `values` holds
    MapValues values;      ///< [field in table order][y][x]; point (x,y) is at (x,y)*length/size
    bool stylised = false; ///< some of its waves are no modes, and move nothing sideways

    std::vector<RoundedMap> rounded; ///< those fields of which that is so

    /// Null: its samples are what was computed.
    const RoundedMap* rounded_map(Field field) const {
        for (const RoundedMap& map : rounded)
            if (map.field == field)
                return &map;
        return nullptr;
    }
    std::size_t bytes() const {
        std::size_t bytes = values.size() * sizeof(float);
        for (const RoundedMap& map : rounded)
            bytes += map.steps.size() * sizeof(std::int16_t);
        return bytes;
    }
    /// Something is about to be added to the values of these fields.
    void forget_steps(FieldSet changed) {
        for (RoundedMap& map : rounded)
            if (changed.contains(map.field))
                map.steps = {};
    }

    std::size_t plane_size() const {
        return static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
    }
    /// One field, [y][x].
    std::span<const float> plane(Field field) const {
        SEAWAY_CHECK(fields.contains(field), "keyframe does not hold this field");
        const auto index = static_cast<std::size_t>(fields.index_of(field));
        return std::span<const float>(values.data(), values.size())
            .subspan(index * plane_size(), plane_size());
    }
    std::span<float> plane(Field field) {
        const std::span<const float> plane = std::as_const(*this).plane(field);
        return {const_cast<float*>(plane.data()), plane.size()};
    }
};

/// One field of a keyframe of the same size, to another that has it, too.
inline void copy_map(const Keyframe& from, Field field, Keyframe& to) {
    std::ranges::copy(from.plane(field), to.plane(field).begin());
    std::erase_if(to.rounded, [&](const RoundedMap& map) { return map.field == field; });
    if (const RoundedMap* map = from.rounded_map(field))
        to.rounded.push_back(*map);
}

using KeyframePtr = std::shared_ptr<const Keyframe>;

} // namespace seaway::sea
