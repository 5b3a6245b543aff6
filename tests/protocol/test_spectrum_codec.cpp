// SPDX-License-Identifier: Apache-2.0
// Blocks of waves to bytes and back; bytes that are something else.
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "protocol/checksum.h"
#include "protocol/limits.h"
#include "protocol/spectrum_codec.h"

namespace seaway::protocol {
namespace {

using sea::WaveBlock;

std::vector<WaveBlock> some_blocks(std::size_t count, std::int32_t largest) {
    std::mt19937 random(11);
    std::uniform_int_distribution<std::int32_t> code(-largest - 1, largest);
    std::uniform_int_distribution<int> index(-128, 127);
    std::vector<WaveBlock> blocks(count);
    for (WaveBlock& block : blocks) {
        block = {index(random) & 15, index(random),     index(random),
                 index(random) & 15, index(random) > 0, {}};
        for (std::int32_t& one : block.codes)
            one = code(random);
    }
    return blocks;
}

/// With a checksum that fits, so that what lies behind it is reached.
Bytes mended(Bytes bytes) {
    if (bytes.size() >= 8) {
        const std::span<const std::uint8_t> all(bytes);
        const std::uint32_t sum = crc32(all.subspan(8), crc32(all.first(4)));
        std::memcpy(&bytes[4], &sum, sizeof sum);
    }
    return bytes;
}

TEST(SpectrumCodec, blocks_come_back_as_they_were_whatever_their_codes) {
    for (const std::int32_t largest :
         {0, 1, 127, 128, 40'000, 10'000'000, std::numeric_limits<std::int32_t>::max()})
        for (const std::size_t count :
             {std::size_t{1}, std::size_t{7}, limits::spectrum_blocks_max}) {
            const std::vector<WaveBlock> blocks = some_blocks(count, largest);
            const Result<std::vector<WaveBlock>> back = decode_spectrum(encode_spectrum(blocks));
            ASSERT_TRUE(back) << back.error().message;
            EXPECT_EQ(*back, blocks);
        }
}

TEST(SpectrumCodec, small_codes_are_few_bytes) {
    const std::vector<WaveBlock> blocks =
        some_blocks(64, 1); // -2 .. 1: two bits each, and heads by lot
    EXPECT_LE(encode_spectrum(blocks).size(), 64u * 128 * 3 / 8);
}

TEST(SpectrumCodec, every_cut_and_every_flipped_bit_is_seen) {
    const Bytes bytes = encode_spectrum(some_blocks(3, 300));
    for (std::size_t length = 0; length < bytes.size(); ++length)
        EXPECT_FALSE(decode_spectrum(std::span(bytes).first(length))) << length;
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
        Bytes flipped = bytes;
        flipped[bit / 8] = static_cast<std::uint8_t>(flipped[bit / 8] ^ (1u << (bit % 8)));
        EXPECT_FALSE(decode_spectrum(flipped)) << bit;
    }
}

TEST(SpectrumCodec, a_head_that_says_too_much_is_refused_before_memory_is_taken) {
    const Bytes bytes = encode_spectrum(some_blocks(3, 300));
    const auto why = [&](std::size_t at, std::uint8_t value) {
        Bytes other = bytes;
        other[at] = value;
        const auto read = decode_spectrum(mended(std::move(other)));
        return read ? std::string() : read.error().message;
    };
    EXPECT_NE(why(0, 2).find("version 2"), std::string::npos);
    EXPECT_NE(why(1, 0).find("0 byte planes"), std::string::npos);
    EXPECT_NE(why(1, 5).find("5 byte planes"), std::string::npos);
    EXPECT_NE(why(3, 255).find("blocks"), std::string::npos);
    EXPECT_NE(why(2, 4), "") << "a block more than there are bytes for";
    EXPECT_NE(why(1, 1), "") << "a plane less";
}

TEST(SpectrumCodec, mutated_bytes_with_a_checksum_that_fits_are_an_error_or_blocks) {
    std::mt19937 random(5);
    for (int i = 0; i < 20'000; ++i) {
        Bytes bytes = encode_spectrum(some_blocks(1 + random() % 3, 1000));
        for (unsigned n = random() % 4 + 1; n > 0; --n)
            bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
        bytes.resize(bytes.size() - random() % 3);
        const auto read = decode_spectrum(mended(std::move(bytes)));
        if (read)
            for (const WaveBlock& block : *read) {
                EXPECT_TRUE(block.cascade >= 0 && block.cascade < limits::cascades_max);
                EXPECT_TRUE(block.shift >= 0 && block.shift <= WaveBlock::shift_max);
            }
    }
}

} // namespace
} // namespace seaway::protocol
