#version 460
// SPDX-License-Identifier: Apache-2.0
// The sea's light. With four samples a pixel, what one piece of sea fills is lit once; where a crest's edge or the horizon
// runs through it each sample is lit, as sky where there is no sea. With one sample sky.frag draws the sky.
#extension GL_GOOGLE_include_directive : require
#include "view/bindings.glsl"
#include "view/gradients.glsl"
#include "view/sky.glsl"
#include "view/foam.glsl"
#include "view/water.glsl"

layout(location = 0) in vec3 direction;
layout(location = 0) out vec4 radiance;

#ifdef SEAWAY_ONE_SAMPLE
void main() {
    const Place place = unpacked_place(texelFetch(geometry, ivec2(gl_FragCoord.xy), 0));
    radiance = vec4(water_radiance(place, -normalize(direction)), 1);
}
#else
void main() {
    const vec3 away = normalize(direction);
    const ivec2 pixel = ivec2(gl_FragCoord.xy);
    Place place[samples];
    vec4 mean = vec4(0);
    vec2 span = vec2(1e9, 0);
    for (int i = 0; i < samples; ++i) {
        const vec4 texel = texelFetch(geometry, pixel, i);
        mean += texel / float(samples);
        place[i] = unpacked_place(texel);
        span = vec2(min(span.x, place[i].distance_m), max(span.y, place[i].distance_m));
    }
    if (span.y == 0.0) {
        radiance = vec4(sky_behind(away), 1);
        return;
    }
    // What a level sea would span; more is an edge.
    const float level = span.x * span.x * view.pixel_rad / max(view.camera_m.z, 1.0);
    const bool edge = span.x == 0.0 || span.y - span.x > 2.0 * level + 1.0;
    vec3 sum = vec3(0);
    const int count = edge ? samples : 1;
    for (int i = 0; i < count; ++i) {
        const Place at = edge ? place[i] : unpacked_place(mean);
        sum += shows_sky(at) ? sky_behind(away) : water_radiance(at, -away);
    }
    radiance = vec4(sum / float(count), 1);
}
#endif
