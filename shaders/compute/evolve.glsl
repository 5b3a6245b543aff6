// SPDX-License-Identifier: Apache-2.0
// From stored amplitudes and frequencies to h(k,t) and dh/dt: exact integer phase, own sine.

/// (cos, sin) of a phase given in turns, 0.32 fixed point. The nearest quarter is taken off as an
/// integer; polynomials of Cephes sinf/cosf on [-pi/4, pi/4], error 1e-7 on every device.
vec2 unit_phasor(uint turns) {
    uint quarter = (turns + 0x20000000u) >> 30;
    float x = float(int(turns - (quarter << 30))) * 1.46291807926715968e-9; // 2 pi / 2^32
    float x2 = x * x;
    float s = x + x * x2 * (-1.6666654611e-1 + x2 * (8.3321608736e-3 - x2 * 1.9515295891e-4));
    float rest = 4.166664568298827e-2 + x2 * (-1.388731625493765e-3 + x2 * 2.443315711809948e-5);
    float c = 1.0 - 0.5 * x2 + x2 * x2 * rest;
    bool swapped = (quarter & 1u) != 0u;
    float re = swapped ? s : c;
    float im = swapped ? c : s;
    return vec2(((quarter + 1u) & 2u) != 0u ? -re : re, (quarter & 2u) != 0u ? -im : im);
}

/// Bits 32..63 of rate * time: the phase in turns modulo 1.
uint phase_turns(uvec2 rate, uvec2 time) {
    uint high, low;
    umulExtended(rate.x, time.x, high, low);
    return high + rate.y * time.x + rate.x * time.y;
}

/// pair = (h0(k), conj h0(-k)); xy: h(k,t), zw: dh/dt.
vec4 evolve(vec4 pair, uvec2 rate, uvec2 time) {
    vec2 e = unit_phasor(phase_turns(rate, time));
    const float radps = 3.40612158008655459e-13; // 2e6 pi / 2^64
    float omega = (float(rate.y) * 4294967296.0 + float(rate.x)) * radps;
    // h0(k) exp(-i w t) and conj h0(-k) exp(+i w t)
    vec2 along = vec2(pair.x * e.x + pair.y * e.y, pair.y * e.x - pair.x * e.y);
    vec2 against = vec2(pair.z * e.x - pair.w * e.y, pair.w * e.x + pair.z * e.y);
    vec2 d = omega * (against - along);
    return vec4(along + against, -d.y, d.x);
}
