# SPDX-License-Identifier: Apache-2.0
"""Design T of the synthesis kernels, for subgroups of a known size: see generate.py.

A line of N modes is the work of S lanes of a subgroup, M = N / S modes a lane, and the lanes exchange
what they need by shuffles. With X = l + S i the index of a mode and x = k + M j that of a point,

    X x / N  =  i k / M  +  l k / N  +  l j / S  +  a whole number,

so the transform of the line is: in each lane l a transform of its M modes (i -> k), a twiddle
e^(2 pi i l k / N), and for each k a transform across the lanes (l -> j). Before the last step lanes
and values change places, S values at a time, so that each lane has all it needs for its k. The
values k = g, g + M/S, g + 2 M/S ... are one group g of S values.

N = 8, S = 2, M = 4, thus two groups (as large as M / S):

                          lane 0                        lane 1
    load                  modes  0  2  4  6             modes  1  3  5  7           X = l + 2 i
    transform of M = 4    k      0  1  2  3             k      0  1  2  3           of its own modes
    twiddle               1  1  1  1                    1  w  w2 w3                 w = e^(2 pi i / 8)
    transpose, g = 0      k = 0  of lanes 0 and 1       k = 2  of lanes 0 and 1
    transpose, g = 1      k = 1  of lanes 0 and 1       k = 3  of lanes 0 and 1
    transform of S = 2    points 0, 4 (g = 0)           points 2, 6 (g = 0)         x = k + 4 j
                          points 1, 5 (g = 1)           points 3, 7 (g = 1)
    store                 0 1  and  4 5                 2 3  and  6 7

Points of neighbouring groups are neighbours in memory: a lane stores them as one vector.
"""
import codelets
from kernel_text import (EVOLVE_BINDINGS, EVOLVE_LINE, FIELDS_LINE, HEAD, WORKGROUP, each_field,
                         each_source, fields_bindings, kept, line_modes, omitted, turned, twiddles,
                         wavenumbers)

# size, lanes a line in the first and in the last pass. A line needs 2 lanes^2 modes, as the lanes
# are transposed and points stored in pairs; with fewer lanes each holds more, which compilers feel:
# 32 modes a lane are what a GPU has registers for, 64 are tried where it is measured.
PLANS = [(128, 8, 4), (256, 8, 8), (512, 8, 8), (512, 16, 16), (1024, 16, 16), (2048, 32, 32)]
SUBGROUP_HEAD = HEAD.replace("// SPDX", """#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_shuffle : require
// SPDX""", 1)


def transposed(lanes, names):
    """GLSL that swaps lanes and names: what lane l has under name j, lane j gets under name l."""
    text = []
    d = 1
    while d < lanes:
        for j in range(lanes):
            if j & d:
                continue
            a, b = names[j], names[j + d]
            text.append(f"        swapped = subgroupShuffleXor(bit{d} ? {a} : {b}, {d}u);\n"
                        f"        {a} = bit{d} ? swapped : {a};\n"
                        f"        {b} = bit{d} ? {b} : swapped;\n")
        d *= 2
    return "".join(text)


