// SPDX-License-Identifier: Apache-2.0
// FNV-1a of 64 bits (Fowler, Noll, Vo): tells texts apart that were not made to collide.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include <fmt/format.h>

namespace seaway {

constexpr std::uint64_t text_hash(std::string_view text) {
    std::uint64_t hash = 0xcbf29ce484222325u;
    for (const char c : text)
        hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
    return hash;
}

/// As sixteen hexadecimal digits.
inline std::string hex_hash(std::string_view text) {
    return fmt::format("{:016x}", text_hash(text));
}

} // namespace seaway
