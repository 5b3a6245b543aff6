# SPDX-License-Identifier: Apache-2.0
"""Design W of the synthesis kernels: see generate.py."""
import codelets
from kernel_text import (FIRST_BINDINGS, HEAD, OUTPUT, kept, line_index, line_modes, omitted,
                         packed_line, slot_head, turned, twiddles)

# size: (A, B, C, D). At 1024 the middle pass would hold 1024 numbers, so it is cut in two.
PLANS = {64: (16, 4, 4, 16), 128: (32, 4, 8, 16), 256: (32, 8, 8, 32), 512: (32, 16, 16, 32),
         1024: (32, 32, 32, 32)}


def first_pass(n, a, b, d, band):
    blocks = kept(n, a, band)
    lines = len(kept(n, n // d, band)) * d
    text = [HEAD, FIRST_BINDINGS, OUTPUT.format(binding=4), f"""
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
    text.append(f"        uint to = (((gl_GlobalInvocationID.z * push.slots + slot) * {n}u + "
                f"row) * {b}u + n2) * {a // 2}u;\n")
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
    text = [HEAD, "layout(binding = 0) uniform samplerBuffer source;\n",
            OUTPUT.format(binding=1), f"""
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
            text.append(f"    vec2 {outs[0][0]} = {ins[0][0]};\n"
                        f"    vec2 {outs[0][1]} = {ins[0][1]};\n")
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
            codelet = codelets.dft(c, omitted(blocks, c))
            text.append(codelet.glsl("vec2", ins, outs, prefix=f"y{k2}t"))
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


def passes(n, band):
    """(kernel name, GLSL, invocations for one job or one slot)."""
    a, b, c, d = PLANS[n]
    suffix = "_band" if band else ""
    made = [(f"w{n}_first{suffix}", *first_pass(n, a, b, d, band))]
    if b * c <= 256:
        made.append((f"w{n}_middle{suffix}", *middle_pass(n, a, b, c, d, band)))
    else:
        made.append((f"w{n}_middle_x{suffix}", *middle_pass(n, a, b, 1, n, band)))
        made.append((f"w{n}_middle_y{suffix}", *middle_pass(n, n, 1, c, d, band)))
    made.append((f"w{n}_last", *last_pass(n, c, d)))
    return made
