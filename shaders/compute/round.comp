#version 460
#extension GL_GOOGLE_include_directive : require
// SPDX-License-Identifier: Apache-2.0
// Maps as whole steps of 16 bits, eight points an invocation, a map a y, a job a z: half of what they take as floats.
#include "shared/synthesis.h"

layout(local_size_x = synthesis_workgroup) in;
layout(binding = 0) uniform samplerBuffer maps;   // [map][y][x / 4]
layout(binding = 1) uniform samplerBuffer scales; // [job][map]: steps in one unit; 0: of this map there is nothing to say
layout(binding = 2, std430) writeonly buffer Rounded {
    uint overflows[rounded_maps_max]; // [job][map]: 1 where 16 bits are too few, else left as it is
    uvec4 words[];                    // [job][map][y][x / 8]: neighbours in halves, the first one lower
};
layout(push_constant) uniform Push {
    RoundPush push;
};

uvec2 halves(vec4 steps) {
    ivec4 whole = ivec4(steps);
    return uvec2(whole.xz & 0xffff) | uvec2(whole.yw << 16);
}

void main() {
    uint points = push.size * push.size;
    uint row = gl_WorkGroupID.z * push.asked + gl_WorkGroupID.y;
    uint eight = gl_GlobalInvocationID.x;
    int quad = int((push.first_map + gl_WorkGroupID.z * push.maps + gl_WorkGroupID.y) * (points / 4u) +
                   2u * eight);
    float scale = texelFetch(scales, int(row)).x;
    vec4 a = vec4(0.0), b = vec4(0.0);
    if (scale != 0.0) {
        a = roundEven(texelFetch(maps, quad) * scale);
        b = roundEven(texelFetch(maps, quad + 1) * scale);
    }
    // Not a number is no less than anything.
    if (!(all(lessThanEqual(abs(a), vec4(rounded_steps_max))) &&
          all(lessThanEqual(abs(b), vec4(rounded_steps_max)))))
        overflows[row] = 1u;
    words[row * (points / 8u) + eight] = uvec4(halves(a), halves(b));
}
