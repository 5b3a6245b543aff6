#version 460
// SPDX-License-Identifier: Apache-2.0
// Raw numbers of the sea, one view a number (client/view/debug_views.h); nothing is lit or mapped
// to colours here.
#extension GL_GOOGLE_include_directive : require
#include "view/bindings.glsl"
#include "view/gradients.glsl"
#include "view/foam.glsl"

layout(location = 0) centroid in vec2 undisplaced_m;
layout(location = 1) centroid in vec3 position_m;
layout(location = 2) centroid in float height_m;
layout(location = 3) centroid in vec2 cell;
layout(location = 0) out vec4 value;

float grid_line(float coordinate) {
    const float width = max(fwidth(coordinate), 1e-4);
    return 1.0 - clamp(abs(fract(coordinate - 0.5) - 0.5) / width, 0.0, 1.0);
}

void main() {
    const Footprint area = footprint(undisplaced_m);
    const Gradients g = gradients_at(area);
    const vec3 scaled = scaled_normal(g);
    vec3 shown = vec3(0);
    switch (int(view.counts.z)) {
    case 1: // height
        shown = vec3(height_m);
        break;
    case 2: // position
        shown = vec3(position_m.xy, height_m);
        break;
    case 3: // normal
        shown = normalize(scaled);
        break;
    case 4: // slope
        shown = vec3(-scaled.xy / scaled.z, 0);
        break;
    case 5: // jacobian
        shown = vec3(scaled.z);
        break;
    case 6: // roughness
        shown = vec3(sqrt(g.variance.x + g.variance.y));
        break;
    case 7: // foam
        shown = vec3(foam_cover(breaking_share(scaled.z, g.variance), undisplaced_m,
                                distance(view.camera.xyz, position_m)));
        break;
    case 8: // cascade
        shown = vec3(gradients_of_cascade(area, int(view.counts.w)).slope, 0);
        break;
    case 9: // grid
        shown = vec3(max(grid_line(cell.x), grid_line(cell.y)));
        break;
    }
    value = vec4(shown, 1);
}
