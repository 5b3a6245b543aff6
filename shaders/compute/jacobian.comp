#version 460
#extension GL_GOOGLE_include_directive : require
// SPDX-License-Identifier: Apache-2.0
// The Jacobian of one cascade, four points an invocation, where no foam looks at its strains (compute/foam.comp).
#include "shared/synthesis.h"
#include "compute/jacobian.glsl"

layout(local_size_x = synthesis_workgroup) in;
layout(binding = 0) uniform samplerBuffer maps; // [map][y][x / 4]
layout(binding = 1, std430) writeonly buffer Target {
    vec4 target[]; // the same
};
layout(push_constant) uniform Push {
    JacobianPush push;
};

uint place(uint map, uint quad) {
    return (push.first_map + gl_GlobalInvocationID.z * push.maps + map) *
               (push.size * push.size / 4u) + quad;
}

void main() {
    uint quad = gl_GlobalInvocationID.x;
    target[place(push.map_jacobian, quad)] =
        jacobian_of(push.choppiness_x, push.choppiness_y, texelFetch(maps, int(place(push.map_xx, quad))),
                    texelFetch(maps, int(place(push.map_yy, quad))),
                    texelFetch(maps, int(place(push.map_xy, quad))));
}
