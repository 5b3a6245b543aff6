// SPDX-License-Identifier: Apache-2.0
// The header of a bulk map, byte by byte as docs/protocol.md has it.
#include <algorithm>
#include <bit>
#include <cstring>
#include <vector>

#include <gtest/gtest.h>

#include "protocol/map_header.h"

namespace seaway::protocol {
namespace {

TEST(MapHeader, is_64_bytes_little_endian_as_documented) {
    sea::MapRequest request;
    request.kind = sea::MapKind::normal;
    request.columns = 0x102;
    request.rows = 80;
    request.x0_m = -37.5; // 0xC042C00000000000
    request.y0_m = 2.0;
    request.width_m = 3.0;
    request.height_m = 4.0;
    request.time_us = -2;
    const auto bytes = map_header(request, 0.25);
    const std::vector<std::uint8_t> start(bytes.begin(), bytes.begin() + 24);
    EXPECT_EQ(start, (std::vector<std::uint8_t>{'S', 'W', 'M', 'P', 1, 0, 2, 0, 2, 1, 0,    0,
                                                80,  0,   0,   0,   3, 0, 0, 0, 0, 0, 0x80, 0x3E}));
    EXPECT_EQ(bytes[31], 0xC0);
    EXPECT_EQ(bytes[30], 0x42);
    EXPECT_EQ(bytes[29], 0xC0);
    double rest[3]; // tests run on little-endian machines
    std::memcpy(rest, bytes.data() + 32, sizeof rest);
    EXPECT_EQ(rest[0], 2.0);
    EXPECT_EQ(rest[1], 3.0);
    EXPECT_EQ(rest[2], 4.0);
    EXPECT_EQ(bytes[56], 0xFE);
    EXPECT_TRUE(
        std::all_of(bytes.begin() + 57, bytes.end(), [](auto byte) { return byte == 0xFF; }));
}

// Naive: rounded to the nearest float a bound is broken by half a step of it.
TEST(MapHeader, a_bound_is_never_narrowed) {
    for (const double error_m : {0.1, 0.7, 1.0 / 3.0, 0.25, 1e-30}) { // of 0.7 the nearest is below
        const auto bytes = map_header({}, error_m);
        float stated_m = 0;
        std::memcpy(&stated_m, bytes.data() + 20, sizeof stated_m);
        EXPECT_GE(static_cast<double>(stated_m), error_m);
        EXPECT_LE(static_cast<double>(stated_m), error_m * (1 + 1e-6));
    }
}

} // namespace
} // namespace seaway::protocol
