#version 460
// SPDX-License-Identifier: Apache-2.0
// Samples become coefficients of cubic splines, along one axis: the periodic prefilter of sea/surface/maps/spline_map.h as
// the convolution that it is, of sqrt(3) * pole^|j|. Foam, which is linear in space, stays.
#extension GL_GOOGLE_include_directive : require
#include "view/flat.glsl"
#include "view/frame.glsl"

layout(local_size_x = view_group) in;
/// Level 0 of each cascade, [y][x].
layout(binding = 1) uniform samplerBuffer samples;
layout(std430, binding = 2) writeonly buffer Coefficients { vec4 coefficients[]; };

layout(push_constant) uniform Push { int axis; }; // 0: x, 1: y

const float pole = -0.26794919243; // sqrt(3) - 2
const float gain = 1.73205080757;  // sqrt(3): all of it together is 1
const int memory = 13;             // 4e-8 is left

void main() {
    const ViewCascade tile = view.cascade[gl_WorkGroupID.z];
    const int n = flat_invocation();
    if (n >= tile.points * tile.points)
        return;
    const int mask = tile.points - 1; // a power of two
    const int stride = axis == 0 ? 1 : tile.points;
    const int at = axis == 0 ? n & mask : n / tile.points;
    const int line = tile.displacement_first + n - at * stride;
    const vec4 here = texelFetch(samples, line + at * stride);
    vec3 sum = here.xyz;
    float weight = 1.0;
    for (int j = 1; j <= memory; ++j) {
        weight *= pole;
        sum += weight * (texelFetch(samples, line + ((at + j) & mask) * stride).xyz +
                         texelFetch(samples, line + ((at - j) & mask) * stride).xyz);
    }
    coefficients[tile.displacement_first + n] = vec4(gain * sum, here.w);
}
