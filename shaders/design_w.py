# SPDX-License-Identifier: Apache-2.0
"""Design W of the synthesis kernels, for any device: see generate.py."""
import codelets
from kernel_text import (EVOLVE_BINDINGS, EVOLVE_LINE, FIELDS_LINE, HEAD, band_end, each_field,
                         each_source, fields_bindings, kept, line_bindings, line_modes, map_bindings,
                         omitted, turned, twiddles, wavenumbers)

# size: (A, B)
PLANS = {64: (8, 8), 128: (16, 8), 256: (16, 16), 512: (16, 32), 1024: (32, 32), 2048: (64, 32)}


def columns(n, b, band):
    """Lines along y, rounded up to whole workgroups and to whole blocks of B of the lines along x."""
    whole = max(b, 16)
    return min(-(-band_end(n) // whole) * whole, n // 2) if band else n // 2


def main(fast, slow, count):
    """GLSL: the index that runs fastest over `count` invocations, and the other one."""
    return f"""
void main() {{
    uint invocation = gl_WorkGroupID.z * synthesis_workgroup + gl_LocalInvocationID.x;
    uint {fast} = invocation % {count}u;
    uint {slow} = invocation / {count}u;
"""


def codelet(a, blocks):
    return codelets.dft(a, omitted(blocks, a)).glsl(
        "float", [(f"z{i}.x", f"z{i}.y") for i in range(a)],
        [(f"r{i}", f"i{i}") for i in range(a)], indent=" " * 8)


def store_pairs(a, stride):
    """GLSL: r<k>, i<k> with their twiddles, two a vec4."""
    text = []
    for k in range(0, a, 2):
        even, odd = turned(f"r{k}", f"i{k}", "w", k), turned(f"r{k + 1}", f"i{k + 1}", "w", k + 1)
        text.append(f"        target[to + {k // 2 * stride}u] = vec4({', '.join(even + odd)});\n")
    return "".join(text)


def second_dft(b, stride):
    """GLSL: loads the pairs v<i>, DFT_B of both at once -> r<k>, i<k>."""
    loads = [f"    vec4 v{i} = texelFetch(source, from + {i * stride});\n" for i in range(b)]
    return "".join(loads) + codelets.dft(b).glsl(
        "vec2", [(f"v{i}.xz", f"v{i}.yw") for i in range(b)],
        [(f"r{i}", f"i{i}") for i in range(b)])


def evolve_pass(n, a, b, band):
    """Y = B n1 + n2: over n1 -> S[job][source][n2][k1 / 2][X]"""
    blocks = kept(n, a, band)
    count = columns(n, b, band)
    text = [HEAD, EVOLVE_BINDINGS, main("column", "n2", count), EVOLVE_LINE,
            f"    int base = int((job.x * {n}u + n2) * {n}u + column);\n",
            line_modes(blocks, a, b, "n2", b * n), twiddles("w", f"n2 * {2**32 // n}u", a),
            each_source(blocks), codelet(a, blocks),
            f"        uint to = (((job_index * push.sources + index) * {b}u + n2) * {a // 2}u) * "
            f"{count}u + column;\n", store_pairs(a, count), "    }\n}\n"]
    return "".join(text), count * b, count


def lines_y_pass(n, a, b, band):
    """Over n2 -> G[job][source][y / 2][X], y = k1 + A k2"""
    count = columns(n, b, band)
    text = [HEAD, line_bindings("vec4"), main("column", "pair", count),
            "    uint part = gl_WorkGroupID.y * push.sources + gl_WorkGroupID.x;\n"
            f"    int from = int((part * {n // 2}u + pair) * {count}u + column);\n"
            f"    uint to = (part * {n // 2}u + pair) * {count}u + column;\n"]
    text.append(second_dft(b, a // 2 * count))
    for k in range(b):
        text.append(f"    target[to + {k * a // 2 * count}u] = "
                    f"vec4(r{k}.x, i{k}.x, r{k}.y, i{k}.y);\n")
    text.append("}\n")
    return "".join(text), count * a // 2, count


def fields_pass(n, a, b, band):
    """X = B n1 + n2: over n1 -> U[job][field][y / 2][n2][k1]"""
    blocks = kept(n, a, band)
    count = columns(n, b, band)
    text = [HEAD, fields_bindings("vec4"), main("n2", "line", b), FIELDS_LINE,
            "    int from = int(((gl_WorkGroupID.y * push.sources + gl_WorkGroupID.x) * "
            f"{n // 2}u + line) * {count}u);\n"]
    for i in blocks:
        if i < a // 2:
            text.append(f"    vec2 s{i} = two_rows(texelFetch(source, from + int(n2) + "
                        f"{b * i}));\n")
        else:
            at = f"{n - b * i}u - n2"
            text.append(f"    vec2 s{i} = {at} < {count}u ? two_rows_mirrored(texelFetch(source, "
                        f"from + int({at}))) : vec2(0.0);\n")
    text += [wavenumbers(blocks, a, b, n, "n2"), twiddles("w", f"n2 * {2**32 // n}u", a),
             each_field(blocks, a), codelet(a, blocks),
             f"        uint to = (((gl_WorkGroupID.y * push.fields + field) * {n // 2}u + line) * "
             f"{b}u + n2) * {a // 2}u;\n", store_pairs(a, 1), "    }\n}\n"]
    return "".join(text), n // 2 * b, n // 2


def lines_x_pass(n, a, b):
    """Over n2 -> map[y][x], x = k1 + A k2"""
    text = [HEAD, map_bindings("vec2"), main("pair", "line", a // 2),
            "    uint part = gl_WorkGroupID.y * push.fields + gl_WorkGroupID.x;\n"
            f"    int from = int((part * {n // 2}u + line) * {n // 2}u + pair);\n"
            f"    uint to = (map_of(gl_WorkGroupID.x) * {n}u + 2u * line) * {n // 2}u + pair;\n"]
    text.append(second_dft(b, a // 2))
    for part, row in (("r", 0), ("i", n // 2)):
        for k in range(b):
            text.append(f"    target[to + {row + k * a // 2}u] = {part}{k};\n")
    text.append("}\n")
    return "".join(text), n // 2 * a // 2, 0


def passes(n, band):
    """(kernel name, kind of pass, GLSL, invocations for one job, source or field, vec4 a row), and the
    scratch that a field needs."""
    a, b = PLANS[n]
    suffix = "_band" if band else ""
    return [(f"w{n}_evolve{suffix}", "evolve", *evolve_pass(n, a, b, band)),
            (f"w{n}_lines_y{suffix}", "lines_y", *lines_y_pass(n, a, b, band)),
            (f"w{n}_fields{suffix}", "fields", *fields_pass(n, a, b, band)),
            (f"w{n}_lines_x", "lines_x", *lines_x_pass(n, a, b))], n * n // 2
