// SPDX-License-Identifier: Apache-2.0
#include "sea/surface/sine_maps.h"

namespace seaway::sea {

void add_sines(const SineField& field, TimeUs phase_time, Keyframe& keyframe) {
    const double spacing = keyframe.length_m / keyframe.size;
    for (int iy = 0; iy < keyframe.size; ++iy)
        for (int ix = 0; ix < keyframe.size; ++ix) {
            const LagrangianPoint point = sines_at(field, ix * spacing, iy * spacing, phase_time);
            const auto node = static_cast<std::size_t>(iy * keyframe.size + ix);
            for (const Field f : keyframe.fields& linear_fields)
                keyframe.plane(f)[node] += static_cast<float>(value_of(point, f));
        }
}

} // namespace seaway::sea
