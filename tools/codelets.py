#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""FFT codelets: the one place where butterflies are written.

A codelet is the straight-line inverse DFT of 2, 4, 8, 16, 32 or 64 complex numbers,

    X[k] = sum_n x[n] exp(+2 pi i n k / N),      unnormalised, natural order in and out,

as a list of statements on reals (conjugate-pair split radix; constants folded, common terms shared).
The same list is printed as GLSL, for the kernels of shaders/generate.py, or as C++, for the native
synthesizer. Every value is of one type V that stands for one line of data or for several lines side
by side: float, vec2, vec4 in GLSL; float or any SIMD type in C++.

From Python (GLSL, inlined into a kernel):

    import codelets
    text = codelets.dft(8).glsl("vec2", inputs=[("r0", "i0"), ...], outputs=[("a0", "b0"), ...])
    codelets.dft(8, zeros={3, 4})     # x[3] and x[4] are zero: what they would cost is left out

From CMake (C++, one header with namespace seaway::codelets):

    codelets.py cpp OUT.h           # radices 2 4 8 16 32
    codelets.py cpp OUT.h 4 8       # these only

    template <class V> struct Complex { V re, im; };
    template <class V, class S = float, class M = Rounded> inline void dft8(Complex<V> (&z)[8]);
    template <class V, class S = float, class M = Rounded> void dft(Complex<V> (&z)[N]); // by the extent

Both work in place. V needs V + V, V - V, -V and V * S (S is the type of the constants): float, double
with S = double, GCC vector types (typedef float F8 __attribute__((vector_size(32)))), and wrapper
classes all do. Sums of products stand in the header as calls of M, so that not the compiler but whoever
includes it decides what is fused: M::add(a, s, c) = a s + c, M::subtract(a, s, c) = a s - c,
M::subtract_from(c, a, s) = c - a s. Rounded rounds product and sum. Keep z in a local array: its
indices are constants, so it lives in registers as far as they reach (radix 16 needs 32 of them).

    codelets.py check               # every radix against the sum above; prints the operation counts
