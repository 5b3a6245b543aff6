// SPDX-License-Identifier: Apache-2.0
// Frames as a client sends them, written from RFC 6455, 5.2, for tests.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace seaway::sockets {

using FrameBytes = std::vector<std::uint8_t>;

struct ClientFrame {
    std::uint8_t opcode = 2;
    bool last = true;
    std::array<std::uint8_t, 4> mask{0x11, 0x82, 0x3c, 0xf7};
};

inline void append_client_frame(FrameBytes& out, std::span<const std::uint8_t> payload,
                                const ClientFrame& frame = {}) {
    out.push_back(static_cast<std::uint8_t>((frame.last ? 0x80 : 0) | frame.opcode));
    const std::size_t length = payload.size();
    const int bytes = length < 126 ? 0 : length < 65536 ? 2 : 8;
    out.push_back(static_cast<std::uint8_t>(0x80 | (bytes == 0 ? length : bytes == 2 ? 126 : 127)));
    for (int shift = 8 * (bytes - 1); shift >= 0; shift -= 8)
        out.push_back(static_cast<std::uint8_t>(length >> shift));
    out.insert(out.end(), frame.mask.begin(), frame.mask.end());
    for (std::size_t i = 0; i < length; ++i)
        out.push_back(static_cast<std::uint8_t>(payload[i] ^ frame.mask[i % 4]));
}

inline FrameBytes client_frame(std::span<const std::uint8_t> payload,
                               const ClientFrame& frame = {}) {
    FrameBytes out;
    append_client_frame(out, payload, frame);
    return out;
}

} // namespace seaway::sockets
