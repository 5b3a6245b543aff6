#version 460
// SPDX-License-Identifier: Apache-2.0
// The finest level of bloom: means of the picture. Half as large by a quadratic spline (1 3 3 1), a quarter as large
// by means of 4 x 4, which are cheaper.
#extension GL_GOOGLE_include_directive : require
#include "shared/view.h"
#include "view/bloom.glsl"
#include "view/flat.glsl"

layout(local_size_x = view_group) in;
layout(binding = 0) uniform sampler2D picture;
layout(std430, binding = 1) writeonly buffer Spread { vec4 spread[]; };

void main() {
    const int n = flat_invocation();
    ivec2 at;
    if (!place_of(n, at))
        return;
    const ivec2 last = textureSize(picture, 0) - 1;
    const vec4 weight = push.pixels == 2 ? vec4(1, 3, 3, 1) / 8.0 : vec4(0.25);
    const ivec2 low = push.pixels * at - (push.pixels == 2 ? 1 : 0);
    vec3 sum = vec3(0);
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x)
            sum += weight[x] * weight[y] * texelFetch(picture, clamp(low + ivec2(x, y), ivec2(0), last), 0).rgb;
    spread[push.to.first + n] = vec4(sum, 1);
}
