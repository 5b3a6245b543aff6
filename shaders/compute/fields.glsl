// SPDX-License-Identifier: Apache-2.0
// From an evolved mode to the packed spectrum of two fields. Knows weights, no field by name.

/// The real multiplier of one field along a line of modes: weights of its basis functions with the
/// line's ky (or kx) put in.
struct Multiplier {
    float c0, c1, d0, d1, d2;
};
Multiplier multiplier(vec4 w0, vec4 w1, float ky) {
    return Multiplier(w0.x + w1.x * ky, w0.w, (w0.z + w1.z * ky) * ky, w0.y + w1.w * ky, w1.y);
}
Multiplier multiplier_along_y(vec4 w0, vec4 w1, float kx) {
    return Multiplier(w0.x + w0.w * kx, w1.x, (w0.y + w1.y * kx) * kx, w0.z + w1.w * kx, w1.z);
}
float at(Multiplier m, float k, float inverse_k) {
    return m.c0 + k * m.c1 + inverse_k * (m.d0 + k * (m.d1 + k * m.d2));
}

/// a + i b of one mode, from its evolved amplitude `h` (xy: h, zw: dh/dt).
vec2 packed_fields(vec4 h, float a, float b, bvec4 flags) {
    vec2 ha = flags.x ? h.zw : h.xy;
    vec2 hb = flags.z ? h.zw : h.xy;
    ha = flags.y ? vec2(-ha.y, ha.x) : ha;
    hb = flags.w ? -hb : vec2(-hb.y, hb.x);
    return a * ha + b * hb;
}
