// SPDX-License-Identifier: Apache-2.0
// Codecs that a map may be sent with: ours, and those that a library offers, as yardsticks only. Those of a library
// that is not installed are left out.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace seaway::bench {

/// A square map to bytes and back. Not thread-safe; keeps its scratch.
struct Codec {
    std::string name;
    /// Of size x size samples, [y][x]; `error`: the bound that is asked for, where the codec has any.
    std::function<std::vector<std::uint8_t>(std::span<const float> map, int size, float error)>
        encode;
    std::function<std::vector<float>(std::span<const std::uint8_t> bytes, int size, float error)>
        decode;
};

std::vector<Codec> codecs();

} // namespace seaway::bench
