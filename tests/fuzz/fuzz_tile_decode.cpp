// SPDX-License-Identifier: Apache-2.0
// Bytes as an encoded tile, whole or a difference, with a checksum that fits: an error, or finite samples and nothing
// written outside of the rows. First two bytes: the shape.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "protocol/checksum.h"
#include "protocol/tile_codec.h"

using namespace seaway::protocol;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size < 2)
        return 0;
    const TileShape shape{data[0] + 1, data[1] + 1};
    std::vector<std::uint8_t> bytes(data + 2, data + size);
    if (bytes.size() >= 16) {
        const std::uint32_t checksum = tile_checksum(bytes);
        std::memcpy(&bytes[12], &checksum, sizeof checksum);
    }
    const auto stride = static_cast<std::size_t>(shape.width) + 1;
    std::vector<float> samples(stride * static_cast<std::size_t>(shape.height), 0.5f);
    const std::vector<float> expected(samples.size(), -3.25f);
    if (is_difference(bytes) ? decode_tile_difference(bytes, shape, stride, expected, samples)
                             : decode_tile(bytes, shape, stride, samples))
        for (const float sample : samples)
            if (!std::isfinite(sample))
                std::abort();
    for (std::size_t at = stride - 1; at < samples.size(); at += stride)
        if (samples[at] != 0.5f)
            std::abort();
    return 0;
}
