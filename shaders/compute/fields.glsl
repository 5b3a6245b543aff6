// SPDX-License-Identifier: Apache-2.0
// From evolved modes to the lines of real fields. Knows weights, no field by name; what the rows
// hold is in shared/synthesis.h.

struct Source {
    float c0, c1, d0, d1, d2;
    bool rate;
};
Source source_row(uint source) {
    vec4 a = texelFetch(rows, int(2u * source)), b = texelFetch(rows, int(2u * source + 1u));
    return Source(a.x, a.y, a.z, a.w, b.x, b.y > 0.5);
}

/// One mode of a source, from its evolved amplitude `h` (xy: h, zw: dh/dt). over_k: coth(kd)/k.
vec2 source_mode(Source s, vec4 h, float ky, float over_k) {
    float m = s.c0 + ky * s.c1 + over_k * (s.d0 + ky * (s.d1 + ky * s.d2));
    return m * (s.rate ? h.zw : h.xy);
}

/// The fields of a source: x <= row < y.
uvec2 fields_of(uint source) {
    return uvec2(texelFetch(rows, int(2u * source + 1u)).zw);
}
vec4 field_row(uint field) {
    return texelFetch(rows, int(first_field_texel + field));
}
/// Where a field of the job of this workgroup goes, in maps of the target.
uint map_of(uint field) {
    uint map = uint(texelFetch(rows, int(first_map_texel + field)).x);
    return push.first_map + gl_WorkGroupID.y * push.maps + map;
}
float along_x(vec4 row, float kx) {
    return row.x + kx * (row.y + kx * row.z);
}

// Two rows y, y + 1 of a real field are one complex line: row y + i row (y + 1). `v` holds the mode
// kx > 0 of both; those of -kx are their conjugates.
vec2 two_rows(vec4 v) {
    return vec2(v.x - v.w, v.y + v.z);
}
vec2 two_rows_mirrored(vec4 v) {
    return vec2(v.x + v.w, v.z - v.y);
}
vec2 times_i(vec2 z, bool wanted) {
    return wanted ? vec2(-z.y, z.x) : z;
}
vec2 times_minus_i(vec2 z, bool wanted) {
    return wanted ? vec2(z.y, -z.x) : z;
}
