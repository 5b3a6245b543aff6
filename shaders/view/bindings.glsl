// SPDX-License-Identifier: Apache-2.0
// Set 0 of every pipeline of the view.
#include "shared/view.h"

layout(std140, binding = 0) uniform View { ViewValues view; };
/// Distance of the mesh's rows from its apex, m.
layout(std430, binding = 1) readonly buffer Rows { float row_distance_m[]; };
/// [cascade][y][x]: Dx, Dy, eta, foam / its mean. Level 0 of the first three: coefficients of cubic
/// splines; others: means.
layout(binding = 2) uniform sampler2DArray displacement_maps;
/// [cascade][y][x]: slope x, slope y, strain xx, strain yy.
layout(binding = 3) uniform sampler2DArray gradient_maps;
/// [cascade][y][x]: strain xy, slope x squared, slope y squared, slope x slope y.
layout(binding = 4) uniform sampler2DArray moment_maps;
/// [elevation][azimuth from the sun]: radiance of the sky, kcd/m2.
layout(binding = 5) uniform sampler2D sky_map;
/// [y][x], samples: a Place each, packed.
layout(binding = 6) uniform sampler2DMS geometry;

/// What of the sea a sample shows.
struct Place {
    vec2 undisplaced_m; // local
    float height_m;     // above the mean sea
    float distance_m;   // from the eye; 0: sky
};

vec4 packed_place(Place p) { return vec4(p.undisplaced_m, p.height_m, p.distance_m); }
Place unpacked_place(vec4 texel) { return Place(texel.xy, texel.z, texel.w); }
bool shows_sky(Place p) { return p.distance_m == 0.0; }
