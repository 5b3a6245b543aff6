#version 460
// SPDX-License-Identifier: Apache-2.0
// The picture of an eye under water. Each sample is lit where a crest's edge runs through a pixel.
#extension GL_GOOGLE_include_directive : require
#include "view/bindings.glsl"
#include "view/gradients.glsl"
#include "view/sky.glsl"
#include "view/foam.glsl"
#include "view/water.glsl"
#include "view/under_water.glsl"

layout(location = 0) in vec3 direction;
layout(location = 0) out vec4 radiance;

void main() {
    const vec3 away = normalize(direction);
    const ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 mean = vec4(0);
    vec2 span = vec2(1e9, 0);
    for (int i = 0; i < samples; ++i) {
        const vec4 texel = texelFetch(geometry, pixel, i);
        mean += texel / float(samples);
        const float distance_m = unpacked_place(texel).distance_m;
        span = vec2(min(span.x, distance_m), max(span.y, distance_m));
    }
    const bool edge = span.y > 1.2 * span.x;
    vec3 sum = vec3(0);
    const int count = edge ? samples : 1;
    for (int i = 0; i < count; ++i)
        sum += under_water(unpacked_place(edge ? texelFetch(geometry, pixel, i) : mean), away);
    radiance = vec4(sum / float(count), 1);
}
