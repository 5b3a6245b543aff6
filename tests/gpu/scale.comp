#version 460
// SPDX-License-Identifier: Apache-2.0
// result[i] = factor * source[i] + offset
layout(local_size_x = 64) in;
layout(binding = 0) uniform samplerBuffer source;
layout(binding = 1, std430) writeonly buffer Result {
    vec4 result[];
};
layout(push_constant) uniform Push {
    vec4 offset;
    float factor;
    uint count;
};
void main() {
    if (gl_GlobalInvocationID.x < count)
        result[gl_GlobalInvocationID.x] =
            factor * texelFetch(source, int(gl_GlobalInvocationID.x)) + offset;
}
