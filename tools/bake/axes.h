// SPDX-License-Identifier: Apache-2.0
// Which way is up in the program that reads a bake. Seaway is z up (x east, y north); many film and
// game tools are y up. Both frames are right-handed.
#pragma once

#include <array>

namespace seaway::bake {

enum class UpAxis { z, y };

/// (east, north, up) in the reader's frame: y up is (east, up, south).
inline std::array<float, 3> turned(UpAxis up, float east, float north, float height) {
    return up == UpAxis::z ? std::array{east, north, height} : std::array{east, height, -north};
}

} // namespace seaway::bake
