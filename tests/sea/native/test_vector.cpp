// SPDX-License-Identifier: Apache-2.0
#include "sea/native/vector.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

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
            worst = std::max(worst, std::abs(sine[lane] - std::sin(angle)));
            worst = std::max(worst, std::abs(cosine[lane] - std::cos(angle)));
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

} // namespace
} // namespace seaway::sea::native
