#version 460
// SPDX-License-Identifier: Apache-2.0
// Panels and the picture behind them: bytes of sRGB, which an image that encodes by itself is given as linear light.

layout(std140, binding = 1) uniform Pane {
    vec2 scale;
    vec2 offset;
    int encodes;
} pane;
layout(binding = 2) uniform sampler2D image;

layout(location = 0) in vec2 place;
layout(location = 1) in vec4 colour;
layout(location = 0) out vec4 shown;

vec3 linear_of(vec3 srgb) {
    return mix(srgb / 12.92, pow((srgb + 0.055) / 1.055, vec3(2.4)), greaterThan(srgb, vec3(0.04045)));
}

void main() {
    shown = colour * texture(image, place);
    if (pane.encodes == 1)
        shown.rgb = linear_of(shown.rgb);
}
