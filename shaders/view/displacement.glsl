// SPDX-License-Identifier: Apache-2.0
// How far waves move a point: from `displacements`, [cascade][level][y][x]: Dx, Dy, eta, foam / its mean. Level 0:
// coefficients of cubic splines; others: means.
#include "view/spline.glsl"

/// A vertex is where a query says it is.
vec3 spline(ViewCascade tile, vec2 tile_place) {
    const vec2 at = tile_place * float(tile.points);
    const ivec2 first = ivec2(floor(at));
    const vec4 wx = spline_weights(at.x - float(first.x));
    const vec4 wy = spline_weights(at.y - float(first.y));
    const int mask = tile.points - 1;
    vec3 sum = vec3(0);
    for (int j = 0; j < 4; ++j) {
        const int row = tile.displacement_first + ((first.y + j - 1) & mask) * tile.points;
        for (int i = 0; i < 4; ++i)
            sum += wx[i] * wy[j] * texelFetch(displacements, row + ((first.x + i - 1) & mask)).xyz;
    }
    return sum;
}

vec3 mean_level(ViewCascade tile, vec2 tile_place, int level) {
    const Around around = texels_around(tile_place, tile.points, level);
    const int first = tile.displacement_first + texels_above(tile.points, level);
    vec3 sum = vec3(0);
    for (int i = 0; i < 4; ++i)
        sum += around.weight[i] * texelFetch(displacements, first + around.texel[i]).xyz;
    return sum;
}

/// D of these cascades. What the mesh cannot carry is averaged away here and is roughness in the pixel.
vec3 displacement(vec2 at_m, float spacing_m, int first, int last) {
    vec3 sum = vec3(0);
    for (int c = first; c <= last; ++c) {
        const ViewCascade tile = view.cascade[c];
        const vec2 place = fract(tile.origin + at_m * tile.maps_per_m);
        const float level = log2(max(spacing_m * float(tile.points) * tile.maps_per_m, 1e-6));
        // Devices without a GPU take both sides of every branch, but leave a loop that nobody is in.
        for (int once = 0; once < int(level < 1.0); ++once)
            sum += (1.0 - max(level, 0.0)) * spline(tile, place);
        const int finer = max(int(floor(level)), 1);
        // Above: no wave of it is left.
        const int coarser = level > 0.0 && level < float(tile.displacement_levels) ? int(ceil(level)) : -1;
        for (int l = finer; l <= coarser; ++l)
            sum += (1.0 - abs(level - float(l))) * mean_level(tile, place, l);
    }
    return sum;
}
