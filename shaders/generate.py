#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the synthesis kernels (GLSL) and the table of them (C++).

Design W: one inverse 2-D transform of N x N in three passes, four above N = 512. N = A B along x
and N = C D along y; mode X = B n1 + n2 goes to point x = k1 + A k2, mode Y = D m1 + m2 to point
y = j1 + C j2:

    first   evolve; DFT_A over n1; twiddle w_N^(n2 k1)                  -> S[slot][Y][n2][k1]
    middle  DFT_B over n2; DFT_C over m1; twiddle w_N^(m2 j1)           -> T[slot][m2][j1][x]
    last    DFT_D over m2                                               -> map[slot][y][x]

No shared memory, no barriers inside a kernel; reads go through texel buffers, writes are vec4 (two
neighbouring complex numbers). Why: docs/performance.md.

    generate.py names                       kernel names, one a line
    generate.py glsl OUT_DIR                OUT_DIR/NAME.comp for every generated kernel
    generate.py embed OUT.cpp NAME=SPV ...  the C++ table
"""
import pathlib
import struct
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "tools"))
import codelets  # noqa: E402

# size: (A, B, C, D). At 1024 the middle pass would hold 1024 numbers, so it is cut in two.
PLANS = {64: (16, 4, 4, 16), 128: (32, 4, 8, 16), 256: (32, 8, 8, 32), 512: (32, 16, 16, 32),
         1024: (32, 32, 32, 32)}
WORKGROUP = 64  # shared/synthesis.h

HEAD = """#version 460
#extension GL_GOOGLE_include_directive : require
// SPDX-License-Identifier: Apache-2.0
// Written by shaders/generate.py.
#include "shared/synthesis.h"
#include "compute/evolve.glsl"

layout(local_size_x = synthesis_workgroup) in;
"""
OUTPUT = """layout(binding = {binding}, std430) writeonly buffer Target {{
    vec4 target[];
}};
layout(push_constant) uniform Push {{
    SynthesisPush push;
}};
"""
FIRST_BINDINGS = """layout(binding = 0) uniform samplerBuffer modes;  // (h0(k), conj h0(-k))
layout(binding = 1) uniform usamplerBuffer rates;
layout(binding = 2) uniform usamplerBuffer jobs;
layout(binding = 3) uniform samplerBuffer rows;
"""
MULTIPLIER = """
/// The real multiplier of one field along a row of modes: weights of its basis functions with the
/// row's ky put in.
struct Multiplier {
    float c0, cx, d0, d1, d2;
};
Multiplier multiplier(vec4 w0, vec4 w1, float ky) {
    return Multiplier(w0.x + w1.x * ky, w0.w, (w0.z + w1.z * ky) * ky, w0.y + w1.w * ky, w1.y);
}
float at(Multiplier m, float kx, float inverse_k) {
    return m.c0 + kx * m.cx + inverse_k * (m.d0 + kx * (m.d1 + kx * m.d2));
}

/// a + i b of one mode, from its evolved amplitude `h` (xy: h, zw: dh/dt).
vec2 packed_fields(vec4 h, float a, float b, bvec4 flags) {
    vec2 ha = flags.x ? h.zw : h.xy;
    vec2 hb = flags.z ? h.zw : h.xy;
    ha = flags.y ? vec2(-ha.y, ha.x) : ha;
    hb = flags.w ? -hb : vec2(-hb.y, hb.x);
    return a * ha + b * hb;
}
"""


def twiddles(name, turns, count):
    """vec2 NAMEk = w^k for k < count, by halving k: the error grows with log2 k only."""
    text = [f"    vec2 {name}1 = unit_phasor({turns});\n"]
    for k in range(2, count):
        a, b = f"{name}{k // 2}", f"{name}{k - k // 2}"
        text.append(f"    vec2 {name}{k} = vec2({a}.x * {b}.x - {a}.y * {b}.y, "
                    f"{a}.x * {b}.y + {a}.y * {b}.x);\n")
    return "".join(text)


def turned(re, im, name, k):
    """Text of (re, im) * NAMEk."""
    if k == 0:
        return re, im
    w = f"{name}{k}"
    return f"({re} * {w}.x - {im} * {w}.y)", f"({re} * {w}.y + {im} * {w}.x)"


def first_pass(n, a, b):
    text = [HEAD, FIRST_BINDINGS, OUTPUT.format(binding=4), MULTIPLIER, f"""
