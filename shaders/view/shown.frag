#version 460
// SPDX-License-Identifier: Apache-2.0
// The picture as it is shown: light becomes sRGB bytes, and pixels drawn become pixels of the screen.
#extension GL_GOOGLE_include_directive : require
#include "view/frame.glsl"

layout(binding = 1) uniform sampler2D picture;
layout(location = 0) out vec4 shown;

#ifdef SEAWAY_BLOOM
/// [y][x]: the light around, client/view/bloom.h.
layout(binding = 2) uniform samplerBuffer spread;

/// Linear between texels.
vec3 spread_at(vec2 shown_pixel) {
    const ivec2 last = ivec2(view.bloom_columns, view.bloom_lines) - 1;
    const vec2 at = shown_pixel * view.bloom_per_shown - 0.5;
    const ivec2 low = ivec2(floor(at));
    const vec2 t = at - vec2(low);
    const ivec4 around = clamp(ivec4(low, low + 1), ivec4(0), last.xyxy);
    const ivec2 row = around.yw * view.bloom_columns;
    return mix(mix(texelFetch(spread, row.x + around.x).rgb, texelFetch(spread, row.x + around.z).rgb, t.x),
               mix(texelFetch(spread, row.y + around.x).rgb, texelFetch(spread, row.y + around.z).rgb, t.x), t.y);
}
#endif

vec3 srgb(vec3 linear) {
    linear = clamp(linear, 0.0, 1.0);
    return mix(12.92 * linear, 1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055,
               greaterThan(linear, vec3(0.0031308)));
}

/// ACES reference rendering and sRGB output transform, the fit by Stephen Hill (BakingLab, MIT).
vec3 film(vec3 linear) {
    const mat3 into = mat3(0.59719, 0.07600, 0.02840, 0.35458, 0.90834, 0.13383, 0.04823, 0.01566, 0.83777);
    const mat3 back = mat3(1.60475, -0.10208, -0.00327, -0.53108, 1.10813, -0.07276, -0.07367, -0.00605, 1.07602);
    const vec3 v = into * linear;
    return back * ((v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081));
}

/// Above white the brightest channel counts by its logarithm, and the others keep their share of it: from white to the sun's
/// disc, a hundred thousand times as bright, nothing is flat, and what is yellow stays yellow.
vec3 shoulder(vec3 linear) {
    const float brightest = max(max(linear.r, linear.g), linear.b);
    // A loop, not a branch: see gradients.glsl.
    for (int once = 0; once < int(brightest > 1.0); ++once)
        linear *= (1.0 + log(brightest)) / brightest;
    return linear;
}

/// Noise of a byte's step, so that slow gradients have no bands: interleaved gradient noise (Jimenez 2014).
vec3 dither(ivec2 pixel) {
    const float noise = fract(52.9829189 * fract(dot(vec2(pixel), vec2(0.06711056, 0.00583715))));
    return vec3((noise - 0.5) / 255.0);
}

void main() {
    // The sampler repeats: half a texel at the border would be of the opposite one.
    const vec2 size = vec2(textureSize(picture, 0));
    const vec2 at = clamp(gl_FragCoord.xy * view.picture_per_shown, vec2(0.5), size - 0.5);
    vec3 v = view.picture_per_shown.x == 1.0
                 ? texelFetch(picture, ivec2(gl_FragCoord.xy), 0).rgb
                 : textureLod(picture, at / size, 0.0).rgb;
#ifdef SEAWAY_BLOOM
    v = mix(v, spread_at(gl_FragCoord.xy), view.bloom);
#endif
    v = srgb(film(shoulder(view.exposure * v))) + dither(ivec2(gl_FragCoord.xy));
    shown = vec4(v, 1);
}
