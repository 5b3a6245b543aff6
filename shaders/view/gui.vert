#version 460
// SPDX-License-Identifier: Apache-2.0
// Triangles of the window's panels: places in points of the window, colours of 4 bytes.

/// [vertex]: x, y, u, v as floats, then the colour.
layout(std430, binding = 0) readonly buffer Vertices { uint words[]; };
layout(std140, binding = 1) uniform Pane {
    vec2 scale; // of points to -1 .. 1
    vec2 offset;
    int encodes; // 1: the image makes sRGB of what is written
} pane;

layout(location = 0) out vec2 place;
layout(location = 1) out vec4 colour;

void main() {
    const int first = 5 * gl_VertexIndex;
    const vec2 at = vec2(uintBitsToFloat(words[first]), uintBitsToFloat(words[first + 1]));
    place = vec2(uintBitsToFloat(words[first + 2]), uintBitsToFloat(words[first + 3]));
    colour = unpackUnorm4x8(words[first + 4]);
    gl_Position = vec4(at * pane.scale + pane.offset, 0, 1);
}
