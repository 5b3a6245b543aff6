// SPDX-License-Identifier: Apache-2.0
// What lies side by side at a point of a SplineMap: eight floats, three of them values, three their time rates.
// Who mixes two keyframes keeps the first four. Nothing of the standard library: kernels of every
// instruction set read it.
#pragma once

namespace seaway::sea::spline_channel {

inline constexpr int height = 0;
inline constexpr int displacement_x = 1;
inline constexpr int displacement_y = 2;
inline constexpr int values = 3; ///< channels before this one are values
inline constexpr int rate = 4;   ///< the time rate of a channel lies so many behind it
inline constexpr int mixed = 4; ///< floats a point once two keyframes are mixed; the last is unused
inline constexpr int count = 8;

} // namespace seaway::sea::spline_channel
