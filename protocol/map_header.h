// SPDX-License-Identifier: Apache-2.0
// The 64 bytes that stand before the rows of a bulk map (docs/protocol.md, "Bulk maps"),
// little-endian:
//   0 "SWMP"  4 u16 version = 1  6 u16 kind (0 height, 1 displacement, 2 normal)
//   8 u32 columns  12 u32 rows  16 u32 floats a point  20 f32 error_m
//   24 f64 x0_m  32 f64 y0_m  40 f64 width_m  48 f64 height_m  56 i64 time_us
// A pure function; thread-safe.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "sea/surface/height_map.h"

namespace seaway::protocol {

inline constexpr std::size_t map_header_bytes = 64;

/// `error_m` bounds the heights (sea::map_height_error_m).
std::array<std::uint8_t, map_header_bytes> map_header(const sea::MapRequest& request,
                                                      double error_m);

} // namespace seaway::protocol
