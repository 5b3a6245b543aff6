// SPDX-License-Identifier: Apache-2.0
// Layout of an encoded tile, shared by encoder and decoder; not for others (docs/protocol.md).
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>

#include "base/result.h"
#include "protocol/tile_codec.h"

namespace seaway::protocol::tile_layout {

// Layout, little endian (docs/protocol.md): version, mode, width, height, planes, 0, parameter,
// checksum, zstd frame.
inline constexpr std::uint8_t codec_version = 1;
inline constexpr std::size_t header_bytes = 16;
inline constexpr std::size_t checksum_at = 12;
/// Largest |q|: q * step is exact in a double (30 + 24 bits) and every int32 sum of two fits.
inline constexpr double quantum_max = 0x1p30;
/// Largest step: 2^31 of them are still a float.
inline constexpr float step_max = 0x1p96f;

enum class Mode : std::uint8_t {
    constant = 0,  ///< parameter is the value of every sample
    quantised = 1, ///< parameter is the step; integers q, sample = float(q * step)
    lossless = 2,  ///< parameter is 0; integers are the floats' bits, in numerical order
};

static_assert(std::endian::native == std::endian::little, "the wire is little endian");

template <class T>
void put(std::uint8_t* at, T value) {
    std::memcpy(at, &value, sizeof value);
}

template <class T>
T get(const std::uint8_t* at) {
    T value;
    std::memcpy(&value, at, sizeof value);
    return value;
}

/// Shape within limits, and the samples hold it?
Result<void> check_call(std::size_t samples, TileShape shape, std::size_t row_stride);

inline std::uint32_t zigzag(std::uint32_t residual) {
    return (residual << 1) ^ (0u - (residual >> 31));
}

inline std::uint32_t unzigzag(std::uint32_t code) {
    return (code >> 1) ^ (0u - (code & 1u));
}

/// Float bits as integers in numerical order, and back.
inline std::uint32_t ordered_bits(float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    return bits ^ ((0u - (bits >> 31)) >> 1);
}

inline std::uint32_t unordered_bits(std::uint32_t ordered) {
    return ordered ^ ((0u - (ordered >> 31)) >> 1);
}

} // namespace seaway::protocol::tile_layout
