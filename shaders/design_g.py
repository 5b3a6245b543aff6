# SPDX-License-Identifier: Apache-2.0
"""Design G of the synthesis kernels, for GPUs: see generate.py.

A line of N modes is the work of P threads of a workgroup, M = N / P modes a thread, and they exchange what they need
by the memory that a workgroup shares. The line goes through steps of radices R1 R2 ... = N (Stockham's order: natural
going in and coming out). With L the product of the radices before a step of radix R, butterfly j < N / R

    takes       the values j + q N / R, q < R, each turned by e^(2 pi i q (j mod L) / (L R)),
    leaves      the values (j - j mod L) R + j mod L + q L,

and thread t has the butterflies j = t + P b, b < M / R: the values t + P i that it holds, i = b + q M / R, whatever
the radix. A step reads values that stand N / R apart, and so do neighbouring threads read and write neighbours.

N = 512, P = 64, M = 8: three steps of radix 8, one butterfly a thread each, two exchanges between them.

Nothing is asked of subgroups. One source a workgroup, evolved anew by each: a GPU has more arithmetic than it has work
for from one line after the other.
"""
import codelets
from kernel_text import (EVOLVE_BINDINGS, EVOLVE_LINE, FIELDS_LINE, HEAD, WORKGROUP, band_end, each_field,
                         fields_bindings, kept, line_modes, omitted, source_modes, turned, twiddles,
                         wavenumbers)

# size: threads a line, radices
PLANS = {64: (8, (8, 8)), 128: (16, (8, 4, 4)), 256: (32, (8, 8, 4)), 512: (64, (8, 8, 8)), 1024: (64, (16, 8, 8))}


