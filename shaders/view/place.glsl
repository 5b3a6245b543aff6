// SPDX-License-Identifier: Apache-2.0
// What the passes hand to each other.

/// What of the sea a sample shows.
struct Place {
    vec2 undisplaced_m; // local
    float height_m;     // above the mean sea
    float distance_m;   // from the eye; 0: sky
};

vec4 packed_place(Place p) { return vec4(p.undisplaced_m, p.height_m, p.distance_m); }
Place unpacked_place(vec4 texel) { return Place(texel.xy, texel.z, texel.w); }
bool shows_sky(Place p) { return p.distance_m == 0.0; }
