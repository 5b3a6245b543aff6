// SPDX-License-Identifier: Apache-2.0
// Scenes by lot, most of them odd. The same number gives the same scene, as long as the compiler
// draws operands in the same order: a scene that shows something is kept as text.
#pragma once

#include <cstdint>
#include <string>

namespace seaway::tests {

/// What is odd about a scene; random_scene() goes round them.
enum class Oddity {
    gaps,       ///< a measured spectrum with bins that hold nothing
    empty,      ///< cascades without a wave, first, middle or last
    loop,       ///< a loop of 1 to 60 s
    narrow,     ///< a swell of one direction
    steep,      ///< high waves, choppiness above 1: the surface folds
    shallow,    ///< water of half a metre
    many_tiles, ///< five cascades
    crossing,   ///< systems from anywhere, any model, tiles that fit badly
};
inline constexpr int oddity_count = 8;
const char* name(Oddity oddity);

struct RandomScene {
    Oddity oddity;
    std::string toml;
};

RandomScene random_scene(std::uint64_t seed, int number);

/// Seas at the ends of what there is, one kind after the other: ripples of less than a millimetre on tiles
/// of some metres; waves of 30 to 100 m, trough to crest, on tiles of many kilometres; both in one sea.
std::string extreme_scene(std::uint64_t seed, int number);
inline constexpr int extreme_count = 3;

} // namespace seaway::tests
