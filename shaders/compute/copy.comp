#version 460
#extension GL_GOOGLE_include_directive : require
// SPDX-License-Identifier: Apache-2.0
// A copy of one buffer to another, as synthesis kernels read and write: what memory gives at best (seaway-bench device).
#include "shared/synthesis.h"

layout(local_size_x = synthesis_workgroup) in;
layout(binding = 0) uniform samplerBuffer source;
layout(binding = 1, std430) writeonly buffer Target {
    vec4 target[];
};

void main() {
    const uint row = gl_NumWorkGroups.x * uint(synthesis_workgroup);
    const uint n = gl_GlobalInvocationID.y * row + gl_GlobalInvocationID.x;
    target[n] = texelFetch(source, int(n));
}
