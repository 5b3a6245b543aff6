// SPDX-License-Identifier: Apache-2.0
// Set 0 of every drawing pipeline of the view.
#include "view/frame.glsl"
#include "view/place.glsl"
#include "view/gradient_texel.glsl"

/// Distance of the mesh's rows from its apex, m.
layout(std430, binding = 1) readonly buffer Rows { float row_distance_m[]; };
/// [row][column][2]: local position and the mesh's spacing there, m; a Place, packed.
layout(binding = 2) uniform samplerBuffer vertices;
/// [cascade][level][y][x]: a GradientTexel, packed.
layout(binding = 3) uniform usamplerBuffer gradients;
/// [layer][row][column]: tables of the sky, shared/view.h.
layout(binding = 4) uniform sampler2DArray sky_map;
/// [y][x], samples: a Place each, packed.
#ifdef SEAWAY_ONE_SAMPLE
layout(binding = 5) uniform sampler2D geometry;
const int samples = 1;
#else
layout(binding = 5) uniform sampler2DMS geometry;
const int samples = 4;
#endif
