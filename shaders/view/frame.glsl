// SPDX-License-Identifier: Apache-2.0
// Binding 0 of every shader of the view, and where the levels of a map lie.
#include "shared/view.h"

layout(std140, binding = 0) uniform View { ViewValues view; };

/// Texels of the levels above this one of a map of `side` texels a side, a power of two.
int texels_above(int side, int level) {
    const int here = side >> level;
    return (side * side - here * here) / 3 * 4;
}

/// The last level: one texel.
int last_level(int side) { return findMSB(side); }

/// Bilinear: the texels around a place of a level and their weights. Texel j of level l is the mean of nodes
/// j 2^l and the 2^l - 1 behind it; node i lies at i / side of the tile.
struct Around {
    ivec4 texel; // south west, south east, north west, north east; within the level
    vec4 weight;
};

Around texels_around(vec2 tile_place, int side, int level) {
    const int here = side >> level;
    const vec2 at = tile_place * float(here) + (0.5 * exp2(-float(level)) - 0.5);
    const ivec2 low = ivec2(floor(at));
    const vec2 t = at - vec2(low);
    const ivec2 west_south = low & (here - 1);
    const ivec2 east_north = (low + 1) & (here - 1);
    return Around(ivec4(west_south.y * here + west_south.x, west_south.y * here + east_north.x,
                        east_north.y * here + west_south.x, east_north.y * here + east_north.x),
                  vec4((1.0 - t.x) * (1.0 - t.y), t.x * (1.0 - t.y), (1.0 - t.x) * t.y, t.x * t.y));
}
