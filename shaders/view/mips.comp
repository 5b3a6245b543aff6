#version 460
// SPDX-License-Identifier: Apache-2.0
// One further level of the maps of every cascade, each texel the mean of four of the level above. Level 0 of the
// displacements holds coefficients of splines: their values are averaged.
#extension GL_GOOGLE_include_directive : require
#include "view/flat.glsl"
#include "view/frame.glsl"
#include "view/gradient_texel.glsl"

layout(local_size_x = view_group) in;
layout(std430, binding = 1) writeonly buffer DisplacementMaps { vec4 displacements[]; };
layout(std430, binding = 2) writeonly buffer GradientMaps { uvec4 gradients[]; };
// The same, to read: level by level.
layout(binding = 3) uniform samplerBuffer displacements_above;
layout(binding = 4) uniform usamplerBuffer gradients_above;
layout(push_constant) uniform Push { int level; };

GradientTexel gradient(int at) {
    return unpacked_gradient(texelFetch(gradients_above, at));
}

/// Mean of the values at 2 x 2 grid points from the 4 x 4 coefficients around them; foam is no spline.
vec4 mean_of_spline(ViewCascade tile, ivec2 low) {
    const vec4 weight = vec4(1, 5, 5, 1) / 12.0;
    const vec4 foam_weight = vec4(0, 0.5, 0.5, 0);
    const int mask = tile.points - 1;
    vec4 sum = vec4(0);
    for (int j = 0; j < 4; ++j)
        for (int i = 0; i < 4; ++i) {
            const vec4 c = texelFetch(displacements_above, tile.displacement_first +
                                                               ((low.y + j - 1) & mask) * tile.points +
                                                               ((low.x + i - 1) & mask));
            sum += vec4(vec3(weight[i] * weight[j]), foam_weight[i] * foam_weight[j]) * c;
        }
    return sum;
}

void displacement_level(ViewCascade tile, int n) {
    const int side = tile.points >> level;
    if (side == 0 || n >= side * side)
        return;
    const ivec2 low = 2 * ivec2(n % side, n / side);
    vec4 mean;
    if (level == 1) {
        mean = mean_of_spline(tile, low);
    } else {
        const int above = tile.displacement_first + texels_above(tile.points, level - 1);
        const int first = above + low.y * 2 * side + low.x;
        mean = 0.25 * (texelFetch(displacements_above, first) + texelFetch(displacements_above, first + 1) +
                       texelFetch(displacements_above, first + 2 * side) +
                       texelFetch(displacements_above, first + 2 * side + 1));
    }
    displacements[tile.displacement_first + texels_above(tile.points, level) + n] = mean;
}

void gradient_level(ViewCascade tile, int n) {
    const int side = tile.nodes >> level;
    if (side == 0 || n >= side * side)
        return;
    const ivec2 low = 2 * ivec2(n % side, n / side);
    const int first = tile.gradient_first + texels_above(tile.nodes, level - 1) + low.y * 2 * side + low.x;
    GradientSum sum = no_gradients;
    add(sum, gradient(first), 0.25);
    add(sum, gradient(first + 1), 0.25);
    add(sum, gradient(first + 2 * side), 0.25);
    add(sum, gradient(first + 2 * side + 1), 0.25);
    gradients[tile.gradient_first + texels_above(tile.nodes, level) + n] = packed(mean_of(sum));
}

void main() {
    const ViewCascade tile = view.cascade[gl_WorkGroupID.z];
    const int n = flat_invocation();
    displacement_level(tile, n);
    gradient_level(tile, n);
}
