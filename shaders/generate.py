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

Design T, two passes, for subgroups of S lanes. A subgroup transforms a line of N = S M: lane l
holds modes n = l + S m; DFT_M over m, twiddle w_N^(l k1), DFT_S across the lanes by shuffles leaves
points k1 + M bitreverse(l) in lane l:

    first   evolve; lines along y, one for each X                       -> T[slot][y / 2][X]
    last    lines along x                                               -> map[slot][2][y][x]

A single real field needs the lines of X >= 0 alone, and half of the last pass (design T).

Each comes in two versions: for any modes, and for seas without modes at |nx| or |ny| >= 0.3 N (all
that are made from spectra: sea::band_end_share_of_nyquist), which skips what is known to be zero.

    generate.py names                       kernel names, one a line
    generate.py glsl OUT_DIR                OUT_DIR/NAME.comp for every generated kernel
    generate.py embed OUT.cpp NAME=SPV ...  the C++ table
"""
import pathlib
import struct
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "tools"))
import design_t  # noqa: E402
import design_w  # noqa: E402
from kernel_text import WORKGROUP  # noqa: E402


def transforms():
    """All of them: (size, lanes or 0, band, largest scratch in complex numbers, passes, last pass of
    a single field or None), a pass being (kernel name, GLSL, invocations for one job or one slot).
    The best of a size come first."""
    made = []
    for band in (True, False):
        for lanes, sizes in design_t.PLANS.items():
            for n in sizes:
                passes, scratch = design_t.passes(n, lanes, band)
                single = design_t.single_pass(n, lanes, band)
                made.append((n, lanes, band, scratch, passes, single))
        made += [(n, 0, band, n * n, design_w.passes(n, band), None) for n in design_w.PLANS]
    return made


def kernels():
    """name: GLSL; transforms may share a kernel."""
    return {name: text for *_, passes, single in transforms()
            for name, text, _ in passes + ([single] if single else [])}


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
    def cpp_pass(made):
        name, _, invocations = made
        return f'{{{{"{name}", {name}_words}}, {invocations // WORKGROUP}}}'

    rows = []
    for n, lanes, band, scratch, passes, single in transforms():
        design = f"T{lanes}" if lanes else "W"
        name = f"{design.lower()}_{n}{'_band' if band else ''}_passes"
        text.append(f"constexpr Pass {name}[] = {{" + ", ".join(map(cpp_pass, passes)) + "};\n")
        last = cpp_pass(single) if single else "{}"
        rows.append(f'    {{{n}, "{design}", {lanes}, {str(band).lower()}, {scratch}, {name}, '
                    f'{last}}},\n')
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
