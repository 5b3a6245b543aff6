// SPDX-License-Identifier: Apache-2.0
// The random numbers of a sea: one pair of independent N(0,1) values for each mode, a pure function
// of who the mode is. Neither the grid size nor the order of drawing changes them.
//
// Box-Muller with our own logarithm, sine and cosine in plain + - * / sqrt, so that the values are
// the same bits on every IEEE machine (std::normal_distribution and libm differ between systems).
// Thread-safe; about 60 ns a pair.
#pragma once

#include <cstdint>

namespace seaway::sea {

/// Two independent N(0,1) values; |value| <= 6.77.
struct GaussianPair {
    double real;
    double imaginary;
};

/// Who a mode is. The cascade is named by the length of its tile, so that a mode keeps its numbers
/// when the grid size changes or another cascade is added.
struct ModeKey {
    std::uint64_t seed;
    std::uint32_t system; ///< index of the wave system in the sea state
    std::uint32_t cascade;
    std::int32_t nx;
    std::int32_t ny;
};

/// ModeKey::cascade of a tile: its length in whole millimetres. length_m 0.1 .. 1e6.
std::uint32_t cascade_key(double length_m);

GaussianPair gaussian_pair(const ModeKey& key);

/// Box-Muller on two words, u = (word + 0.5) / 2^32: never log(0).
GaussianPair gaussian_from_words(std::uint32_t radius_word, std::uint32_t angle_word);

} // namespace seaway::sea
