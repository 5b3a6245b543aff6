#version 460
// SPDX-License-Identifier: Apache-2.0
// Raw numbers of the sea, one case a view (client/view/debug_views.h), of the pixel's first
// sample; nothing is lit or mapped to colours here.
#extension GL_GOOGLE_include_directive : require
#include "view/bindings.glsl"
#include "view/gradients.glsl"
#include "view/foam.glsl"

layout(location = 0) in vec3 direction;
layout(location = 0) out vec4 value;

/// Row and column of the mesh at an undisplaced place.
vec2 mesh_cell(vec2 undisplaced_m) {
    const vec2 from_apex = undisplaced_m - view.mesh_apex_m;
    const float r = length(from_apex);
    int low = 0;
    int high = view.mesh_rows - 1;
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        if (row_distance_m[middle] <= r)
            low = middle;
        else
            high = middle;
    }
    const float turn = atan(from_apex.y, from_apex.x) - view.mesh_azimuth_rad;
    const float two_pi = 6.2831853;
    const float column = (turn - two_pi * floor(turn / two_pi)) / view.mesh_step_rad;
    return vec2(float(low) + (r - row_distance_m[low]) /
                                 (row_distance_m[high] - row_distance_m[low]), column);
}

void main() {
    value = vec4(0, 0, 0, 1);
    const Place place = unpacked_place(texelFetch(geometry, ivec2(gl_FragCoord.xy), 0));
    if (shows_sky(place))
        return;
    const vec3 away = normalize(direction);
    const Footprint area = footprint(place.undisplaced_m, -away, place.distance_m);
    const Gradients g = gradients_at(area);
    const vec3 scaled = scaled_normal(g);
    switch (view.what) {
    case view_height:
        value.rgb = vec3(place.height_m);
        break;
    case view_place:
        value.rgb = vec3(place.undisplaced_m, place.height_m);
        break;
    case view_normal:
        value.rgb = normalize(scaled);
        break;
    case view_slope:
        value.rg = -scaled.xy / scaled.z;
        break;
    case view_jacobian:
        value.rgb = vec3(scaled.z);
        break;
    case view_roughness:
        value.rgb = vec3(sqrt(g.variance.x + g.variance.y));
        break;
    case view_foam:
        value.rgb = vec3(foam_at(foam_share(g), place.undisplaced_m, area.pixel_m).cover);
        break;
    case view_cascade:
        value.rg = gradients_of_cascade(area, view.what_cascade).slope;
        break;
    case view_grid:
        value.rgb = vec3(any(lessThan(fract(mesh_cell(place.undisplaced_m) / 16.0), vec2(0.08))) ? 1.0 : 0.0);
        break;
    }
}
