#version 460
// SPDX-License-Identifier: Apache-2.0
// A plume as a streak along its way that faces the eye.
#extension GL_GOOGLE_include_directive : require
#include "view/frame.glsl"

/// [plume][2]: local position, radius; velocity, opacity.
layout(binding = 1) uniform samplerBuffer plumes;

layout(location = 0) out vec2 within;        // -1 .. 1
layout(location = 1) out vec3 from_eye_m;
layout(location = 2) flat out vec3 look;     // opacity, radius, a number of its own

const float drawn_out = 6.0; // length of a streak over its width

void main() {
    const int plume = gl_VertexIndex / 6;
    const int corner = gl_VertexIndex % 6;
    const vec4 place = texelFetch(plumes, 2 * plume);
    const vec4 way = texelFetch(plumes, 2 * plume + 1);
    within = vec2(corner == 1 || corner == 2 || corner == 4 ? 1.0 : -1.0,
                  corner == 2 || corner == 4 || corner == 5 ? 1.0 : -1.0);
    look = vec3(way.w, place.w, float(plume % 61));
    const vec3 to_eye = normalize(view.camera_m - place.xyz);
    const vec3 along = normalize(way.xyz + vec3(1e-4, 0, 0));
    const vec3 seen = along - dot(along, to_eye) * to_eye; // across the line of sight
    const float aslant = length(seen);
    const vec3 axis = aslant > 0.05 ? seen / aslant : normalize(cross(to_eye, vec3(0, 0, 1)) + vec3(1e-4, 0, 0));
    const vec3 other = cross(to_eye, axis);
    const vec3 at = place.xyz + place.w * (within.x * mix(1.0, drawn_out, aslant) * axis + within.y * other);
    from_eye_m = at - view.camera_m;
    // What is not seen has no area.
    gl_Position = way.w > 0.004 ? view.clip_from_local * vec4(at, 1) : vec4(2, 2, 0, 1);
}
