# SPDX-License-Identifier: Apache-2.0
"""Pieces of GLSL that both designs of synthesis kernels are made of (generate.py)."""
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
FIRST_BINDINGS = """#include "compute/fields.glsl"
layout(binding = 0) uniform samplerBuffer modes;  // (h0(k), conj h0(-k))
layout(binding = 1) uniform usamplerBuffer rates;
layout(binding = 2) uniform usamplerBuffer jobs;
layout(binding = 3) uniform samplerBuffer rows;
"""


def kept(n, count, band):
    """Which of `count` equal blocks of the N modes of a line hold any: block i is modes
    i N / count ... Without `band` all do."""
    block = n // count
    first, end = (3 * n + 9) // 10, n - (3 * n + 9) // 10 + 1  # zero: first <= index < end
    blocks = [i for i in range(count) if not band or i * block < first or (i + 1) * block > end]
    assert blocks == [count - 1 - i for i in reversed(blocks)], "positive and negative alike"
    return blocks


def twiddles(name, turns, count):
    """vec2 NAMEk = w^k for k < count. Powers of two are computed, the others are products of at
    most log2 k of them; powers of one w would be wrong by k times its rounding error."""
    text = []
    for k in range(1, count):
        top = 1 << (k.bit_length() - 1)
        a, b = f"{name}{top}", f"{name}{k - top}"
        text.append(f"    vec2 {name}{k} = unit_phasor({turns} * {k}u);\n" if k == top else
                    f"    vec2 {name}{k} = vec2({a}.x * {b}.x - {a}.y * {b}.y, "
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
        vec4 row_a0 = texelFetch(rows, at_row), row_a1 = texelFetch(rows, at_row + 1);
        vec4 row_b0 = texelFetch(rows, at_row + 2), row_b1 = texelFetch(rows, at_row + 3);
        Multiplier ma = multiplier{order}(row_a0, row_a1, {fixed});
        Multiplier mb = multiplier{order}(row_b0, row_b1, {fixed});
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
