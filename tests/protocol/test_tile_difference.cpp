// SPDX-License-Identifier: Apache-2.0
// Tiles in two forms, by themselves and as the difference to what is expected (protocol/tile_codec.h).
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "protocol/checksum.h"
#include "protocol/tile_codec.h"
#include "protocol/tile_layout.h"

namespace seaway::protocol {
namespace {

struct Tile {
    TileShape shape;
    std::size_t stride;
    std::vector<float> samples;
    std::vector<float> expected; ///< within `off` of them, evenly
};

Tile tile(TileShape shape, std::size_t stride, float height, float off, unsigned seed) {
    Tile made{shape, stride, {}, {}};
    std::mt19937 numbers(seed);
    std::uniform_real_distribution<float> any(-1.0f, 1.0f);
    const auto count = static_cast<std::size_t>(shape.height) * stride;
    for (std::size_t i = 0; i < count; ++i) {
        made.samples.push_back(height * std::sin(0.05f * static_cast<float>(i)) +
                               0.1f * height * any(numbers));
        made.expected.push_back(made.samples.back() + off * any(numbers));
    }
    return made;
}

bool same_bits(std::span<const float> a, std::span<const float> b, const Tile& of) {
    for (int y = 0; y < of.shape.height; ++y)
        if (std::memcmp(&a[static_cast<std::size_t>(y) * of.stride],
                        &b[static_cast<std::size_t>(y) * of.stride],
                        static_cast<std::size_t>(of.shape.width) * sizeof(float)) != 0)
            return false;
    return true;
}

struct Both {
    TileForms forms;
    std::vector<float> decoded;
};

Both both(const Tile& of, float error) {
    Both made;
    made.decoded.resize(of.samples.size());
    auto forms =
        encode_tile_forms(of.samples, of.shape, of.stride, error, of.expected, made.decoded);
    EXPECT_TRUE(forms);
    made.forms = *forms;
    return made;
}

TEST(TileDifference, both_forms_are_the_same_samples_within_the_bound) {
    for (const TileShape shape : {TileShape{1, 1}, {3, 2}, {80, 80}, {17, 256}, {256, 256}})
        for (const float height : {1e-3f, 3.0f, 900.0f})
            for (const float error : {1e-5f, 1e-3f, 0.2f})
                for (const float off : {0.0f, 0.3f, 2.0f, 40.0f, 3000.0f}) { // bounds
                    const Tile of = tile(shape, static_cast<std::size_t>(shape.width) + 3, height,
                                         off * error, 7);
                    const Both made = both(of, error);
                    std::vector<float> whole(of.samples.size()), difference = of.expected;
                    ASSERT_TRUE(decode_tile(made.forms.whole, shape, of.stride, whole));
                    EXPECT_TRUE(same_bits(whole, made.decoded, of));
                    for (int y = 0; y < shape.height; ++y)
                        for (int x = 0; x < shape.width; ++x) {
                            const auto at = static_cast<std::size_t>(y) * of.stride +
                                            static_cast<std::size_t>(x);
                            ASSERT_LE(std::abs(static_cast<double>(made.decoded[at]) -
                                               static_cast<double>(of.samples[at])),
                                      static_cast<double>(error));
                        }
                    if (made.forms.difference.empty())
                        continue;
                    ASSERT_TRUE(is_difference(made.forms.difference));
                    EXPECT_FALSE(is_difference(made.forms.whole));
                    // Where they were expected is where they may be put.
                    ASSERT_TRUE(decode_tile_difference(made.forms.difference, shape, of.stride,
                                                       difference, difference));
                    EXPECT_TRUE(same_bits(difference, made.decoded, of));
                }
}

// With a bound of a few steps of floats the lattice is finer than these are: just below a power of two they stand twice as close as
// above it, and the point nearest to a float is not always the one that it was rounded from.
TEST(TileDifference,
     both_forms_are_the_same_samples_also_where_floats_are_coarser_than_the_lattice) {
    std::mt19937 numbers(8);
    std::uniform_real_distribution<float> around(-4.0f, 4.0f), bounds(2.6f, 4.3f);
    int compared = 0;
    for (int round = 0; round < 4000; ++round) {
        const float power = std::ldexp(1.0f, round % 40 - 20), fine = std::ldexp(power, -23);
        Tile of{{40, 5}, 40, {}, {}};
        for (int i = 0; i < 200; ++i) {
            of.samples.push_back(power + fine * around(numbers));
            of.expected.push_back(power + fine * around(numbers));
        }
        const Both made = both(of, fine * bounds(numbers));
        std::vector<float> whole(of.samples.size()), difference(of.samples.size());
        ASSERT_TRUE(decode_tile(made.forms.whole, of.shape, of.stride, whole));
        ASSERT_TRUE(same_bits(whole, made.decoded, of)) << round;
        if (made.forms.difference.empty())
            continue;
        ++compared;
        ASSERT_TRUE(decode_tile_difference(made.forms.difference, of.shape, of.stride, of.expected,
                                           difference));
        ASSERT_TRUE(same_bits(difference, made.decoded, of)) << round;
    }
    EXPECT_GT(compared, 2000);
}

// What is expected within a twentieth of the bound needs no bits: a header, a check and an empty frame.
TEST(TileDifference, of_what_was_expected_there_is_nothing_to_send) {
    const Tile of = tile({80, 80}, 80, 3.0f, 5e-5f, 1);
    const Both made = both(of, 1e-3f);
    ASSERT_FALSE(made.forms.difference.empty());
    EXPECT_LT(made.forms.difference.size(), 80u);
    EXPECT_GT(made.forms.whole.size(), 6000u)
        << "noise of a tenth of 3 m, to a quarter of a millimetre";
}

// Off by one bound, evenly: the entropy of numbers -1, 0, 1 is 1.5 bits at most; zstd comes within a fifth.
TEST(TileDifference, off_by_a_bound_takes_two_bits_and_much_less_than_whole) {
    const Tile of = tile({160, 160}, 160, 3.0f, 1e-3f, 2);
    const Both made = both(of, 1e-3f);
    EXPECT_LT(8.0 * static_cast<double>(made.forms.difference.size()) / (160.0 * 160.0), 1.8);
    EXPECT_LT(3 * made.forms.difference.size(), made.forms.whole.size());
}

TEST(TileDifference, whoever_expected_something_else_is_told_so) {
    const Tile of = tile({40, 30}, 40, 3.0f, 1e-3f, 3);
    const Both made = both(of, 1e-3f);
    std::vector<float> out(of.samples.size());
    for (const float wrong : {3e-4f, 1.0f, -1e30f, std::numeric_limits<float>::infinity(),
                              std::numeric_limits<float>::quiet_NaN()}) {
        std::vector<float> other = of.expected;
        other[777] += wrong; // more than half a step of the fine lattice
        const auto decoded =
            decode_tile_difference(made.forms.difference, of.shape, 40, other, out);
        ASSERT_FALSE(decoded) << wrong;
        EXPECT_TRUE(decoded.error().is(TileMiss::other_expected)) << decoded.error().message;
    }
    // Rounding of the last bit, as another machine's might be, falls on the same step nearly everywhere.
    std::vector<float> nearly = of.expected;
    nearly[5] = std::nextafter(nearly[5], 10.0f);
    EXPECT_TRUE(decode_tile_difference(made.forms.difference, of.shape, 40, nearly, out));
}

TEST(TileDifference,
     nothing_useful_expected_or_nothing_to_be_quantised_leaves_the_whole_form_alone) {
    Tile of = tile({20, 20}, 20, 3.0f, 0, 4);
    for (const float wrong :
         {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 1e30f}) {
        Tile odd = of;
        odd.expected[7] = wrong;
        const Both made = both(odd, 1e-3f);
        EXPECT_TRUE(made.forms.difference.empty()) << wrong;
        EXPECT_EQ(made.forms.whole, *encode_tile(of.samples, of.shape, 20, 1e-3f));
    }
    for (const float error : {0.0f, 1e-8f, 1e-38f}) // finer than floats of this size
        EXPECT_TRUE(both(of, error).forms.difference.empty()) << error;
    std::fill(of.samples.begin(), of.samples.end(), 2.0f);
    EXPECT_TRUE(both(of, 1e-3f).forms.difference.empty()) << "a constant is sixteen bytes";
    of.samples[3] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_FALSE(encode_tile_forms(of.samples, of.shape, 20, 1e-3f, of.expected, of.expected));
}

TEST(TileDifference, each_form_is_refused_where_the_other_is_meant) {
    const Tile of = tile({9, 9}, 9, 3.0f, 1e-3f, 5);
    const Both made = both(of, 1e-3f);
    std::vector<float> out(of.samples.size());
    EXPECT_FALSE(decode_tile(made.forms.difference, of.shape, 9, out));
    const auto whole = decode_tile_difference(made.forms.whole, of.shape, 9, of.expected, out);
    ASSERT_FALSE(whole);
    EXPECT_FALSE(whole.error().is(TileMiss::other_expected)) << "that would ask for another stream";
}

// Bytes changed with a check sum that fits again, as only a hostile server sends them: an error or finite samples.
TEST(TileDifference, hostile_bytes_come_to_an_error_or_to_finite_samples) {
    const Tile of = tile({16, 16}, 16, 3.0f, 0.5f, 6);
    const Both made = both(of, 1e-3f);
    std::mt19937 numbers(11);
    std::vector<float> out(of.samples.size());
    int refused = 0;
    for (int i = 0; i < 20'000; ++i) {
        std::vector<std::uint8_t> bytes = made.forms.difference;
        for (int flips = 1 + static_cast<int>(numbers() % 3); flips > 0; --flips)
            bytes[numbers() % bytes.size()] ^= static_cast<std::uint8_t>(1u << numbers() % 8);
        if (numbers() % 4 == 0)
            bytes.resize(numbers() % bytes.size());
        if (bytes.size() >= tile_layout::header_bytes)
            tile_layout::put(&bytes[tile_layout::checksum_at], tile_checksum(bytes));
        const auto decoded = decode_tile_difference(bytes, of.shape, 16, of.expected, out);
        refused += decoded ? 0 : 1;
        for (std::size_t at = 0; decoded && at < out.size(); ++at)
            ASSERT_TRUE(std::isfinite(out[at]));
    }
    EXPECT_GT(refused, 19'000) << "the samples have a check of their own";
}

} // namespace
} // namespace seaway::protocol
