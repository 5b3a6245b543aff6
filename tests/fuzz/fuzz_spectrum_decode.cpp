// SPDX-License-Identifier: Apache-2.0
// Bytes as a chunk of a spectrum, with a checksum that fits: an error, or blocks that encode and decode to themselves.
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>
#include <vector>

#include "protocol/checksum.h"
#include "protocol/spectrum_codec.h"

using namespace seaway::protocol;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    std::vector<std::uint8_t> bytes(data, data + size);
    if (bytes.size() >= 8) {
        const std::span<const std::uint8_t> all(bytes);
        const std::uint32_t sum = crc32(all.subspan(8), crc32(all.first(4)));
        std::memcpy(&bytes[4], &sum, sizeof sum);
    }
    const auto blocks = decode_spectrum(bytes);
    if (!blocks)
        return 0;
    const auto again = decode_spectrum(encode_spectrum(*blocks));
    if (!again || *again != *blocks)
        std::abort();
    return 0;
}
