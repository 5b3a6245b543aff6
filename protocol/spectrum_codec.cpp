// SPDX-License-Identifier: Apache-2.0
#include "protocol/spectrum_codec.h"

#include <algorithm>
#include <bit>

#include <fmt/format.h>

#include "protocol/checksum.h"
#include "protocol/limits.h"
#include "protocol/tile_layout.h"
#include "protocol/zstd_memory.h"

namespace seaway::protocol {
namespace {

using tile_layout::get;
using tile_layout::put;
using tile_layout::unzigzag;
using tile_layout::zigzag;

constexpr std::uint8_t codec_version = 1;
constexpr std::size_t header_bytes = 8; ///< version, planes, count of blocks, CRC-32
constexpr std::size_t checksum_at = 4;
constexpr std::size_t block_head_bytes = 4; ///< cascade, flags, bx, by
constexpr std::uint8_t flag_given = 16;     ///< above the four bits of the shift
constexpr std::size_t codes_a_block = std::tuple_size_v<decltype(sea::WaveBlock::codes)>;
/// A sea is encoded once for all: its bytes count, not the time.
constexpr int zstd_level = 19;

std::uint32_t checksum(std::span<const std::uint8_t> bytes) {
    return crc32(bytes.subspan(header_bytes), crc32(bytes.first(checksum_at)));
}

std::size_t raw_bytes(std::size_t blocks, std::size_t planes) {
    return blocks * (block_head_bytes + planes * codes_a_block);
}

/// Byte planes that hold every code.
int planes_of(std::span<const sea::WaveBlock> blocks) {
    std::uint32_t all = 0;
    for (const sea::WaveBlock& block : blocks)
        for (const std::int32_t code : block.codes)
            all |= zigzag(static_cast<std::uint32_t>(code));
    return std::max(1, (static_cast<int>(std::bit_width(all)) + 7) / 8);
}

int signed_byte(std::uint8_t byte) {
    return byte < 128 ? byte : byte - 256;
}

bool fits(const sea::WaveBlock& block) {
    const auto index = [](int n) {
        return n >= -sea::WaveBlock::index_max - 1 && n <= sea::WaveBlock::index_max;
    };
    return block.cascade >= 0 && block.cascade < limits::cascades_max && index(block.bx) &&
           index(block.by) && block.shift >= 0 && block.shift <= sea::WaveBlock::shift_max;
}

} // namespace

Bytes encode_spectrum(std::span<const sea::WaveBlock> blocks) {
    SEAWAY_CHECK(!blocks.empty() && blocks.size() <= limits::spectrum_blocks_max &&
                     std::all_of(blocks.begin(), blocks.end(), fits),
                 "blocks of a spectrum beyond what a chunk holds");
    const int planes = planes_of(blocks);
    Bytes raw;
    raw.reserve(raw_bytes(blocks.size(), static_cast<std::size_t>(planes)));
    for (const sea::WaveBlock& block : blocks) {
        raw.push_back(static_cast<std::uint8_t>(block.cascade));
        raw.push_back(static_cast<std::uint8_t>(block.shift | (block.given ? flag_given : 0)));
        raw.push_back(static_cast<std::uint8_t>(block.bx));
        raw.push_back(static_cast<std::uint8_t>(block.by));
    }
    for (int plane = 0; plane < planes; ++plane)
        for (const sea::WaveBlock& block : blocks)
            for (const std::int32_t code : block.codes)
                raw.push_back(static_cast<std::uint8_t>(zigzag(static_cast<std::uint32_t>(code)) >>
                                                        (8 * plane)));
    Bytes bytes(header_bytes + ZSTD_compressBound(raw.size()));
    const std::size_t written =
        unless_no_memory(ZSTD_compress(bytes.data() + header_bytes, bytes.size() - header_bytes,
                                       raw.data(), raw.size(), zstd_level));
    SEAWAY_CHECK(!ZSTD_isError(written), "zstd has the room that it asked for");
    bytes.resize(header_bytes + written);
    bytes[0] = codec_version;
    bytes[1] = static_cast<std::uint8_t>(planes);
    put(&bytes[2], static_cast<std::uint16_t>(blocks.size()));
    put(&bytes[checksum_at], checksum(bytes));
    return bytes;
}

Result<std::vector<sea::WaveBlock>> decode_spectrum(std::span<const std::uint8_t> bytes) {
    if (bytes.size() < header_bytes)
        return Error{fmt::format("spectrum of {} bytes, at least {} are needed", bytes.size(),
                                 header_bytes)};
    if (get<std::uint32_t>(&bytes[checksum_at]) != checksum(bytes))
        return Error{"spectrum checksum does not match"};
    if (bytes[0] != codec_version)
        return Error{
            fmt::format("spectrum codec version {}, {} is known", bytes[0], codec_version)};
    const std::size_t planes = bytes[1], count = get<std::uint16_t>(&bytes[2]);
    if (planes < 1 || planes > 4 || count < 1 || count > limits::spectrum_blocks_max)
        return Error{fmt::format("spectrum of {} blocks with {} byte planes", count, planes)};
    Bytes raw(raw_bytes(count, planes));
    const std::size_t read = unless_no_memory(ZSTD_decompress(
        raw.data(), raw.size(), bytes.data() + header_bytes, bytes.size() - header_bytes));
    if (ZSTD_isError(read))
        return Error{fmt::format("spectrum does not decompress: {}", ZSTD_getErrorName(read))};
    if (read != raw.size())
        return Error{fmt::format("spectrum holds {} bytes, {} expected", read, raw.size())};
    std::vector<sea::WaveBlock> blocks(count);
    const std::uint8_t* const codes = raw.data() + count * block_head_bytes;
    for (std::size_t b = 0; b < count; ++b) {
        const std::uint8_t* head = raw.data() + b * block_head_bytes;
        if (head[0] >= limits::cascades_max || head[1] >= 2 * flag_given)
            return Error{fmt::format("block of cascade {} with flags {}", head[0], head[1])};
        blocks[b].cascade = head[0];
        blocks[b].shift = head[1] & sea::WaveBlock::shift_max;
        blocks[b].given = (head[1] & flag_given) != 0;
        blocks[b].bx = signed_byte(head[2]);
        blocks[b].by = signed_byte(head[3]);
        for (std::size_t i = 0; i < codes_a_block; ++i) {
            std::uint32_t code = 0;
            for (std::size_t plane = 0; plane < planes; ++plane)
                code |= static_cast<std::uint32_t>(codes[(plane * count + b) * codes_a_block + i])
                        << (8 * plane);
            blocks[b].codes[i] = static_cast<std::int32_t>(unzigzag(code));
        }
    }
    return blocks;
}

} // namespace seaway::protocol
