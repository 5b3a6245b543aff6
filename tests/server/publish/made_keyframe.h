// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "sea/surface/maps/keyframe.h"

namespace seaway::server {

/// Some waves in every field.
inline sea::Keyframe keyframe(int size, sea::FieldSet fields, int cascade = 0,
                              sea::TimeUs time_us = 0) {
    sea::Keyframe made;
    made.cascade = cascade;
    made.time_us = time_us;
    made.size = size;
    made.length_m = 100;
    made.fields = fields;
    made.values.resize(made.plane_size() * static_cast<std::size_t>(fields.size()));
    for (std::size_t i = 0; i < made.values.size(); ++i)
        made.values[i] = static_cast<float>(
            std::sin(0.01 * static_cast<double>(i) + static_cast<double>(time_us)));
    return made;
}

} // namespace seaway::server
