// SPDX-License-Identifier: Apache-2.0
// The inner loop of Regrid: discrete Fourier transforms of 16 lines side by side, several instruction sets.
//
// Stockham's autosort algorithm, any product of 2, 3, 4 and 5 (Van Loan 1992, "Computational Frameworks for
// the Fast Fourier Transform"): X[k] = sum_n x[n] exp(-2 pi i n k / N). The other direction is
// the same with real and imaginary parts exchanged. The same bits for all instruction sets: nothing is fused.
#pragma once

namespace seaway::sea {

inline constexpr int lines_at_once = 16;

/// Numbers are [n][re, im][line].
struct LineTransform {
    int length;
    const int* radices; ///< their product is `length`
    int radix_count;
    const float*
        twiddles; ///< stage by stage, for p = 0 .. left/r - 1 and j = 1 .. r - 1: re, im of exp(-2 pi i j p / left)
};

/// Transforms `data`; `other` is room for as much. Returns which of the two holds the result.
using LineKernel = float* (*)(const LineTransform& transform, float* data, float* other);

// One a translation unit that is compiled for them.
float* transform_lines_portable(const LineTransform& transform, float* data, float* other);
float* transform_lines_avx2(const LineTransform& transform, float* data, float* other);

} // namespace seaway::sea
