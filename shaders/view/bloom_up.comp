#version 460
// SPDX-License-Identifier: Apache-2.0
// A level of bloom takes its share from the coarser ones: linear between their texels, (3 1), after a tent over them, (1 2 1).
// Without the tent the spot that the sun makes, whose edge is seen, is a square.
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
    // Of four coarse texels a side, the second (third) is the one that a finer one of even (odd) number lies in, off its middle.
    const ivec2 odd = at & 1;
    const ivec2 low = at / 2 - 2 + odd;
    const vec4 even_weight = vec4(1, 5, 7, 3) / 16.0;
    const vec4 x_weight = odd.x == 0 ? even_weight : even_weight.wzyx;
    const vec4 y_weight = odd.y == 0 ? even_weight : even_weight.wzyx;
    vec3 coarse = vec3(0);
    for (int y = 0; y < 4; ++y) {
        const int row = push.from.first + clamp(low.y + y, 0, last.y) * push.from.columns;
        for (int x = 0; x < 4; ++x)
            coarse += x_weight[x] * y_weight[y] * texelFetch(levels, row + clamp(low.x + x, 0, last.x)).rgb;
    }
    spread[push.to.first + n] = vec4(mix(texelFetch(levels, push.to.first + n).rgb, coarse, push.share), 1);
}
