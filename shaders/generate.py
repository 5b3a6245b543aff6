#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the synthesis kernels (GLSL) and the table of them (C++).

Both designs are one inverse 2-D transform of N x N complex numbers per slot, without shared memory
or barriers inside a kernel. Reads go through texel buffers, writes are vec4 (two neighbouring
complex numbers; at the end of T, four points of a map). Why: docs/performance.md.

Design W, three passes, four above N = 512. N = A B along x and N = C D along y; mode X = B n1 + n2
goes to point x = k1 + A k2, mode Y = D m1 + m2 to point y = j1 + C j2:

    first   evolve; DFT_A over n1; twiddle w_N^(n2 k1)                  -> S[slot][Y][n2][k1]
    middle  DFT_B over n2; DFT_C over m1; twiddle w_N^(m2 j1)           -> T[slot][m2][j1][x]
    last    DFT_D over m2                                               -> map[slot][2][y][x]

Design T, two passes, for subgroups of S lanes. A subgroup transforms a line of N = S M: lane l holds
modes n = l + S m; DFT_M over m, twiddle w_N^(l k1), DFT_S across the lanes by shuffles leaves points
k1 + M bitreverse(l) in lane l:

    first   evolve; lines along y, one for each X                       -> T[slot][y / 2][X]
    last    lines along x                                               -> map[slot][2][y][x]

Each comes in two versions: for any modes, and for seas without modes at |nx| or |ny| >= 0.3 N (all
that are made from spectra: sea::band_end_share_of_nyquist), which skips what is known to be zero.

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
SUBGROUP_PLANS = {8: (64, 128, 256)}  # lanes: sizes
WORKGROUP = 64  # shared/synthesis.h


def kept(n, count, band):
    """Which of `count` equal blocks of the N modes of a line hold any: block i is modes
    i N / count ... Without `band` all do."""
    block = n // count
    first, end = (3 * n + 9) // 10, n - (3 * n + 9) // 10 + 1  # zero: first <= index < end
    blocks = [i for i in range(count) if not band or i * block < first or (i + 1) * block > end]
    assert blocks == [count - 1 - i for i in reversed(blocks)], "positive and negative alike"
    return blocks

HEAD = """#version 460
#extension GL_GOOGLE_include_directive : require
// SPDX-License-Identifier: Apache-2.0
// Written by shaders/generate.py.
#include "shared/synthesis.h"
#include "compute/evolve.glsl"

layout(local_size_x = synthesis_workgroup) in;
"""
SUBGROUP_HEAD = HEAD.replace("// SPDX", """#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_shuffle : require
// SPDX""", 1)
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


def omitted(blocks, count):
    return set(range(count)) - set(blocks)


def line_index(lines, n):
    """GLSL: from a running number of the lines kept to a mode index; both halves are equal."""
    return f"line < {lines // 2}u ? line : line + {n - lines}u" if lines < n else "line"


def slot_head(line_is_row):
    order = "" if line_is_row else "_along_y"
    fixed = "ky" if line_is_row else "kx"
    return f"""    for (uint slot = 0u; slot < push.slots; ++slot) {{
        int at_row = int(slot * slot_row_texels);
        Multiplier ma = multiplier{order}(texelFetch(rows, at_row), texelFetch(rows, at_row + 1), {fixed});
        Multiplier mb = multiplier{order}(texelFetch(rows, at_row + 2), texelFetch(rows, at_row + 3), {fixed});
        bvec4 flags = greaterThan(texelFetch(rows, at_row + 4), vec4(0.5));
"""