class Line:
    """GLSL of one line: M values a thread, named r<i>, i<i> between steps."""

    def __init__(self, n, plan, side_by_side):
        """`side_by_side`: threads of the same place of neighbouring lines are neighbours, and so is what they write."""
        self.n = n
        self.threads, self.radices = plan
        self.m = n // self.threads
        self.lines = WORKGROUP // self.threads  # a workgroup
        self.side_by_side = side_by_side
        # Cells are left free so that neighbouring threads hit different ones of sixteen banks: one after every `pad` for
        # those that write a step of radix `pad`, some after each line for those of several lines.
        self.pad = self.radices[0]
        self.span = self.padded(n) + (16 // self.lines if side_by_side and self.lines > 1 else 0)

    def padded(self, cells):
        return cells + cells // self.pad

    def head(self):
        return (f"shared vec2 cells[{self.lines * self.span}];\n"
                f"uint place(uint value) {{\n    return value + value / {self.pad}u;\n}}\n")

    def main(self):
        thread, own = f"% {self.threads}u", f"/ {self.threads}u"
        if self.side_by_side:
            thread, own = f"/ {self.lines}u", f"% {self.lines}u"
        return f"""
void main() {{
    uint thread = gl_LocalInvocationID.x {thread};
    uint own_line = gl_LocalInvocationID.x {own};
    uint first_cell = own_line * {self.span}u;
    uint line = gl_WorkGroupID.z * {self.lines}u + own_line;
"""

    def constants(self):
        """Twiddles of all steps but the first, which has none: w<step>_<b>_<q>."""
        text, done = [], self.radices[0]
        for step, radix in enumerate(self.radices[1:], 1):
            for b in range(self.m // radix):
                if b and self.threads % done == 0:  # those of the first butterfly
                    break
                index = f"(thread + {self.threads * b}u) % {done}u * {2**32 // (done * radix)}u"
                text.append(twiddles(f"w{step}_{b}_", index, radix))
            done *= radix
        return "".join(text)

    def exchange(self, stores, loads):
        """Stores (cell, name) of all threads, then `loads` text."""
        barrier = "        barrier();\n"
        return barrier + "".join(f"        cells[{cell}] = vec2(r{i}, i{i});\n" for cell, i in stores) + barrier + loads

    def own_cells(self, tag):
        """GLSL that names the cell of value t, and the cells of all values t + P i."""
        text = f"        uint {tag} = first_cell + place(thread);\n"
        return text, [f"{tag} + {self.padded(self.threads * i)}u" for i in range(self.m)]

    def left_by(self, step, done, radix):
        """GLSL that names where a step leaves its values, and [(cell, value)]."""
        text, cells = [], []
        for b in range(self.m // radix):
            name = f"to{step}_{b}"
            j = f"(thread + {self.threads * b}u)"
            text.append(f"        uint {name} = first_cell + place({j} / {done}u * {done * radix}u + {j} % {done}u);\n")
            for q in range(radix):
                apart = done * q + (done * q // self.pad if done > 1 else 0)
                cells.append((f"{name} + {apart}u", b + q * (self.m // radix)))
        return "".join(text), cells

    def butterflies(self, step, radix, inputs, zeros=frozenset()):
        """GLSL of a step: values r<i>, i<i> from the expressions inputs[i]."""
        text = []
        own = self.m // radix
        for b in range(own):
            values = [b + q * own for q in range(radix)]
            empty = {q for q, i in enumerate(values) if i in zeros}
            text.append(codelets.dft(radix, empty).glsl(
                "float", [inputs[i] for i in values], [(f"s{step}r{i}", f"s{step}i{i}") for i in values],
                prefix=f"s{step}b{b}_", indent=" " * 8))
        text += [f"        {part}{i} = s{step}{part}{i};\n" for i in range(self.m) for part in "ri"]
        return "".join(text)

    def transform(self, blocks):
        """GLSL that turns z<i>, the modes t + P i, into the points t + P i, r<i> and i<i>."""
        text = ["        float " + ", ".join(f"r{i}, i{i}" for i in range(self.m)) + ";\n"]
        inputs = [(f"z{i}.x", f"z{i}.y") for i in range(self.m)]
        done = 1
        named, own = self.own_cells("own")
        text.append(named)
        for step, radix in enumerate(self.radices):
            if step:
                shared = self.threads % done == 0
                loads = "".join(f"        vec2 v{step}_{i} = cells[{own[i]}];\n" for i in range(self.m))
                text.append(self.exchange(cells, loads))
                inputs = [turned(f"v{step}_{i}.x", f"v{step}_{i}.y",
                                 f"w{step}_{0 if shared else i % (self.m // radix)}_", i // (self.m // radix))
                          for i in range(self.m)]
                for i, (re, im) in enumerate(inputs):  # which a codelet may use more than once
                    text.append(f"        float x{step}_{i} = {re}, y{step}_{i} = {im};\n")
                inputs = [(f"x{step}_{i}", f"y{step}_{i}") for i in range(self.m)]
            text.append(self.butterflies(step, radix, inputs, omitted(blocks, self.m) if not step else frozenset()))
            if step + 1 < len(self.radices):
                named, cells = self.left_by(step, done, radix)
                text.append(named)
            done *= radix
        return "".join(text)


def columns(n, band):
    """Lines along y: whole workgroups."""
    lines = WORKGROUP // PLANS[n][0]
    return -(-band_end(n) // lines) * lines if band else n // 2


def evolve_pass(n, band):
    """modes -> G[job][source][y / 2][X]"""
    line = Line(n, PLANS[n], True)
    m, threads = line.m, line.threads
    blocks = kept(n, m, band)
    count = columns(n, band)
    pairs = "".join(
        f"        vec2 even{s} = cells[pair + {line.padded(2 * threads * s)}u], "
        f"odd{s} = cells[pair + {line.padded(2 * threads * s) + 1}u];\n" for s in range(m // 2))
    named, own = line.own_cells("last")
    text = [HEAD, EVOLVE_BINDINGS, line.head(), line.main(), "    uint column = line;\n", EVOLVE_LINE,
            f"    int base = int((job.x * {n}u + column) * {n}u + thread);\n",
            line_modes(blocks, m, threads, "thread", threads), line.constants(),
            "    {\n        Source row = source_row(gl_WorkGroupID.x);\n", source_modes(blocks),
            line.transform(blocks), named, "        uint pair = first_cell + place(2u * thread);\n",
            line.exchange([(own[i], i) for i in range(m)], pairs),
            f"        uint to = ((job_index * push.sources + gl_WorkGroupID.x) * {n // 2}u + thread) * "
            f"{count}u + column;\n"]
    for s in range(m // 2):
        text.append(f"        target[to + {threads * s * count}u] = vec4(even{s}, odd{s});\n")
    text.append("    }\n}\n")
    return "".join(text), count * threads, count


def fields_pass(n, band):
    line = Line(n, PLANS[n], False)
    m, threads = line.m, line.threads
    blocks = kept(n, m, band)
    count = columns(n, band)
    text = [HEAD, fields_bindings("float"), line.head(), line.main(), FIELDS_LINE,
            "    int from = int(((gl_WorkGroupID.y * push.sources + gl_WorkGroupID.x) * "
            f"{n // 2}u + line) * {count}u);\n"]
    for i in blocks:
        if i < m // 2:
            at, whole = f"thread + {threads * i}u", threads * (i + 1) <= count
            rows = f"two_rows(texelFetch(source, from + int({at})))"
        else:
            at, whole = f"{n - threads * i}u - thread", n - threads * i < count
            rows = f"two_rows_mirrored(texelFetch(source, from + int({at})))"
        text.append(f"    vec2 s{i} = {rows};\n" if whole else
                    f"    vec2 s{i} = {at} < {count}u ? {rows} : vec2(0.0);\n")
    text += [wavenumbers(blocks, m, threads, n, "thread"), line.constants(), each_field(blocks, m),
             line.transform(blocks), f"        uint to = (map_of(field) * {n}u + 2u * line) * {n}u + thread;\n"]
    for i in range(m):
        text.append(f"        target[to + {threads * i}u] = r{i};\n"
                    f"        target[to + {n + threads * i}u] = i{i};\n")
    text.append("    }\n}\n")
    return "".join(text), n // 2 * threads, 0


def passes(n, band):
    """(kernel name, kind of pass, GLSL, invocations for one job and source, vec4 a row), and the scratch that a field
    needs."""
    suffix = "_band" if band else ""
    count = columns(n, band)
    return [(f"g{n}_evolve{suffix}", "evolve_source", *evolve_pass(n, band)),
            (f"g{n}_fields{suffix}", "fields", *fields_pass(n, band))], n * max(count, n // 2)
