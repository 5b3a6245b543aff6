#version 460
// SPDX-License-Identifier: Apache-2.0
// A fan of quads to beyond the horizon, moved by the sum of all cascades.
#extension GL_GOOGLE_include_directive : require
#include "view/bindings.glsl"

layout(location = 0) centroid out vec4 place; // packed
/// Of the triangle's first vertex: the same, and how far the distances of the others may be from its.
layout(location = 1) flat out vec4 corner;
layout(location = 2) flat out float reach_m;

vec4 spline_weights(float t) { // cubic B-spline
    const float u = 1.0 - t;
    const vec2 cubes = vec2(u * u * u, t * t * t);
    return vec4(cubes.x, 4.0 - 6.0 * t * t + 3.0 * cubes.y, 4.0 - 6.0 * u * u + 3.0 * cubes.x,
                cubes.y) / 6.0;
}

/// Level 0 holds coefficients of the spline that queries are answered from: a vertex is where a
/// query says it is.
vec3 spline(vec2 uv, int cascade) {
    const ivec2 size = textureSize(displacement_maps, 0).xy;
    const vec2 texel = uv * vec2(size) - 0.5;
    const ivec2 first = ivec2(floor(texel));
    const vec2 t = texel - vec2(first);
    const vec4 wx = spline_weights(t.x);
    const vec4 wy = spline_weights(t.y);
    vec3 sum = vec3(0);
    for (int j = 0; j < 4; ++j)
        for (int i = 0; i < 4; ++i) {
            const ivec2 at = (first + ivec2(i - 1, j - 1)) & (size - 1); // size: a power of two
            sum += wx[i] * wy[j] * texelFetch(displacement_maps, ivec3(at, cascade), 0).xyz;
        }
    return sum;
}

vec3 displacement(vec2 at_m, float spacing_m) {
    vec3 sum = vec3(0);
    for (int c = 0; c < view.cascades; ++c) {
        const ViewCascade tile = view.cascade[c];
        const vec2 uv = tile.origin + at_m * tile.maps_per_m;
        // What the mesh cannot carry is averaged away here and is roughness in the pixel.
        const float level = log2(spacing_m / tile.texel_m);
        vec3 one = vec3(0);
        if (level < 1.0)
            one = spline(uv, c);
        if (level > 0.0)
            one = mix(one, textureLod(displacement_maps, vec3(uv, float(c)), max(level, 1.0)).xyz,
                      min(level, 1.0));
        sum += one;
    }
    return sum;
}

void main() {
    const int columns = view.mesh_columns;
    const int row = gl_VertexIndex / columns;
    const int column = gl_VertexIndex % columns;
    const float r = row_distance_m[row];
    const float azimuth = view.mesh_azimuth_rad + float(column) * view.mesh_step_rad;
    const vec2 undisplaced_m = view.mesh_apex_m + r * vec2(cos(azimuth), sin(azimuth));

    const int last = view.mesh_rows - 1;
    const float spacing = max(row_distance_m[min(row + 1, last)] - row_distance_m[max(row - 1, 0)],
                              2.0 * r * view.mesh_step_rad) / 2.0;
    const vec3 d = displacement(undisplaced_m, spacing);
    const vec2 moved = undisplaced_m + view.choppiness * d.xy;
    const vec3 position_m = vec3(moved, d.z - dot(moved, moved) * view.curvature_per_m);
    place = packed_place(Place(undisplaced_m, d.z, distance(position_m, view.camera_m)));
    corner = place;
    // A cell and what waves move its corners by: six standard deviations either way.
    reach_m = 3.0 * spacing + 3.0 * view.significant_height_m * (1.0 + max(view.choppiness.x, view.choppiness.y));
    gl_Position = view.clip_from_local * vec4(position_m, 1);
}
