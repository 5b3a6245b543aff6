#version 460
// SPDX-License-Identifier: Apache-2.0
// Level 0 of the gradients' maps: derivatives of the spline at each node, and foam, linear in space.
#extension GL_GOOGLE_include_directive : require
#include "view/flat.glsl"
#include "view/frame.glsl"
#include "view/spline.glsl"
#include "view/gradient_texel.glsl"

layout(local_size_x = view_group) in;
layout(binding = 1) uniform samplerBuffer displacements;
layout(std430, binding = 2) writeonly buffer GradientMaps { uvec4 gradients[]; };

void main() {
    const ViewCascade tile = view.cascade[gl_WorkGroupID.z];
    const int n = flat_invocation();
    if (n >= tile.nodes * tile.nodes)
        return;
    const int finer = tile.nodes / tile.points;
    const ivec2 node = ivec2(n % tile.nodes, n / tile.nodes);
    const ivec2 point = node / finer;
    const vec2 t = vec2(node % finer) / float(finer);
    const vec4 wx = spline_weights(t.x), wy = spline_weights(t.y);
    const vec4 sx = spline_slopes(t.x), sy = spline_slopes(t.y);
    // At a grid point the last coefficient of four counts for nothing.
    const int last = finer == 1 ? 2 : 3;
    const int mask = tile.points - 1;
    vec3 by_x = vec3(0), by_y = vec3(0);
    float foam = 0.0;
    for (int j = 0; j <= last; ++j) {
        const int row = tile.displacement_first + ((point.y + j - 1) & mask) * tile.points;
        const float foam_y = j == 1 ? 1.0 - t.y : j == 2 ? t.y : 0.0;
        for (int i = 0; i <= last; ++i) {
            const vec4 c = texelFetch(displacements, row + ((point.x + i - 1) & mask));
            by_x += sx[i] * wy[j] * c.xyz;
            by_y += wx[i] * sy[j] * c.xyz;
            foam += foam_y * (i == 1 ? 1.0 - t.x : i == 2 ? t.x : 0.0) * c.w;
        }
    }
    const float points_per_m = float(tile.points) * tile.maps_per_m;
    by_x *= points_per_m;
    by_y *= points_per_m;
    GradientTexel texel;
    texel.slope = vec2(by_x.z, by_y.z);
    texel.strain = vec3(by_x.x, by_y.y, by_y.x);
    texel.variance = vec3(0);
    texel.foam = foam;
    gradients[tile.gradient_first + n] = packed(texel);
}