def line_modes(blocks, count, stride, start, fixed, step):
    """GLSL: evolves the modes start + stride i of a line, i in blocks."""
    text = []
    for i in blocks:
        shift = stride * (i if i < count // 2 else i - count)
        text.append(f"    float k{i} = wavenumber_step * float(int({start}) + {shift});\n"
                    f"    float square{i} = k{i} * k{i} + {fixed} * {fixed};\n"
                    f"    float inverse{i} = square{i} > 0.0 ? inversesqrt(square{i}) : 0.0;\n"
                    f"    vec4 h{i} = evolve(texelFetch(modes, base + {step * i}), "
                    f"texelFetch(rates, base + {step * i}).xy, job.yz);\n")
    return "".join(text)


def packed_line(blocks):
    return "".join(f"        vec2 z{i} = packed_fields(h{i}, at(ma, k{i}, inverse{i}), "
                   f"at(mb, k{i}, inverse{i}), flags);\n" for i in blocks)


def first_pass(n, a, b, d, band):
    blocks = kept(n, a, band)
    lines = len(kept(n, n // d, band)) * d
    text = [HEAD, FIRST_BINDINGS, OUTPUT.format(binding=4), MULTIPLIER, f"""
void main() {{
    uint n2 = gl_GlobalInvocationID.x % {b}u;
    uint line = gl_GlobalInvocationID.x / {b}u;
    uint row = {line_index(lines, n)};
    uvec4 job = texelFetch(jobs, int(gl_GlobalInvocationID.z));
    float wavenumber_step = uintBitsToFloat(job.w);
    float ky = wavenumber_step * float(row < {n // 2}u ? int(row) : int(row) - {n});
    int base = int((job.x * {n}u + row) * {n}u + n2);
"""]
    text.append(line_modes(blocks, a, b, "n2", "ky", b))
    text.append(twiddles("w", f"n2 * {2**32 // n}u", a))
    text.append(slot_head(True))
    text.append(packed_line(blocks))
    text.append(codelets.dft(a, omitted(blocks, a)).glsl(
        "float", [(f"z{i}.x", f"z{i}.y") for i in range(a)],
        [(f"r{i}", f"i{i}") for i in range(a)], indent=" " * 8))
    text.append(f"        uint to = (((gl_GlobalInvocationID.z * push.slots + slot) * {n}u + row) * "
                f"{b}u + n2) * {a // 2}u;\n")
    for k in range(0, a, 2):
        even, odd = turned(f"r{k}", f"i{k}", "w", k), turned(f"r{k + 1}", f"i{k + 1}", "w", k + 1)
        text.append(f"        target[to + {k // 2}u] = vec4({', '.join(even + odd)});\n")
    text.append("    }\n}\n")
    return "".join(text), lines * b


def middle_pass(n, a, b, c, d, band):
    """With C = 1 it is the rest of x alone, of the rows that the first pass wrote; with B = 1 (then
    A = N) the first half of y alone."""
    pairs = a // 2
    blocks = kept(n, c, band) if c > 1 else [0]
    split_d = PLANS[n][3]
    lines = d if c > 1 else len(kept(n, n // split_d, band)) * split_d
    text = [HEAD, "layout(binding = 0) uniform samplerBuffer source;\n", OUTPUT.format(binding=1), f"""
void main() {{
    uint pair = gl_GlobalInvocationID.x % {pairs}u;
    uint line = gl_GlobalInvocationID.x / {pairs}u;
    uint m2 = {line_index(lines, d)};
    uint from = ((gl_GlobalInvocationID.z * {n}u + m2) * {b}u) * {pairs}u + pair;
    uint to = (gl_GlobalInvocationID.z * {d}u + m2) * {c * n // 2}u + pair;
"""]
    for m1 in blocks:
        for n2 in range(b):
            text.append(f"    vec4 v{m1}_{n2} = texelFetch(source, int(from + "
                        f"{(d * m1 * b + n2) * pairs}u));\n")
    for m1 in blocks:
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
            text.append(codelets.dft(c, omitted(blocks, c)).glsl("vec2", ins, outs, prefix=f"y{k2}t"))
        for j1 in range(c):
            re, im = outs[j1]
            if j1:
                wr, wi = turned(re, im, "w", j1)
                text.append(f"    vec2 u{k2}_{j1} = {wr};\n    vec2 v{k2}_{j1}w = {wi};\n")
                re, im = f"u{k2}_{j1}", f"v{k2}_{j1}w"
            text.append(f"    target[to + {j1 * n // 2 + k2 * pairs}u] = "
                        f"vec4({re}.x, {im}.x, {re}.y, {im}.y);\n")
    text.append("}\n")
    return "".join(text), lines * pairs


def last_pass(n, c, d):
    text = [HEAD, "layout(binding = 0) uniform samplerBuffer source;\n",
            OUTPUT.format(binding=1).replace("vec4", "vec2"), f"""
void main() {{
    uint pair = gl_GlobalInvocationID.x % {n // 2}u;
    uint j1 = gl_GlobalInvocationID.x / {n // 2}u;
    uint from = (gl_GlobalInvocationID.z * {n}u + j1) * {n // 2}u + pair;
    uint to = (2u * gl_GlobalInvocationID.z * {n}u + j1) * {n // 2}u + pair;
"""]
    for m2 in range(d):
        text.append(f"    vec4 v{m2} = texelFetch(source, int(from + {m2 * c * n // 2}u));\n")
    text.append(codelets.dft(d).glsl("vec2", [(f"v{m}.xz", f"v{m}.yw") for m in range(d)],
                                     [(f"r{m}", f"i{m}") for m in range(d)]))
    for j2 in range(d):
        text.append(f"    target[to + {j2 * c * n // 2}u] = r{j2};\n")
    for j2 in range(d):
        text.append(f"    target[to + {n * n // 2 + j2 * c * n // 2}u] = i{j2};\n")
    text.append("}\n")
    return "".join(text), n // 2 * c


def lane_twiddles(lanes):
    """GLSL: turn<d>, what the stage of distance d multiplies with in this lane."""
    text = []
    d = lanes // 2
    while d > 1:
        text.append(f"    vec2 turn{d} = (lane & {d}u) != 0u ? "
                    f"unit_phasor((lane & {d - 1}u) * {2**31 // d}u) : vec2(1.0, 0.0);\n")
        d //= 2
    d = lanes // 2
    while d >= 1:
        text.append(f"    float sign{d} = (lane & {d}u) != 0u ? -1.0 : 1.0;\n")
        d //= 2
    text.append("    uint run = bitfieldReverse(lane) >> "
                f"{32 - (lanes.bit_length() - 1)}u;\n")
    return "".join(text)


def across_lanes(kind, lanes, name, indent):
    """GLSL: DFT over the lanes of (r<name>, i<name>), in place."""
    text = []
    d = lanes // 2
    while d >= 1:
        r, i = f"r{name}", f"i{name}"
        text.append(f"{indent}{r} = sign{d} * {r} + subgroupShuffleXor({r}, {d}u);\n"
                    f"{indent}{i} = sign{d} * {i} + subgroupShuffleXor({i}, {d}u);\n")
        if d > 1:
            text.append(f"{indent}{kind} q{name}_{d} = {r} * turn{d}.x - {i} * turn{d}.y;\n"
                        f"{indent}{i} = {r} * turn{d}.y + {i} * turn{d}.x;\n"
                        f"{indent}{r} = q{name}_{d};\n")
        d //= 2
    return "".join(text)


def in_lane(kind, n, lanes, blocks, inputs, indent):
    """GLSL: DFT over the modes of each lane, twiddle, DFT across the lanes -> r<k>, i<k>."""
    m = n // lanes
    text = [codelets.dft(m, omitted(blocks, m)).glsl(
        kind, inputs, [(f"a{k}", f"b{k}") for k in range(m)], indent=indent)]
    for k in range(m):
        re, im = turned(f"a{k}", f"b{k}", "w", k)
        text.append(f"{indent}{kind} r{k} = {re};\n{indent}{kind} i{k} = {im};\n")
        text.append(across_lanes(kind, lanes, k, indent))
    return "".join(text)


SUBGROUP_MAIN = """
void main() {{
    uint lane = gl_SubgroupInvocationID;
    uint line = gl_WorkGroupID.x * {lines}u + gl_SubgroupID;
"""


def subgroup_first_pass(n, lanes, band):
    m = n // lanes
    blocks = kept(n, m, band)
    lines = len(blocks) * lanes
    pitch = lines + 4
    text = [SUBGROUP_HEAD, FIRST_BINDINGS, OUTPUT.format(binding=4), MULTIPLIER,
            SUBGROUP_MAIN.format(lines=WORKGROUP // lanes), f"""    uint column = {line_index(lines, n)};
    uvec4 job = texelFetch(jobs, int(gl_GlobalInvocationID.z));
    float wavenumber_step = uintBitsToFloat(job.w);
    float kx = wavenumber_step * float(column < {n // 2}u ? int(column) : int(column) - {n});
    int base = int((job.x * {n}u + column) * {n}u + lane);
"""]
    text.append(line_modes(blocks, m, lanes, "lane", "kx", lanes))
    text.append(twiddles("w", f"lane * {2**32 // n}u", m))
    text.append(lane_twiddles(lanes))
    text.append(slot_head(False))
    text.append(packed_line(blocks))
    text.append(in_lane("float", n, lanes, blocks, [(f"z{i}.x", f"z{i}.y") for i in range(m)],
                        " " * 8))
    text.append(f"        uint to = ((gl_GlobalInvocationID.z * push.slots + slot) * {n // 2}u + "
                f"run * {m // 2}u) * {pitch}u + line;\n")
    for k in range(0, m, 2):
        text.append(f"        target[to + {k // 2 * pitch}u] = "
                    f"vec4(r{k}, i{k}, r{k + 1}, i{k + 1});\n")
    text.append("    }\n}\n")
    return "".join(text), lines * lanes, n * pitch


def subgroup_last_pass(n, lanes, band):
    m = n // lanes
    blocks = kept(n, m, band)
    pitch = len(blocks) * lanes + 4
    text = [SUBGROUP_HEAD, "layout(binding = 0) uniform samplerBuffer source;\n",
            OUTPUT.format(binding=1), SUBGROUP_MAIN.format(lines=WORKGROUP // lanes),
            f"    int from = int((gl_GlobalInvocationID.z * {n // 2}u + line) * {pitch}u + lane);\n"]
    for at, i in enumerate(blocks):
        text.append(f"    vec4 v{i} = texelFetch(source, from + {at * lanes});\n")
    text.append(twiddles("w", f"lane * {2**32 // n}u", m))
    text.append(lane_twiddles(lanes))
    text.append(in_lane("vec2", n, lanes, blocks, [(f"v{i}.xz", f"v{i}.yw") for i in range(m)],
                        " " * 4))
    text.append(f"    uint to = (2u * gl_GlobalInvocationID.z * {n}u + 2u * line) * {n // 4}u + "
                f"run * {m // 4}u;\n")
    for part, plane in (("r", 0), ("i", n * n // 4)):
        for axis, row in (("x", 0), ("y", n // 4)):
            for k in range(0, m, 4):
                values = ", ".join(f"{part}{k + i}.{axis}" for i in range(4))
                text.append(f"    target[to + {plane + row + k // 4}u] = vec4({values});\n")
    text.append("}\n")
    return "".join(text), n // 2 * lanes


def transforms():
    """All of them: (size, lanes or 0, band, largest scratch in complex numbers, passes), a pass being
    (kernel name, GLSL, invocations for one job or one slot). The best of a size come first."""
    made = []
    for band in (True, False):
        suffix = "_band" if band else ""
        for lanes, sizes in SUBGROUP_PLANS.items():
            for n in sizes:
                first, invocations, scratch = subgroup_first_pass(n, lanes, band)
                made.append((n, lanes, band, max(scratch, n * n),
                             [(f"t{lanes}_{n}_first{suffix}", first, invocations),
                              (f"t{lanes}_{n}_last{suffix}", *subgroup_last_pass(n, lanes, band))]))
        for n, (a, b, c, d) in PLANS.items():
            passes = [(f"w{n}_first{suffix}", *first_pass(n, a, b, d, band))]
            if b * c <= 256:
                passes.append((f"w{n}_middle{suffix}", *middle_pass(n, a, b, c, d, band)))
            else:
                passes.append((f"w{n}_middle_x{suffix}", *middle_pass(n, a, b, 1, n, band)))
                passes.append((f"w{n}_middle_y{suffix}", *middle_pass(n, n, 1, c, d, band)))
            passes.append((f"w{n}_last", *last_pass(n, c, d)))
            made.append((n, 0, band, n * n, passes))
    return made


def kernels():
    """name: GLSL; transforms may share a kernel."""
    return {name: text for *_, passes in transforms() for name, text, _ in passes}


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
    rows = []
    for n, lanes, band, scratch, passes in transforms():
        name = f"{f't{lanes}' if lanes else 'w'}_{n}{'_band' if band else ''}_passes"
        text.append(f"constexpr Pass {name}[] = {{\n")
        for kernel, _, invocations in passes:
            text.append(f'    {{{{"{kernel}", {kernel}_words}}, {invocations // WORKGROUP}}},\n')
        text.append("};\n")
        design = f"T{lanes}" if lanes else "W"
        rows.append(f'    {{{n}, "{design}", {lanes}, {str(band).lower()}, {scratch}, {name}}},\n')
    text += ["constexpr Transform transforms[] = {\n", *rows, "};\n\n} // namespace\n\n"
             "std::span<const Transform> synthesis_transforms() {\n    return transforms;\n}\n\n"
             'Shader jacobian() {\n    return {"jacobian", jacobian_words};\n}\n\n'
             "} // namespace seaway::shaders\n"]
    pathlib.Path(out).write_text("".join(text), encoding="utf-8")


def main(arguments):
    if arguments[:1] == ["names"]:
        print("\n".join(kernels()))
    elif arguments[:1] == ["glsl"] and len(arguments) == 2:
        for name, text in kernels().items():
            pathlib.Path(arguments[1], name + ".comp").write_text(text, encoding="utf-8")
    elif arguments[:1] == ["embed"] and len(arguments) > 2:
        embed(arguments[1], dict(module.split("=", 1) for module in arguments[2:]))
    else:
        print(__doc__, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
