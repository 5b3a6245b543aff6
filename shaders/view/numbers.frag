#version 460
// SPDX-License-Identifier: Apache-2.0
// Numbers of a debug view as they are shown: each on its place of the view's bar (client/view/debug/colours.h).
#extension GL_GOOGLE_include_directive : require
#include "view/frame.glsl"

layout(binding = 1) uniform sampler2D picture;
layout(location = 0) out vec4 shown;

float place_on_bar(float number) {
    const float share = (number - view.debug.low) / (view.debug.high - view.debug.low);
    float at = share;
    switch (view.debug.spacing) {
    case view_spacing_logarithmic:
        at = number > 0.0 ? log(number / view.debug.low) / log(view.debug.high / view.debug.low) : 0.0;
        break;
    case view_spacing_root:
        at = sqrt(max(share, 0.0));
        break;
    case view_spacing_repeated:
        at = fract(share);
        break;
    }
    at = clamp(at, 0.0, 1.0);
    return view.debug.flip == 1 ? 1.0 - at : at;
}

vec3 colour_of(float number) {
    const float at = place_on_bar(number);
    vec3 colour = view.debug.stop[0].rgb;
    for (int i = 1; i < view.debug.stops; ++i) {
        const vec4 before = view.debug.stop[i - 1];
        const vec4 after = view.debug.stop[i];
        colour = mix(colour, after.rgb, clamp((at - before.w) / (after.w - before.w), 0.0, 1.0));
    }
    return number < view.debug.fold_below ? view.debug.fold.rgb : colour;
}

void main() {
    const ivec2 size = textureSize(picture, 0);
    // Numbers of neighbours are not mixed: between a crest and the sea behind it there is nothing.
    const ivec2 pixel = min(ivec2(gl_FragCoord.xy * view.picture_per_shown), size - 1);
    const vec4 v = texelFetch(picture, pixel, 0);
    const int channel = view.debug.channel;
    vec3 colour = channel < 0 ? vec3(place_on_bar(v.r), place_on_bar(v.g), place_on_bar(v.b)) : colour_of(v[channel]);
    if (any(isnan(v)))
        colour = vec3(1, 0, 1); // nobody's colour
    if (v.a > 1.5)
        colour = view.debug.fold.rgb;
    shown = vec4(v.a < 0.5 ? view.debug.empty.rgb : colour, 1);
}
