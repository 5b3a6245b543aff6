#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the synthesis kernels (GLSL) and the table of them (C++).

Every field is real: the modes of -X are the conjugates of those of X, and it is transformed along
y for X >= 0 alone; fields that differ by a power of kx share that (shared/synthesis.h: sources).
Then two rows y, y + 1 of a map are the real and the imaginary part of one complex line along x. But for
design G no shared memory, no barriers inside a kernel. Reads go through texel buffers, writes are vec4 or vec2. Why:
docs/performance/maps.md.

    evolve, along y     modes -> G[source][y / 2][X], rows y and y + 1 in a vec4
    fields, along x     G -> map[y][x] of each field

Design T does each in one pass. S neighbouring lanes of a subgroup share a line of N = S M: lane l
holds modes n = l + S m; DFT_M over m, twiddle w_N^(l k1); a transposition by shuffles, after which
lane l holds k1 = M / S l + g of all lanes; DFT_S over them to points k1 + M k2.

Design W does each in two passes. N = A B: mode n = B n1 + n2 goes to point k = k1 + A k2; DFT_A
over n1, twiddle w_N^(n2 k1), through memory, DFT_B over n2.

Design G does each in one pass, too. A line is the work of some threads of a workgroup, which exchange what they need
by the memory that they share: design_g.py.

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
import design_g  # noqa: E402
import design_t  # noqa: E402
import design_w  # noqa: E402
from kernel_text import WORKGROUP  # noqa: E402


def transforms():
    """All of them: (size, design, lanes or 0, band, scratch of a field in complex numbers, passes), a pass
    being (kernel name, kind, GLSL, invocations for one job, source or field, vec4 a row)."""
    made = []
    for band in (True, False):
        for n, first, last in design_t.PLANS:
            passes, scratch = design_t.passes(n, first, last, band)
            made.append((n, f"T{max(first, last)}", max(first, last), band, scratch, passes))
        for n in design_w.PLANS:
            passes, scratch = design_w.passes(n, band)
            made.append((n, "W", 0, band, scratch, passes))
        for n in design_g.PLANS:
            passes, scratch = design_g.passes(n, band)
            made.append((n, "G", 0, band, scratch, passes))
    return made


def kernels():
    """name: GLSL; transforms may share a kernel."""
    return {name: text for *_, passes in transforms() for name, _, text, *_ in passes}


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
    for n, design, lanes, band, scratch, passes in transforms():
        list_name = f"{design.lower()}_{n}{'_band' if band else ''}_passes"
        listed = []
        for name, kind, _, invocations, row in passes:
            assert invocations % WORKGROUP == 0, name
            listed.append(f'{{{{"{name}", {name}_words}}, PassKind::{kind}, '
                          f'{invocations // WORKGROUP}, {row}}}')
        text.append(f"constexpr Pass {list_name}[] = {{" + ", ".join(listed) + "};\n")
        transposed, shared = str(design != "W").lower(), str(design == "G").lower()
        rows.append(f'    {{{n}, "{design}", {lanes}, {transposed}, {shared}, {str(band).lower()}, {scratch}, '
                    f'{list_name}}},\n')
    text += ["constexpr Transform transforms[] = {\n", *rows, "};\n\n} // namespace\n\n"
             "std::span<const Transform> synthesis_transforms() {\n    return transforms;\n}\n\n"
             'Shader jacobian() {\n    return {"jacobian", jacobian_words};\n}\n\n'
             'Shader foam() {\n    return {"foam", foam_words};\n}\n\n'
             'Shader round() {\n    return {"round", round_words};\n}\n\n'
             'Shader copy() {\n    return {"copy", copy_words};\n}\n\n'
             'Shader peak() {\n    return {"peak", peak_words};\n}\n\n'
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
