// SPDX-License-Identifier: Apache-2.0
// CRC-32 as zlib, PNG and Ethernet have it (polynomial 0xEDB88320, reflected): every language a
// client is written in has it. Thread-safe. About 1.5 GB/s.
#pragma once

#include <cstdint>
#include <span>

namespace seaway::protocol {

/// crc32("123456789") = 0xCBF43926. `seed`: the CRC of what came before, 0 at the start.
std::uint32_t crc32(std::span<const std::uint8_t> bytes, std::uint32_t seed = 0);

/// CRC of an encoded tile of at least 16 bytes: all of it but the CRC's own place, bytes 12 to 15.
std::uint32_t tile_checksum(std::span<const std::uint8_t> tile);

} // namespace seaway::protocol
