#version 460
// SPDX-License-Identifier: Apache-2.0
// A map of one cascade as it lies in memory, a texel a square, north up: raw numbers as in debug.frag.
#extension GL_GOOGLE_include_directive : require
#include "view/frame.glsl"
#include "view/gradient_texel.glsl"

layout(binding = 3) uniform usamplerBuffer gradients;
layout(binding = 6) uniform samplerBuffer displacements;
#include "view/displacement.glsl"

layout(location = 0) in vec3 direction;
layout(location = 0) out vec4 value;

/// Level 0 holds coefficients; what they stand for is shown.
vec3 displacement_texel(ViewCascade tile, ivec2 texel) {
    const int level = view.debug.mip;
    const int side = tile.points >> level;
    return level == 0 ? spline(tile, vec2(texel) / float(side))
                      : texelFetch(displacements, tile.displacement_first + texels_above(tile.points, level) +
                                                      texel.y * side + texel.x).xyz;
}

void main() {
    value = vec4(0);
    const vec2 at = (gl_FragCoord.xy - view.debug.area.xy) / view.debug.area.zw;
    if (any(lessThan(at, vec2(0))) || any(greaterThanEqual(at, vec2(1))))
        return;
    const ViewCascade tile = view.cascade[view.what_cascade];
    const int side = (view.what == view_map_displacement ? tile.points : tile.nodes) >> view.debug.mip;
    const ivec2 texel = min(ivec2(vec2(at.x, 1.0 - at.y) * float(side)), ivec2(side - 1));
    value.a = 1.0;
    if (view.what == view_map_displacement) {
        value.rgb = displacement_texel(tile, texel);
        return;
    }
    const GradientTexel t =
        unpacked_gradient(texelFetch(gradients, tile.gradient_first + texels_above(tile.nodes, view.debug.mip) +
                                                    texel.y * side + texel.x));
    const vec2 lambda = view.choppiness;
    switch (view.what) {
    case view_map_slope:
        value.rg = t.slope;
        break;
    case view_map_gradient:
        value.rgb = t.strain;
        break;
    case view_map_jacobian:
        value.rgb = vec3((1.0 + lambda.x * t.strain.x) * (1.0 + lambda.y * t.strain.y) -
                         lambda.x * lambda.y * t.strain.z * t.strain.z);
        break;
    case view_map_roughness:
        value.rgb = vec3(sqrt(t.variance.x + t.variance.y));
        break;
    case view_map_foam:
        value.rgb = vec3(clamp(view.foam_mean * t.foam, 0.0, 1.0));
        break;
    }
}
