# SPDX-License-Identifier: Apache-2.0
"""Design T of the synthesis kernels, for subgroups of a known size: see generate.py."""
import codelets
from kernel_text import (FIRST_BINDINGS, HEAD, OUTPUT, WORKGROUP, kept, line_index, line_modes,
                         omitted, packed_line, slot_head, turned, twiddles)

PLANS = {8: (64, 128, 256, 512)}  # lanes: sizes
SUBGROUP_HEAD = HEAD.replace("// SPDX", """#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_shuffle : require
// SPDX""", 1)


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


def first_pass(n, lanes, band):
    m = n // lanes
    blocks = kept(n, m, band)
    lines = len(blocks) * lanes
    pitch = lines + 4
    text = [SUBGROUP_HEAD, FIRST_BINDINGS, OUTPUT.format(binding=4),
            SUBGROUP_MAIN.format(lines=WORKGROUP // lanes), f"""\
    uint column = {line_index(lines, n)};
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


def last_pass(n, lanes, band):
    m = n // lanes
    blocks = kept(n, m, band)
    pitch = len(blocks) * lanes + 4
    text = [SUBGROUP_HEAD, "layout(binding = 0) uniform samplerBuffer source;\n",
            OUTPUT.format(binding=1), SUBGROUP_MAIN.format(lines=WORKGROUP // lanes),
            f"    int from = int((gl_GlobalInvocationID.z * {n // 2}u + line) * {pitch}u + "
            "lane);\n"]
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


def single_last_pass(n, lanes, band):
    """Of one real field alone: the lines of -X are the conjugates of those of X, which alone were
    transformed, and two rows y, y + 1 of the map are one complex transform."""
    m = n // lanes
    blocks = kept(n, m, band)
    pitch = len(blocks) * lanes + 4
    text = [SUBGROUP_HEAD, "layout(binding = 0) uniform samplerBuffer source;\n",
            OUTPUT.format(binding=1), SUBGROUP_MAIN.format(lines=WORKGROUP // lanes),
            f"    int from = int((gl_GlobalInvocationID.z * {n // 2}u + line) * {pitch}u);\n"]
    for i in blocks:
        if i < m // 2:
            text.append(f"    vec4 v{i} = texelFetch(source, from + {i * lanes} + int(lane));\n"
                        f"    vec2 z{i} = vec2(v{i}.x - v{i}.w, v{i}.y + v{i}.z);\n")
        else:
            text.append(f"    vec4 v{i} = texelFetch(source, from + {n - i * lanes} - int(lane));\n"
                        f"    vec2 z{i} = vec2(v{i}.x + v{i}.w, v{i}.z - v{i}.y);\n")
    edge = min(i for i in blocks if i >= m // 2)  # its first mode is zero, and its line not written
    text.append(f"    z{edge} = lane == 0u ? vec2(0.0) : z{edge};\n")
    text.append(twiddles("w", f"lane * {2**32 // n}u", m))
    text.append(lane_twiddles(lanes))
    text.append(in_lane("float", n, lanes, blocks, [(f"z{i}.x", f"z{i}.y") for i in range(m)],
                        " " * 4))
    text.append(f"    uint to = (2u * gl_GlobalInvocationID.z * {n}u + 2u * line) * {n // 4}u + "
                f"run * {m // 4}u;\n")
    for part, row in (("r", 0), ("i", n // 4)):
        for k in range(0, m, 4):
            values = ", ".join(f"{part}{k + i}" for i in range(4))
            text.append(f"    target[to + {row + k // 4}u] = vec4({values});\n")
    text.append("}\n")
    return "".join(text), n // 2 * lanes


def single_pass(n, lanes, band):
    """The last pass where a job is one real field; the first one then runs for X >= 0 only."""
    return (f"t{lanes}_{n}_last_single{'_band' if band else ''}", *single_last_pass(n, lanes, band))


def passes(n, lanes, band):
    """(kernel name, GLSL, invocations for one job or one slot), and the scratch they need."""
    suffix = "_band" if band else ""
    first, invocations, scratch = first_pass(n, lanes, band)
    return [(f"t{lanes}_{n}_first{suffix}", first, invocations),
            (f"t{lanes}_{n}_last{suffix}", *last_pass(n, lanes, band))], max(scratch, n * n)
