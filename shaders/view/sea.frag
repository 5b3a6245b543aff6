#version 460
// SPDX-License-Identifier: Apache-2.0
#extension GL_GOOGLE_include_directive : require
#include "view/bindings.glsl"

layout(location = 0) centroid in vec4 place;
layout(location = 1) flat in vec4 corner;
layout(location = 2) flat in float reach_m;
layout(location = 0) out vec4 shown; // packed

void main() {
    // Of a triangle that is seen from its edge - the last cells before the horizon, the back of a crest -
    // the plane through its corners may be extrapolated to anywhere, behind the eye as well. What is
    // not within the triangle is not what this pixel shows; its corner is.
    const float distance_m = unpacked_place(place).distance_m;
    const float beyond_m = distance_m - unpacked_place(corner).distance_m;
    shown = distance_m > 0.0 && abs(beyond_m) <= reach_m ? place : corner;
}
