// SPDX-License-Identifier: Apache-2.0
// Compiled with -O3 -march=native: what a user would write.
#include <cmath>

#include "tests/bench/fftw_evolve.h"

namespace seaway::bench {

namespace {

inline void sincos_library(std::uint32_t turns, float& sine, float& cosine) {
    const float x = static_cast<float>(static_cast<std::int32_t>(turns)) * 1.4629180792671596e-09f;
    sine = std::sin(x);
    cosine = std::cos(x);
}

} // namespace

void evolve_row_plain(const PlainModes& modes, std::uint64_t time_us, int iy,
                      float* const (&out)[packed_fields]) {
    evolve_row<sincos_library>(modes, time_us, iy, out);
}

void split_rows_plain(const float* packed, float* re, float* im, std::size_t values) {
    split(packed, re, im, values);
}

} // namespace seaway::bench
