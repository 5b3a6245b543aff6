#version 460
// SPDX-License-Identifier: Apache-2.0
// The next level of bloom, half as large: each texel a mean by a quadratic spline (1 3 3 1) of 4 x 4.
#extension GL_GOOGLE_include_directive : require
#include "shared/view.h"
#include "view/bloom.glsl"
#include "view/flat.glsl"

layout(local_size_x = view_group) in;
layout(binding = 0) uniform samplerBuffer levels;
layout(std430, binding = 1) writeonly buffer Spread { vec4 spread[]; };

void main() {
    const int n = flat_invocation();
    ivec2 at;
    if (!place_of(n, at))
        return;
    const ivec2 last = ivec2(push.from.columns, push.from.lines) - 1;
    const vec4 weight = vec4(1, 3, 3, 1) / 8.0;
    vec3 sum = vec3(0);
    for (int y = 0; y < 4; ++y) {
        const int row = push.from.first + clamp(2 * at.y + y - 1, 0, last.y) * push.from.columns;
        for (int x = 0; x < 4; ++x)
            sum += weight[x] * weight[y] * texelFetch(levels, row + clamp(2 * at.x + x - 1, 0, last.x)).rgb;
    }
    spread[push.to.first + n] = vec4(sum, 1);
}
