// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "protocol/checksum.h"
#include "protocol/tile_codec.h"
#include "tests/protocol/sample_tiles.h"
#include "tests/support/largest_difference.h"

namespace seaway::protocol {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes encoded(std::span<const float> samples, TileShape shape, float error) {
    auto bytes = encode_tile(samples, shape, static_cast<std::size_t>(shape.width), error);
    EXPECT_TRUE(bytes.has_value()) << (bytes ? "" : bytes.error().message);
    return bytes ? *bytes : Bytes{};
}

std::vector<float> decoded(std::span<const std::uint8_t> bytes, TileShape shape) {
    std::vector<float> samples(static_cast<std::size_t>(shape.width * shape.height));
    const auto fine = decode_tile(bytes, shape, static_cast<std::size_t>(shape.width), samples);
    EXPECT_TRUE(fine.has_value()) << (fine ? "" : fine.error().message);
    return samples;
}

std::vector<float> random_samples(TileShape shape, double scale, std::uint64_t seed) {
    std::mt19937_64 numbers(seed);
    std::normal_distribution<double> normal(0, scale);
    std::vector<float> samples(static_cast<std::size_t>(shape.width * shape.height));
    for (float& sample : samples)
        sample = static_cast<float>(normal(numbers));
    return samples;
}

TEST(TileCodec, crc32_has_the_check_value_of_its_definition) {
    const std::string_view text = "123456789";
    EXPECT_EQ(crc32({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}),
              0xCBF43926u);
}

TEST(TileCodec, f1_f2_all_zero_and_constant_tiles_are_sixteen_bytes_and_exact) {
    for (const float value : {0.0f, -0.0f, 1e-38f, 3e4f, -1e-45f, 3.4e38f}) {
        const std::vector<float> samples(64 * 64, value);
        const Bytes bytes = encoded(samples, {64, 64}, 0.01f);
        EXPECT_EQ(bytes.size(), 16u);
        const std::vector<float> back = decoded(bytes, {64, 64});
        EXPECT_EQ(std::memcmp(back.data(), samples.data(), samples.size() * sizeof(float)), 0);
    }
}

TEST(TileCodec, a_tile_flatter_than_its_bound_is_constant) {
    for (const float mean : {2.0f, 0.7f, -0.7f, -2.0f, -1e4f}) {
        std::vector<float> samples = random_samples({32, 32}, 1e-5, 1);
        for (float& sample : samples)
            sample += mean;
        const Bytes bytes = encoded(samples, {32, 32}, 0.05f);
        EXPECT_EQ(bytes.size(), 16u) << mean;
        EXPECT_LE(seaway::tests::largest_difference(samples, decoded(bytes, {32, 32})), 0.05)
            << mean;
    }
}

TEST(TileCodec, f3_samples_that_are_not_finite_are_refused) {
    for (const float bad :
         {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
          -std::numeric_limits<float>::infinity()}) {
        std::vector<float> samples(17 * 5, 1.0f);
        samples[40] = bad;
        EXPECT_FALSE(encode_tile(samples, {17, 5}, 17, 0.01f).has_value());
        EXPECT_FALSE(encode_tile(samples, {17, 5}, 17, 0.0f).has_value());
    }
}

TEST(TileCodec, bad_calls_are_errors) {
    const std::vector<float> samples(16 * 16, 1.0f);
    std::vector<float> out(16 * 16);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_FALSE(encode_tile(samples, {0, 16}, 16, 0.1f).has_value());
    EXPECT_FALSE(encode_tile(samples, {16, 257}, 16, 0.1f).has_value());
    EXPECT_FALSE(encode_tile(samples, {16, 16}, 15, 0.1f).has_value());
    EXPECT_FALSE(encode_tile(samples, {16, 17}, 16, 0.1f).has_value());
    EXPECT_FALSE(encode_tile(samples, {16, 16}, 16, -1.0f).has_value());
    EXPECT_FALSE(encode_tile(samples, {16, 16}, 16, nan).has_value());
    const Bytes bytes = encoded(samples, {16, 16}, 0.1f);
    EXPECT_FALSE(decode_tile(bytes, {16, 15}, 16, out).has_value());
    EXPECT_FALSE(decode_tile(bytes, {16, 16}, 17, out).has_value());
}

TEST(TileCodec, f4_error_zero_is_bit_exact_for_every_kind_of_float) {
    std::mt19937_64 numbers(4);
    std::vector<float> samples(61 * 67);
    for (float& sample : samples)
        do
            sample = std::bit_cast<float>(static_cast<std::uint32_t>(numbers()));
        while (!std::isfinite(sample));
    samples[0] = -0.0f;
    samples[1] = 0.0f;
    const std::vector<float> back = decoded(encoded(samples, {61, 67}, 0), {61, 67});
    EXPECT_EQ(std::memcmp(back.data(), samples.data(), samples.size() * sizeof(float)), 0);
}

TEST(TileCodec, f5_one_spike_among_small_values_keeps_the_bound) {
    std::vector<float> samples = random_samples({64, 64}, 1e-3, 5);
    samples[2000] = 1e4f;
    for (const float error : {1e-2f, 1e-3f, 1e-4f, 1e-6f}) {
        const std::vector<float> back = decoded(encoded(samples, {64, 64}, error), {64, 64});
        EXPECT_LE(seaway::tests::largest_difference(samples, back), static_cast<double>(error));
    }
}

TEST(TileCodec, f6_the_bound_holds_after_rounding_to_float_at_every_scale) {
    // Values and bounds of every relation, down to bounds of a few units in the last place, where
    // the decoder's rounding eats the margin.
    std::mt19937_64 numbers(6);
    std::uniform_real_distribution<double> exponent(-20, 20);
    std::uniform_real_distribution<double> ratio(-9, 1);
    for (int round = 0; round < 4000; ++round) {
        const TileShape shape{16, 16};
        const double scale = std::pow(10, exponent(numbers));
        const auto error = static_cast<float>(scale * std::pow(10, ratio(numbers)));
        std::vector<float> samples =
            random_samples(shape, scale, static_cast<std::uint64_t>(round));
        if (round % 3 == 0) // exact ties
            for (std::size_t i = 0; i < samples.size(); ++i)
                samples[i] = error * (static_cast<float>(i) - 100.5f);
        const std::vector<float> back = decoded(encoded(samples, shape, error), shape);
        ASSERT_LE(seaway::tests::largest_difference(samples, back), static_cast<double>(error))
            << "round " << round << " scale " << scale << " error " << error;
    }
}

TEST(TileCodec, f8_every_truncation_and_every_byte_flip_is_an_error) {
    // Single-byte changes are within CRC-32's guarantee: none may pass.
    const std::vector<float> samples = random_samples({24, 19}, 1, 8);
    for (const float error : {0.0f, 0.01f, 20.0f}) {
        const Bytes bytes = encoded(samples, {24, 19}, error);
        std::vector<float> out(24 * 19);
        for (std::size_t length = 0; length < bytes.size(); ++length)
            EXPECT_FALSE(
                decode_tile(std::span(bytes).first(length), {24, 19}, 24, out).has_value());
        for (std::size_t at = 0; at < bytes.size(); ++at)
            for (int flip = 1; flip < 256; ++flip) {
                Bytes bad = bytes;
                bad[at] = static_cast<std::uint8_t>(bad[at] ^ flip);
                EXPECT_FALSE(decode_tile(bad, {24, 19}, 24, out).has_value()) << "byte " << at;
            }
    }
}

TEST(TileCodec, f8_hostile_bytes_with_a_right_checksum_are_errors_or_finite) {
    // What a hostile peer can do and a broken wire cannot: change bytes and sign them.
    const std::vector<float> samples = random_samples({24, 19}, 1, 9);
    std::mt19937_64 numbers(9);
    int passed = 0;
    for (const float error : {0.0f, 0.01f, 1e-4f}) {
        const Bytes bytes = encoded(samples, {24, 19}, error);
        for (int round = 0; round < 3000; ++round) {
            Bytes bad = bytes;
            for (std::uint64_t flips = 1 + numbers() % 3; flips > 0; --flips)
                bad[numbers() % bad.size()] = static_cast<std::uint8_t>(numbers());
            if (numbers() % 4 == 0)
                bad.resize(16 + numbers() % (bad.size() - 15));
            const std::uint32_t checksum = tile_checksum(bad);
            std::memcpy(&bad[12], &checksum, 4);
            std::vector<float> out(24 * 19 + 1, 7.0f);
            if (decode_tile(bad, {24, 19}, 24, out).has_value()) {
                ++passed;
                for (const float sample : out)
                    ASSERT_TRUE(std::isfinite(sample));
            }
            ASSERT_EQ(out.back(), 7.0f);
        }
    }
    EXPECT_GT(passed, 0) << "the test never got past the checksum";
}

TEST(TileCodec, f8_a_tile_that_holds_less_than_its_shape_is_an_error) {
    const std::vector<float> samples = random_samples({24, 19}, 1, 9);
    for (const float error : {0.0f, 0.01f}) {
        Bytes bytes = encoded(samples, {24, 19}, error);
        bytes[4] = 20; // rows
        const std::uint32_t checksum = tile_checksum(bytes);
        std::memcpy(&bytes[12], &checksum, 4);
        std::vector<float> out(24 * 20);
        EXPECT_FALSE(decode_tile(bytes, {24, 20}, 24, out).has_value());
    }
}

constexpr TileShape small{5, 3};

/// Signed anew.
std::string why_not(Bytes bytes) {
    const std::uint32_t checksum = tile_checksum(bytes);
    std::memcpy(&bytes[12], &checksum, 4);
    std::vector<float> out(15);
    const auto fine = decode_tile(bytes, small, 5, out);
    return fine ? std::string() : fine.error().message;
}
std::string byte(Bytes bytes, std::size_t at, int value) {
    bytes[at] = static_cast<std::uint8_t>(value);
    return why_not(std::move(bytes));
}
std::string parameter(Bytes bytes, float value) {
    std::memcpy(&bytes[8], &value, 4);
    return why_not(std::move(bytes));
}
void says(const std::string& why, const char* what) {
    EXPECT_NE(why.find(what), std::string::npos) << '"' << why << "\" instead of " << what;
}

// Header byte by byte, as docs/protocol.md lays it out, each signed anew: the ends of each range decode or
// are left to what follows, and one beyond is an error that says what was wrong.
TEST(TileCodec, f8_each_value_of_a_header_has_its_range) {
    const std::vector<float> samples = random_samples(small, 1, 9);
    const Bytes constant = encoded(std::vector<float>(15, 2.5f), small, 0);
    const Bytes quantised = encoded(samples, small, 0.01f);
    const Bytes lossless = encoded(samples, small, 0);
    ASSERT_EQ(constant[1], 0);
    ASSERT_EQ(quantised[1], 1);
    ASSERT_EQ(lossless[1], 2);
    constexpr float inf = std::numeric_limits<float>::infinity();
    constexpr float nan = std::numeric_limits<float>::quiet_NaN();
    for (const Bytes& tile : {constant, quantised, lossless}) {
        EXPECT_EQ(why_not(tile), "");
        says(byte(tile, 0, 0), "tile codec version 0, 1 is known");
        says(byte(tile, 0, 2), "tile codec version 2, 1 is known");
        says(byte(tile, 1, 4), "tile mode 4, 0 to 3 are known");
        says(byte(tile, 2, 6), "tile of 6 x 3 samples, 5 x 3 expected");
        says(byte(tile, 4, 4), "tile of 5 x 4 samples, 5 x 3 expected");
        says(byte(tile, 7, 1), "tile mode");
        for (const float wrong : {nan, inf, -inf})
            says(parameter(tile, wrong), "parameter");
    }
    for (const Bytes& tile : {quantised, lossless}) {
        says(byte(tile, 6, 0), "with 0 byte planes");
        says(byte(tile, 6, 5), "with 5 byte planes");
        Bytes longer = tile;
        longer.push_back(0);
        EXPECT_NE(why_not(longer), "");
    }
    says(byte(constant, 6, 1), "with 1 byte planes");
    Bytes longer = constant;
    longer.push_back(0);
    says(why_not(longer), "mode 0");
    std::vector<float> out(15);
    const auto cut = decode_tile(std::span(constant).first(15), small, 5, out);
    ASSERT_FALSE(cut.has_value());
    says(cut.error().message, "15 bytes, at least 16 are needed");
    for (const float fine : {0.0f, -3.5f, 3e38f})
        EXPECT_EQ(parameter(constant, fine), "") << fine;
    for (const float fine : {1e-45f, 1.0f, 0x1p96f})
        EXPECT_EQ(parameter(quantised, fine), "") << fine;
    for (const float wrong : {0.0f, -0.01f, std::nextafter(0x1p96f, inf)})
        says(parameter(quantised, wrong), "parameter");
    for (const float wrong : {0.01f, -0.01f, 1e-45f})
        says(parameter(lossless, wrong), "parameter");
}

// A tile that is flat but for one sample is not constant, wherever that sample lies.
TEST(TileCodec, one_sample_that_differs_is_kept_wherever_it_lies) {
    const TileShape shape{4, 3};
    for (const float error : {0.0f, 0.1f})
        for (std::size_t at = 0; at < 12; ++at) {
            std::vector<float> samples(12, 2.0f);
            samples[at] = 5.0f;
            const double allowed = static_cast<double>(error);
            EXPECT_LE(seaway::tests::largest_difference(
                          decoded(encoded(samples, shape, error), shape), samples),
                      allowed)
                << at;
        }
}

// The next float above the largest is infinity. A tile so small is not compressed: each byte is tried.
TEST(TileCodec, f8_no_byte_makes_the_largest_float_infinite) {
    const TileShape shape{3, 2};
    const std::vector<float> samples(6, std::numeric_limits<float>::max());
    std::vector<float> other = samples;
    other[0] = 1.0f;
    const Bytes bytes = encoded(other, shape, 0);
    int decodable = 0;
    for (std::size_t at = 16; at < bytes.size(); ++at)
        for (int value = 0; value < 256; ++value) {
            Bytes bad = bytes;
            bad[at] = static_cast<std::uint8_t>(value);
            const std::uint32_t checksum = tile_checksum(bad);
            std::memcpy(&bad[12], &checksum, 4);
            std::vector<float> out(6);
            if (!decode_tile(bad, shape, 3, out).has_value())
                continue;
            ++decodable;
            for (const float sample : out)
                ASSERT_TRUE(std::isfinite(sample)) << at << ' ' << value;
        }
    EXPECT_GT(decodable, 100);
}

// Byte 6: planes. A residual r is coded 2r or -2r - 1, so that one byte holds -128 .. 127.
TEST(TileCodec, residuals_take_as_many_byte_planes_as_they_need_and_no_more) {
    const float step = 0.5f - 0x1p-20f; // of an error of 0.25, near enough
    for (const auto& [quantum, planes] :
         {std::pair{127, 1}, {-128, 1}, {128, 2}, {-129, 2}, {32000, 2}, {40000, 3}}) {
        const std::vector<float> samples{0.0f, static_cast<float>(quantum) * step};
        EXPECT_EQ(encoded(samples, {2, 1}, 0.25f)[6], planes) << quantum;
    }
}

TEST(TileCodec, f9_sizes_1_to_17_by_1_to_17_and_strides_round_trip) {
    for (int height = 1; height <= 17; ++height)
        for (int width = 1; width <= 17; ++width) {
            const auto stride = static_cast<std::size_t>(width + height % 3);
            const TileShape store{static_cast<int>(stride), height};
            const std::vector<float> samples =
                random_samples(store, 1, static_cast<std::uint64_t>(100 * height + width));
            const auto bytes = encode_tile(samples, {width, height}, stride, 1e-3f);
            ASSERT_TRUE(bytes.has_value());
            std::vector<float> out(samples.size(), 9.0f);
            ASSERT_TRUE(decode_tile(*bytes, {width, height}, stride, out).has_value());
            for (int y = 0; y < height; ++y)
                for (std::size_t x = 0; x < stride; ++x) {
                    const std::size_t i = static_cast<std::size_t>(y) * stride + x;
                    if (x < static_cast<std::size_t>(width))
                        ASSERT_LE(std::abs(out[i] - samples[i]), 1e-3f);
                    else // between the rows nothing is written
                        ASSERT_EQ(out[i], 9.0f);
                }
        }
}

TEST(TileCodec, golden_bytes_decode_to_the_same_floats_for_ever) {
    // The worked example of docs/protocol.md. A wire change needs a new version and a new golden,
    // never an edited one.
    const std::array<std::uint8_t, 37> golden{
        0x01, 0x01, 0x04, 0x00, 0x03, 0x00, 0x01, 0x00, 0xf8, 0xff, 0xff, 0x3e, 0x5f,
        0x47, 0x59, 0x2c, 0x28, 0xb5, 0x2f, 0xfd, 0x20, 0x0c, 0x61, 0x00, 0x00, 0x02,
        0x02, 0x02, 0x02, 0x01, 0x00, 0x00, 0x00, 0x02, 0x00, 0x02, 0x11};
    const std::array<std::int32_t, 12> quanta{1, 2, 3, 4, 0, 1, 2, 3, 1, 2, 4, -4};
    const std::vector<float> back = decoded(golden, {4, 3});
    for (std::size_t i = 0; i < quanta.size(); ++i)
        EXPECT_EQ(back[i], static_cast<float>(quanta[i] * 0.49999976158142090)) << "sample " << i;

    const std::array<float, 12> samples{0.5f, 1.0f, 1.5f, 2.0f, 0.0f,  0.5f,
                                        1.0f, 1.5f, 0.5f, 1.0f, 1.75f, -2.0f};
    const Bytes bytes = encoded(samples, {4, 3}, 0.25f);
    // Another version of zstd may write another frame; what is ours is the same bytes everywhere.
    EXPECT_TRUE(std::equal(golden.begin(), golden.begin() + 12, bytes.begin()));
    EXPECT_EQ(decoded(bytes, {4, 3}), back);
}

TEST(TileCodec, golden_bytes_of_a_lossless_tile_decode_to_the_same_floats_for_ever) {
    const std::array<std::uint8_t, 66> golden{
        0x01, 0x02, 0x04, 0x00, 0x03, 0x00, 0x04, 0x00, 0x00, 0x00, 0x00, 0x00, 0x52, 0x2a,
        0xc8, 0x7e, 0x28, 0xb5, 0x2f, 0xfd, 0x20, 0x30, 0x4d, 0x01, 0x00, 0x04, 0x02, 0x00,
        0x00, 0x00, 0x00, 0xff, 0xff, 0xfe, 0xff, 0x00, 0x00, 0x80, 0x80, 0xff, 0x00, 0x80,
        0x00, 0x00, 0xff, 0x3f, 0xbf, 0x7e, 0x01, 0x00, 0x00, 0x7d, 0x7d, 0x00, 0x00, 0x7e,
        0x7c, 0x00, 0xff, 0x02, 0x00, 0x2f, 0x86, 0x71, 0x15, 0x2d};
    const std::vector<float> samples{0.5f, 1.0f, 1.5f, 2.0f, 0.0f,  0.5f,
                                     1.0f, 1.5f, 0.5f, 1.0f, 1.75f, -2.0f};
    EXPECT_EQ(decoded(golden, {4, 3}), samples);
}

TEST(TileCodec, a10_sea_tiles_at_one_centimetre_need_3_1_bits_a_sample_at_most_2_4_in_the_mean) {
    // Mean over height and both displacements, as the reference measured it.
    for (const auto& [wind_mps, fetch_m] : {std::pair{8.0, 100e3}, std::pair{20.0, 300e3}}) {
        double sum = 0;
        for (const tests::SampleBand& band : tests::sample_bands()) {
            double bits = 0;
            for (const auto map : {tests::SampleMap::height, tests::SampleMap::displacement_x,
                                   tests::SampleMap::displacement_y}) {
                const std::vector<float> samples =
                    tests::sample_map(band, 256, wind_mps, fetch_m, map);
                const Bytes bytes = encoded(samples, {256, 256}, 0.01f);
                ASSERT_LE(seaway::tests::largest_difference(samples, decoded(bytes, {256, 256})),
                          static_cast<double>(0.01f));
                bits += static_cast<double>(bytes.size()) * 8 / (256 * 256) / 3;
            }
            RecordProperty("bits_" + std::to_string(static_cast<int>(band.length_m)),
                           std::to_string(bits));
            EXPECT_LE(bits, 3.1) << "tile of " << band.length_m << " m, wind " << wind_mps;
            sum += bits;
        }
        EXPECT_LE(sum / 3, 2.4) << "wind " << wind_mps;
    }
}

} // namespace
} // namespace seaway::protocol