"""
import math
import sys

RADICES = (2, 4, 8, 16, 32, 64)
CPP_RADICES = (2, 4, 8, 16, 32)


class Codelet:
    """Statements on reals. A value is (sign, id), or None for zero; ids below 2 N are the inputs
    (re, im of x[n])."""

    def __init__(self, n, zeros=frozenset()):
        self.n = n
        self.statements = []  # (id, op, a, b): op '+', '-': ids a, b; op '*': id a, float b
        self.known = {}
        z = [(None, None) if i in zeros else ((1, 2 * i), (1, 2 * i + 1)) for i in range(n)]
        self.outputs = self._dft(z)

    def _emit(self, op, a, b):
        key = (op, a, b)
        if key not in self.known:
            self.known[key] = 2 * self.n + len(self.statements)
            self.statements.append((self.known[key], op, a, b))
        return self.known[key]

    def _add(self, a, b):
        if a is None or b is None:
            return b if a is None else a
        if a[0] > 0 and b[0] > 0:
            return 1, self._emit("+", min(a[1], b[1]), max(a[1], b[1]))
        if a[0] > 0 or b[0] > 0:
            left, right = (a[1], b[1]) if a[0] > 0 else (b[1], a[1])
            if ("-", right, left) in self.known:
                return -1, self.known[("-", right, left)]
            return 1, self._emit("-", left, right)
        return -1, self._emit("+", min(a[1], b[1]), max(a[1], b[1]))

    def _sub(self, a, b):
        return self._add(a, self._negate(b))

    @staticmethod
    def _negate(a):
        return None if a is None else (-a[0], a[1])

    def _scale(self, a, factor):
        if a is None:
            return None
        if abs(factor) == 1.0:
            return (a[0] if factor > 0 else -a[0]), a[1]
        sign = a[0] if factor > 0 else -a[0]
        return sign, self._emit("*", a[1], abs(factor))

    def _cadd(self, a, b):
        return self._add(a[0], b[0]), self._add(a[1], b[1])

    def _csub(self, a, b):
        return self._sub(a[0], b[0]), self._sub(a[1], b[1])

    def _twiddle(self, z, k, n):
        """z * exp(+2 pi i k / n), 0 <= k < n/4 or its negative."""
        if k == 0:
            return z
        c, s = math.cos(2 * math.pi * k / n), math.sin(2 * math.pi * k / n)
        re, im = z
        if 8 * abs(k) == n:  # (1 +- i) / sqrt 2
            c = math.sqrt(0.5)
            plus, minus = self._add(re, im), self._sub(re, im)
            if k > 0:
                return self._scale(minus, c), self._scale(plus, c)
            return self._scale(plus, c), self._scale(self._sub(im, re), c)
        return (self._sub(self._scale(re, c), self._scale(im, s)),
                self._add(self._scale(re, s), self._scale(im, c)))

    def _dft(self, x):
        n = len(x)
        if n == 1:
            return x
        if n == 2:
            return [self._cadd(x[0], x[1]), self._csub(x[0], x[1])]
        even = self._dft(x[0::2])
        up = self._dft([x[(4 * m + 1) % n] for m in range(n // 4)])
        down = self._dft([x[(4 * m - 1) % n] for m in range(n // 4)])
        out = [None] * n
        for k in range(n // 4):
            a, b = self._twiddle(up[k], k, n), self._twiddle(down[k], -k, n)
            total, (dre, dim) = self._cadd(a, b), self._csub(a, b)
            turned = (self._negate(dim), dre)  # i (a - b)
            out[k] = self._cadd(even[k], total)
            out[k + n // 2] = self._csub(even[k], total)
            out[k + n // 4] = self._cadd(even[k + n // 4], turned)
            out[k + 3 * n // 4] = self._csub(even[k + n // 4], turned)
        return out

    def counts(self):
        """(additions, multiplications)"""
        products = sum(1 for s in self.statements if s[1] == "*")
        return len(self.statements) - products, products

    def lines(self, declare, names, outputs, prefix, constant):
        """Statements as text. `names`: text of each input id; `outputs`: assignments' left sides."""
        names = dict(enumerate(names))
        text = []
        for ident, op, a, b in self.statements:
            names[ident] = f"{prefix}{ident - 2 * self.n}"
            right = constant(b) if op == "*" else names[b]
            text.append(f"{declare} {names[ident]} = {names[a]} {op} {right};")
        for (sign, ident), left in zip((v for z in self.outputs for v in z), outputs):
            text.append(f"{left} = {'-' if sign < 0 else ''}{names[ident]};")
        return text

    def glsl(self, kind, inputs, outputs, prefix="t", indent="    "):
        """GLSL text. inputs: n pairs (re, im) of expressions without side effects (anything for a
        zero); outputs: n pairs of names, declared here with type `kind`."""
        flat = [name for pair in inputs for name in pair]
        left = [f"{kind} {name}" for pair in outputs for name in pair]
        body = self.lines(kind, flat, left, prefix, lambda c: f"{c:.9g}" if c != int(c) else f"{c:.1f}")
        return "".join(f"{indent}{line}\n" for line in body)

    def sums_of_products(self):
        """{id of a sum: id of the product that it takes in}, and the products that some statement
        still needs by themselves. Of two products in one sum the earlier is taken in."""
        products = {s[0] for s in self.statements if s[1] == "*"}
        taken, needed = {}, {ident for z in self.outputs for _, ident in z}
        for ident, op, a, b in self.statements:
            if op == "*":
                needed.add(a)
                continue
            inside = sorted(products & {a, b})
            if inside and a != b:
                taken[ident] = inside[0]
            needed |= {a, b} - {taken.get(ident)}
        return taken, products & needed

    def cpp_lines(self):
        """Statements as C++, with sums of products as one call."""
        names = {i: f"x{i}" for i in range(2 * self.n)}
        names |= {s[0]: f"t{s[0] - 2 * self.n}" for s in self.statements}
        factors = {s[0]: f"{names[s[2]]}, S({s[3]!r})" for s in self.statements if s[1] == "*"}
        taken, needed = self.sums_of_products()
        for ident, op, a, b in self.statements:
            if ident in taken and op == "+":
                value = f"M::add({factors[taken[ident]]}, {names[b if taken[ident] == a else a]})"
            elif ident in taken and taken[ident] == a:
                value = f"M::subtract({factors[a]}, {names[b]})"
            elif ident in taken:
                value = f"M::subtract_from({names[a]}, {factors[b]})"
            elif op != "*":
                value = f"{names[a]} {op} {names[b]}"
            elif ident in needed:
                value = f"{names[a]} * S({b!r})"
            else:
                continue
            yield f"const V {names[ident]} = {value};"
        for i, (re, im) in enumerate(self.outputs):
            for part, (sign, ident) in (("re", re), ("im", im)):
                yield f"z[{i}].{part} = {'-' if sign < 0 else ''}{names[ident]};"

    def cpp(self):
        """A C++ function template dftN."""
        flat = [f"z[{i}].{part}" for i in range(self.n) for part in ("re", "im")]
        loads = [f"const V x{i} = {name};" for i, name in enumerate(flat)]
        adds, products = self.counts()
        text = "".join(f"    {line}\n" for line in [*loads, *self.cpp_lines()])
        return (f"/// {adds} additions, {products} multiplications, "
                f"{len(self.sums_of_products()[0])} of them together.\n"
                f"template <class V, class S = float, class M = Rounded>\n"
                f"SEAWAY_CODELET void dft{self.n}(Complex<V> (&z)[{self.n}]) {{\n{text}}}\n")

    def run(self, x):
        """Evaluates the statements on Python complex numbers."""
        value = [part for z in x for part in (z.real, z.imag)] + [0.0] * len(self.statements)
        for ident, op, a, b in self.statements:
            value[ident] = {"+": lambda: value[a] + value[b], "-": lambda: value[a] - value[b],
                            "*": lambda: value[a] * b}[op]()
        return [complex(re[0] * value[re[1]], im[0] * value[im[1]]) for re, im in self.outputs]