void main() {{
    uint n2 = gl_GlobalInvocationID.x % {b}u;
    uint row = gl_GlobalInvocationID.x / {b}u;
    uvec4 job = texelFetch(jobs, int(gl_GlobalInvocationID.z));
    float wavenumber_step = uintBitsToFloat(job.w);
    float ky = wavenumber_step * float(row < {n // 2}u ? int(row) : int(row) - {n});
    int base = int((job.x * {n}u + row) * {n}u + n2);
"""]
    for i in range(a):
        shift = b * (i if i < a // 2 else i - a)
        text.append(f"    float kx{i} = wavenumber_step * float(int(n2) + {shift});\n"
                    f"    float k2_{i} = kx{i} * kx{i} + ky * ky;\n"
                    f"    float inv{i} = k2_{i} > 0.0 ? inversesqrt(k2_{i}) : 0.0;\n"
                    f"    vec4 h{i} = evolve(texelFetch(modes, base + {b * i}), "
                    f"texelFetch(rates, base + {b * i}).xy, job.yz);\n")
    text.append(twiddles("w", f"n2 * {2**32 // n}u", a))
    text.append(f"""    for (uint slot = 0u; slot < push.slots; ++slot) {{
        int at_row = int(slot * slot_row_texels);
        Multiplier ma = multiplier(texelFetch(rows, at_row), texelFetch(rows, at_row + 1), ky);
        Multiplier mb = multiplier(texelFetch(rows, at_row + 2), texelFetch(rows, at_row + 3), ky);
        bvec4 flags = greaterThan(texelFetch(rows, at_row + 4), vec4(0.5));
""")
    for i in range(a):
        text.append(f"        vec2 z{i} = packed_fields(h{i}, at(ma, kx{i}, inv{i}), "
                    f"at(mb, kx{i}, inv{i}), flags);\n")
    text.append(codelets.dft(a).glsl("float", [(f"z{i}.x", f"z{i}.y") for i in range(a)],
                                     [(f"r{i}", f"i{i}") for i in range(a)], indent=" " * 8))
    text.append(f"        uint to = (((gl_GlobalInvocationID.z * push.slots + slot) * {n}u + row) * "
                f"{b}u + n2) * {a // 2}u;\n")
    for k in range(0, a, 2):
        even, odd = turned(f"r{k}", f"i{k}", "w", k), turned(f"r{k + 1}", f"i{k + 1}", "w", k + 1)
        text.append(f"        target[to + {k // 2}u] = vec4({', '.join(even + odd)});\n")
    text.append("    }\n}\n")
    return "".join(text)


def middle_pass(n, a, b, c, d):
    pairs = a // 2
    text = [HEAD, "layout(binding = 0) uniform samplerBuffer source;\n", OUTPUT.format(binding=1), f"""
void main() {{
    uint pair = gl_GlobalInvocationID.x % {pairs}u;
    uint m2 = gl_GlobalInvocationID.x / {pairs}u;
    uint from = ((gl_GlobalInvocationID.z * {n}u + m2) * {b}u) * {pairs}u + pair;
    uint to = (gl_GlobalInvocationID.z * {d}u + m2) * {c * n // 2}u + pair;
"""]
    for m1 in range(c):
        for n2 in range(b):
            text.append(f"    vec4 v{m1}_{n2} = texelFetch(source, int(from + "
                        f"{(d * m1 * b + n2) * pairs}u));\n")
    for m1 in range(c):
        ins = [(f"v{m1}_{n2}.xz", f"v{m1}_{n2}.yw") for n2 in range(b)]
        outs = [(f"xr{m1}_{k2}", f"xi{m1}_{k2}") for k2 in range(b)]
        if b == 1:
            text.append(f"    vec2 {outs[0][0]} = {ins[0][0]};\n    vec2 {outs[0][1]} = {ins[0][1]};\n")
        else:
            text.append(codelets.dft(b).glsl("vec2", ins, outs, prefix=f"x{m1}t"))
    if c > 1:
        text.append(twiddles("w", f"m2 * {2**32 // n}u", c))
    for k2 in range(b):
        ins = [(f"xr{m1}_{k2}", f"xi{m1}_{k2}") for m1 in range(c)]
        outs = [(f"yr{k2}_{j1}", f"yi{k2}_{j1}") for j1 in range(c)]
        if c == 1:
            outs = ins
        else:
            text.append(codelets.dft(c).glsl("vec2", ins, outs, prefix=f"y{k2}t"))
        for j1 in range(c):
            re, im = outs[j1]
            if j1:
                wr, wi = turned(re, im, "w", j1)
                text.append(f"    vec2 u{k2}_{j1} = {wr};\n    vec2 v{k2}_{j1}w = {wi};\n")
                re, im = f"u{k2}_{j1}", f"v{k2}_{j1}w"
            text.append(f"    target[to + {j1 * n // 2 + k2 * pairs}u] = "
                        f"vec4({re}.x, {im}.x, {re}.y, {im}.y);\n")
    text.append("}\n")
    return "".join(text)


def last_pass(n, c, d):
    text = [HEAD, "layout(binding = 0) uniform samplerBuffer source;\n", OUTPUT.format(binding=1), f"""
void main() {{
    uint pair = gl_GlobalInvocationID.x % {n // 2}u;
    uint j1 = gl_GlobalInvocationID.x / {n // 2}u;
    uint at = (gl_GlobalInvocationID.z * {n}u + j1) * {n // 2}u + pair;
"""]
    for m2 in range(d):
        text.append(f"    vec4 v{m2} = texelFetch(source, int(at + {m2 * c * n // 2}u));\n")
    text.append(codelets.dft(d).glsl("vec2", [(f"v{m}.xz", f"v{m}.yw") for m in range(d)],
                                     [(f"r{m}", f"i{m}") for m in range(d)]))
    for j2 in range(d):
        text.append(f"    target[at + {j2 * c * n // 2}u] = "
                    f"vec4(r{j2}.x, i{j2}.x, r{j2}.y, i{j2}.y);\n")
    text.append("}\n")
    return "".join(text)


def passes(n):
    """(kernel name, GLSL, invocations for one job or one slot)."""
    a, b, c, d = PLANS[n]
    made = [(f"w{n}_first", first_pass(n, a, b), b * n)]
    if b * c <= 256:
        made.append((f"w{n}_middle", middle_pass(n, a, b, c, d), a // 2 * d))
    else:
        made.append((f"w{n}_middle_x", middle_pass(n, a, b, 1, n), a // 2 * n))
        made.append((f"w{n}_middle_y", middle_pass(n, n, 1, c, d), n // 2 * d))
    made.append((f"w{n}_last", last_pass(n, c, d), n // 2 * c))
    return made


def spirv_words(path):
    data = pathlib.Path(path).read_bytes()
    return struct.unpack(f"<{len(data) // 4}I", data)


def embed(out, modules):
    text = ["// SPDX-License-Identifier: Apache-2.0\n// Written by shaders/generate.py.\n"
            '#include "shaders/synthesis.h"\n\nnamespace seaway::shaders {\n\nnamespace {\n\n']
    for name, path in modules.items():
        words = [f"0x{w:x}" for w in spirv_words(path)]
        lines = [",".join(words[i:i + 12]) for i in range(0, len(words), 12)]
        text.append(f"constexpr std::uint32_t {name}_words[] = {{\n" + ",\n".join(lines) + "};\n")
    for n in PLANS:
        text.append(f"constexpr Pass w{n}_passes[] = {{\n")
        for name, _, invocations in passes(n):
            text.append(f'    {{{{"{name}", {name}_words}}, {invocations // WORKGROUP}}},\n')
        text.append("};\n")
    text.append("constexpr Transform transforms[] = {\n")
    for n in PLANS:
        text.append(f'    {{{n}, "W", w{n}_passes}},\n')
    text.append("};\n\n} // namespace\n\n"
                "std::span<const Transform> synthesis_transforms() {\n    return transforms;\n}\n\n"
                'Shader jacobian() {\n    return {"jacobian", jacobian_words};\n}\n\n'
                "} // namespace seaway::shaders\n")
    pathlib.Path(out).write_text("".join(text), encoding="utf-8")


def main(arguments):
    if arguments[:1] == ["names"]:
        print("\n".join(name for n in PLANS for name, _, _ in passes(n)))
    elif arguments[:1] == ["glsl"] and len(arguments) == 2:
        for n in PLANS:
            for name, text, _ in passes(n):
                pathlib.Path(arguments[1], name + ".comp").write_text(text, encoding="utf-8")
    elif arguments[:1] == ["embed"] and len(arguments) > 2:
        embed(arguments[1], dict(module.split("=", 1) for module in arguments[2:]))
    else:
        print(__doc__, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
