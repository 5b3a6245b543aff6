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
    difference =
        3 ///< parameter is the fine step; integers r, sample = float(fine * (round(expected / fine) + fine_steps r))
};

/// Steps of the lattice that predicted samples lie on, in one step of their difference: what is expected is rounded to that
/// lattice, and the difference sees little of it.
inline constexpr int fine_steps = 8;
/// Byte planes of a difference of which each number is less than half a byte, two in one: the first one lower.
inline constexpr int halves = 0;
inline constexpr std::uint32_t half_max = 15;
/// A difference begins with the CRC of the samples that it comes to (their bytes, row by row).
inline constexpr std::size_t samples_check_bytes = 4;

/// What is expected, and what it becomes, lies within so many steps of it.
inline constexpr double lattice_max = 0.5 * quantum_max;

/// The nearest point of a lattice, in its steps; below 2^31 of them. Adding 1.5 * 2^52 rounds to the nearest integer and
/// leaves it in the low bits.
inline std::int32_t nearest_step(double value, double step) {
    return static_cast<std::int32_t>(std::bit_cast<std::uint64_t>(value / step + 0x1.8p52));
}

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

/// Of the bytes of samples, row by row.
std::uint32_t samples_checksum(std::span<const float> samples, TileShape shape,
                               std::size_t row_stride);

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
