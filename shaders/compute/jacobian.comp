#version 460
#extension GL_GOOGLE_include_directive : require
// SPDX-License-Identifier: Apache-2.0
// J = (1 + lx Dxx)(1 + ly Dyy) - lx ly Dxy^2 of one cascade, four points an invocation.
#include "shared/synthesis.h"

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
    vec4 xx = push.choppiness_x * texelFetch(maps, int(place(push.map_xx, quad)));
    vec4 yy = push.choppiness_y * texelFetch(maps, int(place(push.map_yy, quad)));
    vec4 xy = texelFetch(maps, int(place(push.map_xy, quad)));
    target[place(push.map_jacobian, quad)] =
        (1.0 + xx) * (1.0 + yy) - push.choppiness_x * push.choppiness_y * xy * xy;
}
