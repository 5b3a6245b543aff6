// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <sstream>

#include "sea/basics/gaussian.h"
#include "sea/basics/philox.h"
#include "tests/sea/csv.h"

namespace seaway::sea {
namespace {

TEST(Random, P20_A24_philox_gives_the_known_answers) {
    const testing::Table table("P20_random123_kat");
    int rows = 0;
    for (std::size_t r = 0; r < table.size(); ++r) {
        if (table.text(r, "generator") != "philox4x32" || table.text(r, "rounds") != "10")
            continue;
        std::istringstream words(table.text(r, "hex_words_counter_then_key_then_output"));
        words >> std::hex;
        PhiloxCounter counter{};
        PhiloxKey key{};
        PhiloxCounter expected{};
        for (auto* block : {counter.data(), counter.data() + 1, counter.data() + 2,
                            counter.data() + 3, key.data(), key.data() + 1, expected.data(),
                            expected.data() + 1, expected.data() + 2, expected.data() + 3})
            words >> *block;
        ASSERT_TRUE(words);
        EXPECT_EQ(philox4x32_10(counter, key), expected);
        ++rows;
    }
    EXPECT_EQ(rows, 3);
}

// Naive: u = 0 gives log(0) = -inf, once in 2^32 draws.
TEST(Random, A23_the_extreme_words_give_finite_numbers) {
    for (const std::uint32_t radius : {0u, 1u, 0x7FFFFFFFu, 0x80000000u, 0xFFFFFFFFu})
        for (const std::uint32_t angle : {0u, 0x3FFFFFFFu, 0x40000000u, 0x80000000u, 0xFFFFFFFFu}) {
            const GaussianPair xi = gaussian_from_words(radius, angle);
            // sqrt(2 ln 2^33) = 6.764 at radius word 0.
            EXPECT_TRUE(std::isfinite(xi.real) && std::abs(xi.real) < 6.77);
            EXPECT_TRUE(std::isfinite(xi.imaginary) && std::abs(xi.imaginary) < 6.77);
        }
}

TEST(Random, own_logarithm_and_circle_functions_agree_with_the_library) {
    for (std::uint32_t i = 0; i < 20000; ++i) {
        const std::uint32_t a = i * 214013u + 2531011u;
        const std::uint32_t b = i * 1664525u + 1013904223u;
        const GaussianPair xi = gaussian_from_words(a, b);
        const double radius = std::sqrt(-2.0 * std::log((a + 0.5) * 0x1p-32));
        const double angle = 2.0 * 3.14159265358979323846 * ((b + 0.5) * 0x1p-32);
        // A few roundings of numbers below 7, and of the angle.
        ASSERT_NEAR(xi.real, radius * std::cos(angle), 1e-14);
        ASSERT_NEAR(xi.imaginary, radius * std::sin(angle), 1e-14);
    }
}

TEST(Random, A24_numbers_are_normal_and_neighbours_are_independent) {
    double sum = 0, square = 0, fourth = 0, product = 0, opposite = 0;
    const int n = 256;
    for (int ny = -n; ny < n; ++ny)
        for (int nx = -n; nx < n; ++nx) {
            const GaussianPair xi = gaussian_pair({42, 0, 1021000, nx, ny});
            const GaussianPair mirror = gaussian_pair({42, 0, 1021000, -nx, -ny});
            sum += xi.real + xi.imaginary;
            square += xi.real * xi.real + xi.imaginary * xi.imaginary;
            fourth += std::pow(xi.real, 4) + std::pow(xi.imaginary, 4);
            product += xi.real * xi.imaginary;
            if (nx != 0 || ny != 0)
                opposite += xi.real * mirror.real + xi.imaginary * mirror.imaginary;
        }
    const double count = 2.0 * (2 * n) * (2 * n);
    // Standard errors of mean, variance, fourth moment and correlations; 4 of them each, 3 between k and -k (A24).
    EXPECT_NEAR(sum / count, 0.0, 4.0 / std::sqrt(count));
    EXPECT_NEAR(square / count, 1.0, 4.0 * std::sqrt(2.0 / count));
    EXPECT_NEAR(fourth / count, 3.0, 4.0 * std::sqrt(96.0 / count));
    EXPECT_NEAR(product / (count / 2), 0.0, 4.0 / std::sqrt(count / 2));
    EXPECT_NEAR(opposite / count, 0.0, 3.0 * std::sqrt(2.0 / count)); // each pair comes twice
}

// Naive: a float hash collides, and depends on how k was rounded.
TEST(Random, A24_a_million_modes_draw_a_million_different_pairs) {
    std::set<std::pair<double, double>> seen;
    for (std::int32_t i = 0; i < 1000000; ++i) {
        const GaussianPair xi = gaussian_pair({7, 1, 197000, i % 1000 - 500, i / 1000 - 500});
        seen.insert({xi.real, xi.imaginary});
    }
    EXPECT_EQ(seen.size(), 1000000u);
}

TEST(Random, I24_every_part_of_the_key_matters) {
    const ModeKey base{42, 0, 1021000, 3, -4};
    const double reference = gaussian_pair(base).real;
    EXPECT_EQ(reference, gaussian_pair(base).real);
    for (const ModeKey& other :
         {ModeKey{43, 0, 1021000, 3, -4}, ModeKey{42ull | 1ull << 40, 0, 1021000, 3, -4},
          ModeKey{42, 1, 1021000, 3, -4}, ModeKey{42, 0, 197000, 3, -4},
          ModeKey{42, 0, 1021000, -3, -4}, ModeKey{42, 0, 1021000, 3, 4}})
        EXPECT_NE(reference, gaussian_pair(other).real);
}

// Pinned: a change of these bits is a change of every sea ever saved.
TEST(Random, numbers_are_the_same_bits_for_ever) {
    const GaussianPair xi = gaussian_pair({42, 0, 1021000, 3, -4});
    EXPECT_EQ(xi.real, -0x1.51ed05b5ed66bp-1);
    EXPECT_EQ(xi.imaginary, 0x1.09f7034effb99p-1);
    EXPECT_EQ(cascade_key(1021.0), 1021000u);
    EXPECT_EQ(cascade_key(1e6), 1000000000u);
}

} // namespace
} // namespace seaway::sea
