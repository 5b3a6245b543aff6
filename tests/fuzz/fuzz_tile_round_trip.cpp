// SPDX-License-Identifier: Apache-2.0
// Bytes as a bound, a width and samples: refused, or encoded, decoded and within the bound; in two forms, too, where the samples
// are expected to be those before them.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "protocol/tile_codec.h"

using namespace seaway::protocol;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    float bound = 0;
    if (size < sizeof bound + 1 + sizeof(float))
        return 0;
    std::memcpy(&bound, data, sizeof bound);
    const std::size_t width = data[sizeof bound] % 32 + 1u;
    std::vector<float> samples((size - sizeof bound - 1) / sizeof(float));
    std::memcpy(samples.data(), data + sizeof bound + 1, samples.size() * sizeof(float));
    const std::size_t height = samples.size() / width;
    if (height == 0 || height > 256)
        return 0;
    const TileShape shape{static_cast<int>(width), static_cast<int>(height)};
    const auto bytes = encode_tile(samples, shape, width, bound);
    if (!bytes)
        return 0;
    std::vector<float> expected(samples.begin(), samples.end()), decoded(samples.size()),
        other(samples.size());
    std::rotate(expected.begin(), expected.begin() + 1, expected.end());
    const auto forms = encode_tile_forms(samples, shape, width, bound, expected, decoded);
    const std::size_t in_tile = width * height * sizeof(float);
    if (!forms || !decode_tile(forms->whole, shape, width, other) ||
        std::memcmp(other.data(), decoded.data(), in_tile) != 0)
        std::abort();
    if (!forms->difference.empty() &&
        (!decode_tile_difference(forms->difference, shape, width, expected, other) ||
         std::memcmp(other.data(), decoded.data(), in_tile) != 0))
        std::abort();
    std::vector<float> back(width * height);
    if (!decode_tile(*bytes, shape, width, back))
        std::abort();
    for (std::size_t i = 0; i < back.size(); ++i) {
        const bool exact = std::memcmp(&back[i], &samples[i], sizeof(float)) == 0;
        if (!exact && !(std::abs(static_cast<double>(back[i]) - static_cast<double>(samples[i])) <=
                        static_cast<double>(bound)))
            std::abort();
        if (bound == 0 && !exact)
            std::abort();
    }
    return 0;
}
