#version 460
// SPDX-License-Identifier: Apache-2.0
// Two keyframes of every cascade become the sea of this moment: coefficients of its splines, mixed as the
// cubic through values and rates at both ends says, and foam beside them, linear in time.
#extension GL_GOOGLE_include_directive : require
#include "view/flat.glsl"
#include "view/frame.glsl"

layout(local_size_x = view_group) in;
/// Of one cascade: [slot] coefficients [y + 1][x + 1][8] as in sea/surface/maps/spline_map.h, then [slot] foam [y][x].
layout(binding = 1) uniform samplerBuffer keyframes;
/// Level 0 of each cascade, [y][x]: Dx, Dy, eta, foam / its mean.
layout(std430, binding = 2) writeonly buffer DisplacementMaps { vec4 displacements[]; };

layout(push_constant) uniform Push { int cascade; };

const int border = 3;

/// A point is two texels: values and their rates.
vec3 mixed(int from, vec2 weights) {
    return weights.x * texelFetch(keyframes, from).xyz + weights.y * texelFetch(keyframes, from + 1).xyz;
}

float foam_at(int first, int n) { return texelFetch(keyframes, first + n / 4)[n % 4]; }

void main() {
    const ViewCascade tile = view.cascade[cascade];
    const int n = flat_invocation();
    if (n >= tile.points * tile.points)
        return;
    const int x = n % tile.points;
    const int y = n / tile.points;
    const int at = ((y + 1) * (tile.points + border) + x + 1) * 2;
    const vec3 height_first = mixed(tile.before_first + at, tile.hermite.xy) +
                              mixed(tile.after_first + at, tile.hermite.zw);
    float foam = 1.0; // a cascade without foam is average everywhere
    if (tile.foam_share >= 0.0)
        foam = mix(foam_at(tile.foam_before_first, n), foam_at(tile.foam_after_first, n), tile.foam_share);
    displacements[tile.displacement_first + n] = vec4(height_first.yzx, foam);
}
