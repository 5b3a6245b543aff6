#version 460
// SPDX-License-Identifier: Apache-2.0
// Raw numbers of the sea, one case a view (client/view/debug_views.h), of the pixel's first
// sample; nothing is lit or mapped to colours here. Alpha: 0 no number, 1 a number, 2 the surface folds.
#extension GL_GOOGLE_include_directive : require
#include "view/bindings.glsl"
#include "view/gradients.glsl"
#include "view/foam.glsl"
#include "view/mesh_cell.glsl"

layout(binding = 6) uniform samplerBuffer displacements;
#include "view/displacement.glsl"

layout(location = 0) in vec3 direction;
layout(location = 0) out vec4 value;

/// Of all cascades, or of the one that was chosen.
Gradients chosen_gradients(Footprint area) {
    if (view.what_cascade < 0)
        return gradients_at(area);
    const GradientTexel one = gradients_of_cascade(area, view.what_cascade);
    return Gradients(one.slope, one.strain, one.variance, 0.0, one.foam);
}

vec3 chosen_displacement(Place place, float spacing_m) {
    const int first = max(view.what_cascade, 0);
    const int last = view.what_cascade < 0 ? view.cascades - 1 : first;
    const vec3 d = displacement(place.undisplaced_m, spacing_m, first, last);
    return vec3(view.choppiness * d.xy, d.z);
}

/// Foam as it is drawn; of one cascade what its history says.
float foam_shown(Gradients g, Place place, Footprint area) {
    return view.what_cascade < 0 ? foam_at(foam_share(g), place.undisplaced_m, area.pixel_m).cover
                                 : clamp(view.foam_mean * g.foam, 0.0, 1.0);
}

/// A vector on the sea as the eye sees it at this pixel, pixels.
vec3 seen_pixels(vec3 m, vec3 away, float distance_m) {
    const vec3 ahead = normalize((view.local_from_clip * vec4(0, 0, 0, 1)).xyz);
    const float aside = dot(ahead, away); // pixels away from the middle are smaller angles
    return (m - dot(m, away) * away) / (distance_m * view.pixel_rad * aside * sqrt(aside));
}

/// Sides of the mesh's cell as the eye sees them.
struct SeenCell {
    vec2 at;
    vec3 along, across;
    float area; // pixels
};

SeenCell seen_cell(Place place, Gradients g, vec3 away) {
    const MeshCell cell = mesh_cell(place.undisplaced_m);
    const vec2 lambda = view.choppiness;
    const mat2x3 tangents = mat2x3(vec3(1 + lambda.x * g.strain.x, lambda.y * g.strain.z, g.slope.x),
                                   vec3(lambda.x * g.strain.z, 1 + lambda.y * g.strain.y, g.slope.y));
    const vec3 along = seen_pixels(tangents * cell.along, away, place.distance_m);
    const vec3 across = seen_pixels(tangents * cell.across, away, place.distance_m);
    return SeenCell(cell.at, along, across, length(cross(along, across)));
}

/// How near the edge of a triangle is, as a line a pixel wide. Cells are cut from the next column to the next row.
float edge_shown(SeenCell cell) {
    const vec2 f = fract(cell.at);
    const float from_row = min(f.x, 1.0 - f.x) * cell.area / max(length(cell.across), 1e-6);
    const float from_column = min(f.y, 1.0 - f.y) * cell.area / max(length(cell.along), 1e-6);
    const float from_cut = abs(f.x + f.y - 1.0) * cell.area / max(length(cell.along - cell.across), 1e-6);
    const float line = clamp(1.0 - min(min(from_row, from_column), from_cut), 0.0, 1.0);
    const float narrowest = cell.area / max(max(length(cell.across), length(cell.along)), 1e-6);
    return mix(0.5, line, clamp(narrowest - 1.5, 0.0, 1.0));
}

float mesh_number(SeenCell cell) { return view.what == view_density ? cell.area : edge_shown(cell); }

/// MapLoss::AtTime::variance_m2().
float loss_m2(vec4 loss, float coded_relief, vec2 between) {
    const vec2 left = 1.0 - coded_relief * between;
    return dot(loss, vec4(1.0, between, left.x * left.y));
}

/// As Surface::answer() states it (sea/surface/map_error.h), for the place and slope that the pixel shows.
float height_bound_m(Place place, float slope) {
    const float sideways = slope * max(view.choppiness.x, view.choppiness.y);
    float variance_m2 = 0.0;
    for (int c = 0; c < view.cascades; ++c) {
        const ViewCascade tile = view.cascade[c];
        const vec2 s = fract((tile.origin + place.undisplaced_m * tile.maps_per_m) * float(tile.points));
        const vec2 u = 4.0 * s * (1.0 - s);
        const vec2 between = u * u;
        const vec2 relief = view.debug.coded_relief[c].xy;
        variance_m2 += loss_m2(view.debug.height_loss[c], relief.x, between) +
                       sideways * sideways * loss_m2(view.debug.displacement_loss[c], relief.y, between);
    }
    return view.debug.bound_sigmas * sqrt(variance_m2) + view.debug.height_bound_m +
           sideways * view.debug.displacement_bound_m;
}

/// The smaller stretch of the surface is negative, or may be.
bool may_fold(Gradients g) {
    const vec2 lambda = view.choppiness;
    const float xx = 1.0 + lambda.x * g.strain.x;
    const float yy = 1.0 + lambda.y * g.strain.y;
    const float half_gap = sqrt(0.25 * (xx - yy) * (xx - yy) + lambda.x * lambda.y * g.strain.z * g.strain.z);
    return 0.5 * (xx + yy) - half_gap < view.debug.fold_blur;
}

/// Of all cascades in strips from left to right, or of one.
vec3 keyframe_age_ms() {
    const int strip = int(gl_FragCoord.x * float(view.cascades) / view.debug.area.z);
    return view.debug.keyframe_ms[view.what_cascade < 0 ? min(strip, view.cascades - 1) : view.what_cascade].xyz;
}

void main() {
    value = vec4(0);
    const Place place = unpacked_place(texelFetch(geometry, ivec2(gl_FragCoord.xy), 0));
    if (shows_sky(place))
        return;
    value.a = 1.0;
    const vec3 away = normalize(direction);
    const Footprint area = footprint(place.undisplaced_m, -away, place.distance_m);
    const Gradients g = chosen_gradients(area);
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
        value.rgb = vec3(foam_shown(g, place, area));
        break;
    case view_cascade:
        value.rg = g.slope;
        break;
    case view_grid:
        value.rgb = vec3(any(lessThan(fract(mesh_cell(place.undisplaced_m).at / 16.0), vec2(0.08))) ? 1.0 : 0.0);
        break;
    case view_displacement:
        value.rgb = chosen_displacement(place, place.distance_m * view.pixel_rad);
        break;
    case view_gradient:
        value.rgb = vec3(view.choppiness * g.strain.xy, view.choppiness.x * g.strain.z);
        break;
    case view_reflected:
        value.rgb = reflect(away, lit_normal(scaled, -away));
        break;
    case view_density:
    case view_wireframe:
        value.rgb = vec3(mesh_number(seen_cell(place, g, away)));
        break;
    case view_age:
        value.rgb = keyframe_age_ms();
        break;
    case view_bound:
        value.rgb = vec3(height_bound_m(place, length(scaled.xy) / max(scaled.z, 1e-3)));
        value.a = may_fold(g) ? 2.0 : 1.0;
        break;
    }
}
