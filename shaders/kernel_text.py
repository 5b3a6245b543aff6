# SPDX-License-Identifier: Apache-2.0
"""Pieces of GLSL that all designs of synthesis kernels are made of (generate.py)."""
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
    {kind} target[];
}};
layout(push_constant) uniform Push {{
    SynthesisPush push;
}};
"""
FIELDS = '#include "compute/fields.glsl"\n'
# What each kind of pass reads; server/device/vulkan_kernels.cpp expects the same.
EVOLVE_BINDINGS = """layout(binding = 0) uniform samplerBuffer modes;  // (h0(k), conj h0(-k))
layout(binding = 1) uniform usamplerBuffer rates;
layout(binding = 2) uniform usamplerBuffer jobs;
layout(binding = 3) uniform samplerBuffer rows;
layout(binding = 4) uniform samplerBuffer orbits;  // coth(|k| d)
""" + OUTPUT.format(binding=5, kind="vec4") + FIELDS
FIELDS_READ = """layout(binding = 0) uniform samplerBuffer source;
layout(binding = 1) uniform usamplerBuffer jobs;
layout(binding = 2) uniform samplerBuffer rows;
"""


def fields_bindings(kind):
    return FIELDS_READ + OUTPUT.format(binding=3, kind=kind) + FIELDS


def line_bindings(kind):
    return ("layout(binding = 0) uniform samplerBuffer source;\n" +
            OUTPUT.format(binding=1, kind=kind))


def map_bindings(kind):
    return ("layout(binding = 0) uniform samplerBuffer source;\n"
            "layout(binding = 1) uniform samplerBuffer rows;\n" +
            OUTPUT.format(binding=2, kind=kind) + FIELDS)


def band_end(n):
    """No mode of a band-limited sea has this index or a larger one (shaders::fits_band)."""
    return (3 * n + 9) // 10


def kept(n, count, band):
    """Which of `count` equal blocks of the N modes of a line hold any: block i is modes
    i N / count ... Without `band` all do. As many of negative modes as of positive ones."""
    block = n // count
    return [i for i in range(count)
            if not band or min(i, count - 1 - i) * block < band_end(n)]


def omitted(blocks, count):
    return set(range(count)) - set(blocks)


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


# job and kx of a pass that evolves; `column` is the line's X.
EVOLVE_LINE = """    uint job_index = gl_WorkGroupID.y;
    uvec4 job = texelFetch(jobs, int(job_index));
    float wavenumber_step = uintBitsToFloat(job.w);
    float kx = wavenumber_step * float(column);
"""


def line_modes(blocks, count, block, start, step):
    """GLSL: evolves the modes Y = start + block i of a line along y, i in blocks; `step` texels
    from one to the next."""
    text = []
    for i in blocks:
        shift = block * (i if i < count // 2 else i - count)
        text.append(f"    float k{i} = wavenumber_step * float(int({start}) + {shift});\n"
                    f"    float square{i} = k{i} * k{i} + kx * kx;\n"
                    f"    float over_k{i} = square{i} > 0.0 ? inversesqrt(square{i}) * "
                    f"texelFetch(orbits, base + {step * i}).x : 0.0;\n"
                    f"    vec4 h{i} = evolve(texelFetch(modes, base + {step * i}), "
                    f"texelFetch(rates, base + {step * i}).xy, job.yz);\n")
    return "".join(text)


def source_modes(blocks):
    """GLSL: z<i>, the modes of the source of `row`."""
    return "".join(f"        vec2 z{i} = source_mode(row, h{i}, k{i}, over_k{i});\n" for i in blocks)


def each_source(blocks):
    """GLSL: opens the loop over sources; z<i> are the modes of one."""
    return ("    for (uint index = 0u; index < push.sources; ++index) {\n"
            "        Source row = source_row(index);\n" + source_modes(blocks))


# Of a pass that turns the lines of a source into those of its fields.
FIELDS_LINE = """    uvec4 job = texelFetch(jobs, int(gl_WorkGroupID.y));
    float wavenumber_step = uintBitsToFloat(job.w);
    uvec2 fields = fields_of(gl_WorkGroupID.x);
"""


def wavenumbers(blocks, count, block, n, start):
    """GLSL: k<i> = |kx| of the modes X = start + block i of a line along x."""
    return "".join(
        f"    float k{i} = wavenumber_step * float(" +
        (f"{start} + {block * i}u);\n" if i < count // 2 else f"{n - block * i}u - {start});\n")
        for i in blocks)


def each_field(blocks, count):
    """GLSL: opens the loop over the fields of a source; z<i> are the modes of one, made of s<i>,
    those of the source for two rows."""
    text = ["    for (uint field = fields.x; field < fields.y; ++field) {\n"
            "        vec4 row = field_row(field);\n"
            "        bool odd = row.w > 0.5;\n"]
    for i in blocks:
        turn = "times_i" if i < count // 2 else "times_minus_i"
        text.append(f"        vec2 z{i} = along_x(row, k{i}) * {turn}(s{i}, odd);\n")
    return "".join(text)
