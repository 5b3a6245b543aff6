// SPDX-License-Identifier: Apache-2.0
// Compiled with -Ofast -march=native: the loops below become SIMD code.
#include "tests/bench/fftw_evolve.h"

namespace seaway::bench {

namespace {

/// Quadrant by integer, polynomials on the rest: what a good program would inline.
inline void sincos_inline(std::uint32_t turns, float& sine, float& cosine) {
    const std::uint32_t quadrant = (turns + 0x20000000u) >> 30;
    const float x = static_cast<float>(static_cast<std::int32_t>(turns - (quadrant << 30))) *
                    1.4629180792671596e-09f;
    const float xx = x * x;
    const float s =
        x + x * xx * ((xx * -1.9515295891e-4f + 8.3321608736e-3f) * xx - 1.6666654611e-1f);
    const float c = (xx * xx) * ((xx * 2.443315711809948e-5f - 1.388731625493765e-3f) * xx +
                                 4.166664568298827e-2f) -
                    xx * 0.5f + 1.0f;
    const float sine_size = (quadrant & 1u) != 0 ? c : s,
                cosine_size = (quadrant & 1u) != 0 ? s : c;
    sine = (quadrant & 2u) != 0 ? -sine_size : sine_size;
    cosine = ((quadrant + 1u) & 2u) != 0 ? -cosine_size : cosine_size;
}

} // namespace

void evolve_row_vectorised(const PlainModes& modes, std::uint64_t time_us, int iy,
                           float* const (&out)[packed_fields]) {
    evolve_row<sincos_inline>(modes, time_us, iy, out);
}

void split_rows_vectorised(const float* packed, float* re, float* im, std::size_t values) {
    split(packed, re, im, values);
}

} // namespace seaway::bench
