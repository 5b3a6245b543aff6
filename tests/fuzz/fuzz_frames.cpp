// SPDX-License-Identifier: Apache-2.0
// Frames of a WebSocket: whatever comes, in whatever pieces, the same messages come out, none above its limit.
// Input: bytes as a client sends them.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "sockets/frame_reader.h"

using namespace seaway::sockets;

namespace {

constexpr std::size_t message_bytes_max = 1000;

/// All that is read, one behind the other, until the error if there is one.
std::vector<std::uint8_t> read_in_pieces(std::span<const std::uint8_t> bytes, std::size_t piece) {
    FrameReader reader(message_bytes_max, 16);
    std::vector<std::uint8_t> read;
    while (!bytes.empty()) {
        std::span<const std::uint8_t> part = bytes.first(std::min(piece, bytes.size()));
        bytes = bytes.subspan(part.size());
        for (bool promised = false;; promised = FrameReader::gives_message(part)) {
            const auto next = reader.next(part);
            if (promised && next && (!*next || (*next)->kind != FrameReader::Kind::message))
                std::abort(); // answers would be held back for it
            if (!next) {
                read.push_back(next.error().is(BadFrame::too_large) ? 1 : 2);
                return read;
            }
            if (!*next)
                break;
            if ((*next)->bytes.size() > message_bytes_max)
                std::abort();
            read.push_back(static_cast<std::uint8_t>((*next)->kind));
            read.insert(read.end(), (*next)->bytes.begin(), (*next)->bytes.end());
            if ((*next)->kind == FrameReader::Kind::close)
                (void)read_close((*next)->bytes);
        }
    }
    return read;
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::span<const std::uint8_t> bytes(data, size);
    const std::vector<std::uint8_t> whole = read_in_pieces(bytes, size + 1);
    if (read_in_pieces(bytes, 1) != whole || read_in_pieces(bytes, 7) != whole)
        std::abort();
    return 0;
}