_made = {}


def dft(n, zeros=frozenset()):
    """The codelet of radix n; inputs whose index is in `zeros` are known to be zero (not all)."""
    key = (n, frozenset(zeros))
    if n not in RADICES or len(key[1]) >= n:
        raise ValueError(f"no codelet of radix {n} with zeros {sorted(zeros)}: have {RADICES}")
    if key not in _made:
        _made[key] = Codelet(*key)
    return _made[key]


def cpp_header(radices):
    parts = ["// SPDX-License-Identifier: Apache-2.0\n"
             "// Written by tools/codelets.py; see there. Inverse DFT, unnormalised, natural order.\n"
             "#pragma once\n\n"
             "#if defined(__GNUC__)\n"
             "#define SEAWAY_CODELET [[gnu::always_inline]] inline\n"
             "#else\n"
             "#define SEAWAY_CODELET inline\n"
             "#endif\n\n"
             "namespace seaway::codelets {\n\n"
             "template <class V>\nstruct Complex {\n    V re, im;\n};\n\n"
             "/// Sums of products, each product rounded.\n"
             "struct Rounded {\n"
             "    template <class V, class S>\n"
             "    static V add(V a, S s, V c) {\n        return a * s + c;\n    }\n"
             "    template <class V, class S>\n"
             "    static V subtract(V a, S s, V c) {\n        return a * s - c;\n    }\n"
             "    template <class V, class S>\n"
             "    static V subtract_from(V c, V a, S s) {\n        return c - a * s;\n    }\n"
             "};\n"]
    for n in radices:
        parts.append("\n" + dft(n).cpp())
    parts.append("\n/// By the extent of the array.\n"
                 "template <class V, class S = float, class M = Rounded, int n>\n"
                 "SEAWAY_CODELET void dft(Complex<V> (&z)[n]) {\n")
    for i, n in enumerate(radices):
        parts.append(f"    {'else ' if i else ''}if constexpr (n == {n})\n        dft{n}<V, S, M>(z);\n")
    parts.append("    else\n        static_assert(n == 0, \"no codelet of this radix\");\n}\n")
    parts.append("\n} // namespace seaway::codelets\n\n#undef SEAWAY_CODELET\n")
    return "".join(parts)


def check():
    import cmath
    import random
    random.seed(1)
    for n in RADICES:
        for zeros in ((), range(3 * n // 8, 5 * n // 8)):
            x = [0 if m in zeros else complex(random.gauss(0, 1), random.gauss(0, 1))
                 for m in range(n)]
            truth = [sum(x[m] * cmath.exp(2j * math.pi * m * k / n) for m in range(n))
                     for k in range(n)]
            worst = max(abs(a - b) for a, b in zip(dft(n, zeros).run(x), truth))
            adds, products = dft(n, zeros).counts()
            print(f"radix {n:2}, {len(zeros):2} zeros: {adds:4} additions, {products:3} "
                  f"multiplications, error {worst:.1e}")
            if worst > 1e-13 * n:
                return 1
    return 0


def main(arguments):
    if arguments[:1] == ["check"]:
        return check()
    if len(arguments) >= 2 and arguments[0] == "cpp":
        radices = [int(a) for a in arguments[2:]] or CPP_RADICES
        with open(arguments[1], "w", encoding="utf-8") as out:
            out.write(cpp_header(radices))
        return 0
    print(__doc__, file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
