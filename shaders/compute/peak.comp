#version 460
#extension GL_GOOGLE_include_directive : require
// SPDX-License-Identifier: Apache-2.0
// Fused products and sums in chains that wait for nothing: what arithmetic gives at best (seaway-bench device).
#include "shared/synthesis.h"

layout(local_size_x = synthesis_workgroup) in;
layout(binding = 0, std430) writeonly buffer Target {
    vec4 target[];
};
layout(push_constant) uniform Push {
    PeakPush push;
};

void main() {
    vec4 factor = vec4(push.factor), added = vec4(push.added);
    vec4 a = vec4(float(gl_GlobalInvocationID.x)), b = a + 1.0; // peak_chains: no more than an AVX2 machine has registers for
    for (uint n = 0u; n < push.rounds; ++n)
        for (uint i = 0u; i < peak_steps; ++i) { // so many in a row, that the loop does not count
            a = fma(a, factor, added);
            b = fma(b, factor, added);
        }
    target[gl_GlobalInvocationID.x] = a + b;
}
