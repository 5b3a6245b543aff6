#version 460
// SPDX-License-Identifier: Apache-2.0
// The vertices of a fan of quads to beyond the horizon, moved by the sum of all cascades. A pass of its own, because
// devices without a GPU run vertex shaders in one thread.
#extension GL_GOOGLE_include_directive : require
#include "view/flat.glsl"
#include "view/frame.glsl"
#include "view/place.glsl"

layout(local_size_x = view_group) in;
/// Distance of the mesh's rows from its apex, m.
layout(std430, binding = 1) readonly buffer Rows { float row_distance_m[]; };
/// [cascade][level][y][x]: Dx, Dy, eta, foam / its mean. Level 0: coefficients of cubic splines; others: means.
layout(binding = 2) uniform samplerBuffer displacements;
layout(std430, binding = 3) writeonly buffer Vertices { vec4 vertices[]; };
#include "view/displacement.glsl"

void main() {
    const int n = flat_invocation();
    const int columns = view.mesh_columns;
    const int last = view.mesh_rows - 1;
    if (n >= columns * view.mesh_rows)
        return;
    const int row = n / columns;
    const float r = row_distance_m[row];
    const float azimuth = view.mesh_azimuth_rad + float(n % columns) * view.mesh_step_rad;
    const vec2 undisplaced_m = view.mesh_apex_m + r * vec2(cos(azimuth), sin(azimuth));
    const float spacing = max(row_distance_m[min(row + 1, last)] - row_distance_m[max(row - 1, 0)],
                              2.0 * r * view.mesh_step_rad) / 2.0;
    const vec3 d = displacement(undisplaced_m, spacing, 0, view.cascades - 1);
    const vec2 moved = undisplaced_m + view.choppiness * d.xy;
    const vec3 position_m = vec3(moved, d.z - dot(moved, moved) * view.curvature_per_m);
    vertices[2 * n] = vec4(position_m, spacing);
    vertices[2 * n + 1] = packed_place(Place(undisplaced_m, d.z, distance(position_m, view.camera_m)));
}
