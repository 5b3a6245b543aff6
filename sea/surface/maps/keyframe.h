// SPDX-License-Identifier: Apache-2.0
// Keyframe: the maps of one cascade at one sea time. The central word of Seaway: tiles are encoded
// keyframes, and queries and renderers interpolate between two of them. Immutable once built.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <utility>

#include "base/check.h"
#include "sea/basics/field.h"
#include "sea/basics/time.h"
#include "sea/surface/maps/map_values.h"

namespace seaway::sea {

struct Keyframe {
    std::uint32_t epoch = 0; ///< sea state that it belongs to
    int cascade = 0;
    TimeUs time_us = 0;
    int size = 0;        ///< grid points a side
    double length_m = 0; ///< side of the tile
    FieldSet fields;     ///< what `values` holds
    MapValues values;    ///< [field in table order][y][x]; point (x,y) is at (x,y)*length/size

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

using KeyframePtr = std::shared_ptr<const Keyframe>;

} // namespace seaway::sea
