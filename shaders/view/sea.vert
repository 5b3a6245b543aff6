#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require
#include "view/bindings.glsl"

layout(location = 0) centroid out vec4 place; // packed
/// Of the triangle's first vertex: the same, and how far the distances of the others may be from its.
layout(location = 1) flat out vec4 corner;
layout(location = 2) flat out float reach_m;

void main() {
    const vec4 position_m = texelFetch(vertices, 2 * gl_VertexIndex);
    place = texelFetch(vertices, 2 * gl_VertexIndex + 1);
    corner = place;
    // A cell and what waves move its corners by.
    reach_m = 3.0 * position_m.w + 2.0 * view.reach_m;
    gl_Position = view.clip_from_local * vec4(position_m.xyz, 1);
}
