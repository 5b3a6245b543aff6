#version 460
// SPDX-License-Identifier: Apache-2.0
// As mix.comp, from maps as a synthesizer leaves them: two keyframes of a cascade become the samples of this moment, values
// at grid points that splines.comp makes coefficients of. Four points an invocation.
#extension GL_GOOGLE_include_directive : require
#include "view/flat.glsl"
#include "view/frame.glsl"

layout(local_size_x = view_group) in;
/// Of one cascade: two keyframes among others, each one map after the other, [y][x].
layout(binding = 1) uniform samplerBuffer maps;
/// Level 0 of each cascade, [y][x]: Dx, Dy, eta, foam / its mean.
layout(std430, binding = 2) writeonly buffer DisplacementMaps { vec4 displacements[]; };

/// Which map of a keyframe holds what; below 0: none does.
layout(push_constant) uniform Push {
    int cascade;
    int dx, dy, eta;
    int dx_rate, dy_rate, eta_rate;
    int foam;
};

void main() {
    const ViewCascade tile = view.cascade[cascade];
    const int quads = tile.points * tile.points / 4;
    const int n = flat_invocation();
    if (n >= quads)
        return;
    const int before = tile.before_first + n, after = tile.after_first + n;
    const vec4 w = tile.hermite;
    vec4 sum[3];
    const ivec3 value = ivec3(dx, dy, eta), rate = ivec3(dx_rate, dy_rate, eta_rate);
    for (int i = 0; i < 3; ++i) {
        sum[i] = vec4(0);
        if (value[i] >= 0)
            sum[i] += w.x * texelFetch(maps, before + value[i] * quads) + w.z * texelFetch(maps, after + value[i] * quads);
        if (rate[i] >= 0)
            sum[i] += w.y * texelFetch(maps, before + rate[i] * quads) + w.w * texelFetch(maps, after + rate[i] * quads);
    }
    vec4 ratio = vec4(1); // a cascade without foam is average everywhere
    if (tile.foam_share >= 0.0)
        ratio = mix(texelFetch(maps, before + foam * quads), texelFetch(maps, after + foam * quads), tile.foam_share);
    for (int i = 0; i < 4; ++i)
        displacements[tile.displacement_first + 4 * n + i] = vec4(sum[0][i], sum[1][i], sum[2][i], ratio[i]);
}
