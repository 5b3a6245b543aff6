// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/sine_maps.h"

namespace seaway::sea {

namespace {

double value_of(const LagrangianPoint& point, Field field) {
    switch (field) {
    case Field::height:
        return point.height;
    case Field::height_rate:
        return point.height_rate;
    case Field::slope_x:
        return point.slope_x;
    case Field::slope_y:
        return point.slope_y;
    default:
        return 0.0; // stylised waves move up and down only
    }
}

} // namespace

void add_sines(const SineField& field, TimeUs phase_time, Keyframe& keyframe) {
    const double spacing = keyframe.length_m / keyframe.size;
    for (int iy = 0; iy < keyframe.size; ++iy)
        for (int ix = 0; ix < keyframe.size; ++ix) {
            const LagrangianPoint point = sines_at(field, ix * spacing, iy * spacing, phase_time);
            const auto node = static_cast<std::size_t>(iy * keyframe.size + ix);
            for (const Field f : keyframe.fields)
                keyframe.plane(f)[node] += static_cast<float>(value_of(point, f));
        }
}

} // namespace seaway::sea