def line_transform(n, lanes, blocks):
    """GLSL that transforms the modes z<i> of each lane: DFT_M, twiddle, transpose, DFT_S. Lane l ends
    with the points M / S l + g + M j in (r<g>_<j>, i<g>_<j>)."""
    m = n // lanes
    text = [codelets.dft(m, omitted(blocks, m)).glsl(
        "float", [(f"z{i}.x", f"z{i}.y") for i in range(m)],
        [(f"a{k}", f"b{k}") for k in range(m)], indent=" " * 8)]
    for k in range(m):
        re, im = turned(f"a{k}", f"b{k}", "w", k)
        text.append(f"        float p{k} = {re};\n        float q{k} = {im};\n")
    text.append("        float swapped;\n")
    for g in range(m // lanes):
        ks = range(g, m, m // lanes)
        text += [transposed(lanes, [f"{part}{k}" for k in ks]) for part in "pq"]
        text.append(codelets.dft(lanes).glsl(
            "float", [(f"p{k}", f"q{k}") for k in ks],
            [(f"r{g}_{k}", f"i{g}_{k}") for k in range(lanes)], prefix=f"s{g}_", indent=" " * 8))
    return "".join(text)


def line_constants(n, lanes):
    """GLSL that computes bit<d> of the lane and its twiddles w<k>."""
    bits = [f"    bool bit{d} = (lane & {d}u) != 0u;\n" for d in (1, 2, 4, 8, 16) if d < lanes]
    return "".join(bits) + twiddles("w", f"lane * {2**32 // n}u", n // lanes)


def subgroup_main(lanes):
    return f"""
void main() {{
    uint lane = gl_SubgroupInvocationID & {lanes - 1}u;
    uint line = gl_WorkGroupID.z * {WORKGROUP // lanes}u +
        gl_SubgroupID * (gl_SubgroupSize / {lanes}u) + gl_SubgroupInvocationID / {lanes}u;
"""


def columns(n, lanes, band):
    """Lines along y: whole blocks of lanes, then whole workgroups."""
    blocks = len(kept(n, n // lanes, band)) // 2
    return -(-blocks * lanes * lanes // WORKGROUP) * WORKGROUP // lanes


def pitch(n, lanes, band):
    """vec4 from one pair of rows to the next in the memory between the passes; a few more than there
    are columns, as strides of powers of two would fall on few lines of a cache."""
    return columns(n, lanes, band) + 4


def evolve_pass(n, lanes, band):
    m = n // lanes
    blocks = kept(n, m, band)
    stride = pitch(n, lanes, band)
    text = [SUBGROUP_HEAD, EVOLVE_BINDINGS, subgroup_main(lanes), "    uint column = line;\n",
            EVOLVE_LINE, f"    int base = int((job.x * {n}u + column) * {n}u + lane);\n",
            line_modes(blocks, m, lanes, "lane", lanes), line_constants(n, lanes),
            each_source(blocks), line_transform(n, lanes, blocks),
            f"        uint to = ((job_index * push.sources + index) * {n // 2}u + "
            f"lane * {m // lanes // 2}u) * {stride}u + column;\n"]
    for k in range(lanes):
        for g in range(0, m // lanes, 2):
            text.append(f"        target[to + {(m * k + g) // 2 * stride}u] = "
                        f"vec4(r{g}_{k}, i{g}_{k}, r{g + 1}_{k}, i{g + 1}_{k});\n")
    text.append("    }\n}\n")
    return "".join(text), columns(n, lanes, band) * lanes, stride


def mirrored(blocks, m, lanes):
    """GLSL that makes s<i> of the negative half of a line out of the positive half in the other lanes.
    Mode -X of lane 0 is in lane 0 too, one block further on than those of the others."""
    text = ["    uint mirror = gl_SubgroupInvocationID - lane + "
            f"(({lanes}u - lane) & {lanes - 1}u);\n"]
    positive = [i for i in blocks if i < m // 2]
    for i in positive:
        own = f"two_rows_mirrored(v{i + 1})" if i + 1 in positive else "vec2(0.0)"
        text.append(f"    vec2 s{m - 1 - i} = subgroupShuffle(lane == 0u ? {own} : "
                    f"two_rows_mirrored(v{i}), mirror);\n")
    return "".join(text)


def fields_pass(n, first, lanes, band):
    m = n // lanes
    blocks = kept(n, m, band)
    run = min(4, m // lanes)  # neighbouring points in a lane
    text = [SUBGROUP_HEAD, fields_bindings(f"vec{run}"), subgroup_main(lanes), FIELDS_LINE,
            "    int from = int(((gl_WorkGroupID.y * push.sources + gl_WorkGroupID.x) * "
            f"{n // 2}u + line) * {pitch(n, first, band)}u + lane);\n"]
    for i in blocks:
        if i < m // 2:
            text.append(f"    vec4 v{i} = texelFetch(source, from + {i * lanes});\n"
                        f"    vec2 s{i} = two_rows(v{i});\n")
    text += [mirrored(blocks, m, lanes), wavenumbers(blocks, m, lanes, n, "lane"),
             line_constants(n, lanes), each_field(blocks, m), line_transform(n, lanes, blocks),
             f"        uint to = (map_of(field) * {n}u + 2u * line) * {n // run}u + "
             f"lane * {m // lanes // run}u;\n"]
    for part, row in (("r", 0), ("i", n // run)):
        for k in range(lanes):
            for g in range(0, m // lanes, run):
                values = ", ".join(f"{part}{g + i}_{k}" for i in range(run))
                text.append(f"        target[to + {row + (m * k + g) // run}u] = "
                            f"vec{run}({values});\n")
    text.append("    }\n}\n")
    return "".join(text), n // 2 * lanes, 0


def passes(n, first, last, band):
    """(kernel name, kind of pass, GLSL, invocations for one job or source, vec4 a row), and the
    scratch that a field needs."""
    name = f"t{max(first, last)}_{n}"
    suffix = "_band" if band else ""
    return [(f"{name}_evolve{suffix}", "evolve", *evolve_pass(n, first, band)),
            (f"{name}_fields{suffix}", "fields", *fields_pass(n, first, last, band))], \
        n * max(pitch(n, first, band), n // 2)
