// SPDX-License-Identifier: Apache-2.0
// FrameHeader: what goes before a message of a server (RFC 6455, 5.2): whole, binary, not masked.
#pragma once

#include <array>
#include <cstdint>

namespace seaway::sockets {

struct FrameHeader {
    explicit FrameHeader(std::size_t length) {
        constexpr std::uint8_t last_of_binary = 0x82;
        const int length_bytes = length < 126 ? 0 : length < 65536 ? 2 : 8;
        bytes[size++] = last_of_binary;
        bytes[size++] = static_cast<std::uint8_t>(length_bytes == 0   ? length
                                                  : length_bytes == 2 ? 126
                                                                      : 127);
        for (int shift = 8 * (length_bytes - 1); shift >= 0; shift -= 8)
            bytes[size++] = static_cast<std::uint8_t>(length >> shift);
    }
    std::array<std::uint8_t, 10> bytes{};
    std::size_t size = 0;
};

} // namespace seaway::sockets
