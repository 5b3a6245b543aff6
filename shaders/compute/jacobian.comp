#version 460
#extension GL_GOOGLE_include_directive : require
// SPDX-License-Identifier: Apache-2.0
// J = (1 + lx Dxx)(1 + ly Dyy) - lx ly Dxy^2 of one cascade, four points an invocation.
#include "shared/synthesis.h"

layout(local_size_x = synthesis_workgroup) in;
layout(binding = 0) uniform samplerBuffer maps; // [job][field][y][x / 4]
layout(binding = 1, std430) writeonly buffer Jacobian {
    vec4 jacobian[]; // [job][y][x / 4]
};
layout(push_constant) uniform Push {
    JacobianPush push;
};

vec4 four_points(uint plane, uint job, uint quad) {
    uint quads = push.size * push.size / 4u;
    return texelFetch(maps, int((job * push.fields + plane) * quads + quad));
}

void main() {
    uint quads = push.size * push.size / 4u;
    uint quad = gl_GlobalInvocationID.x;
    uint job = gl_GlobalInvocationID.z;
    vec4 xx = push.choppiness_x * four_points(push.plane_xx, job, quad);
    vec4 yy = push.choppiness_y * four_points(push.plane_yy, job, quad);
    vec4 xy = four_points(push.plane_xy, job, quad);
    jacobian[job * quads + quad] =
        (1.0 + xx) * (1.0 + yy) - push.choppiness_x * push.choppiness_y * xy * xy;
}
