// SPDX-License-Identifier: Apache-2.0
#include "sea/native/vector.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "base/instructions.h"
#include "base/worse.h"
#include "sea/native/kernels.h"

namespace seaway::sea::native {
namespace {

// Polynomials are good to 4e-8; two roundings of 6e-8 and the rounded angle add the rest.
TEST(Vector, sine_and_cosine_are_right_to_2e7_in_every_quadrant) {
    double worst = 0;
    // All of the circle in steps of a prime number, and what lies next to the quadrant borders.
    for (std::uint64_t i = 0; i < (std::uint64_t{1} << 32); i += 40'009) {
        const auto at = static_cast<std::uint32_t>(i);
        const std::uint32_t border = (at & 0xe0000000u) - 2u;
        const Lanes<4>::U turns = {at, border, border + 2u, border + 3u};
        Lanes<4>::F sine, cosine;
        sincos_turns<4>(turns, sine, cosine);
        for (int lane = 0; lane < 4; ++lane) {
            const double angle = turns[lane] * (2 * std::numbers::pi / 0x1p32);
            worst = worse(worst, std::abs(sine[lane] - std::sin(angle)));
            worst = worse(worst, std::abs(cosine[lane] - std::cos(angle)));
        }
    }
    EXPECT_LT(worst, 2e-7);
}

TEST(Vector, transposition_swaps_rows_and_lanes) {
    Lanes<4>::F v[4];
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
            v[i][j] = static_cast<float>(10 * i + j);
    transpose<4>(v);
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
            EXPECT_EQ(v[i][j], static_cast<float>(10 * j + i));
}

// What is rounded once stands in the source: a compiler that fused a product and a sum by itself might
// do so in one list of fields and not in another.
TEST(FusedProducts, no_compiler_fuses_what_is_not_written_so) {
    // (1 + e)^2 with e = 2^-12: the e^2 is lost when the product is rounded, and only then.
    const volatile float factor = 1 + 0x1p-12f, rest = -(1 + 0x1p-11f);
    for (int size = 16; size <= 1024; size *= 2)
        for (Instructions instructions : supported_instructions()) {
            const Kernels* kernels = portable_kernels(size);
#if defined(SEAWAY_X86)
            if (instructions == Instructions::avx2)
                kernels = avx2_kernels(size);
            if (instructions == Instructions::avx512)
                kernels = avx512_kernels(size);
#endif
            EXPECT_EQ(kernels->product_then_sum(factor, factor, rest), 0) << name(instructions);
        }
}

} // namespace
} // namespace seaway::sea::native
