// SPDX-License-Identifier: Apache-2.0
// How many waves a client keeps that servers send to it, and which it lets go for more.
//
// Pure; thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "client/link/connection.h"
#include "sea/basics/time.h"
#include "sea/waves/spectrum_builder.h"

namespace seaway::client {

/// Of one point of a tile: an amplitude and a frequency.
inline constexpr std::size_t wave_point_bytes = 24;
/// Points of all tiles whose waves are held: as many as of four of the largest seas there may be, 805 MB.
inline constexpr std::size_t wave_points_max = 4 * sea::spectrum_modes_max;

/// The waves of a sea that is done without if it has to be.
struct WavesHeld {
    std::uint32_t epoch;
    std::size_t points; ///< that are free again without it
    double away_us;     ///< from now to when its sea runs; 0: it does; infinite: never
};

/// From now to when the sea of `epoch` runs, in microseconds: to its beginning, or since that of the next one.
/// 0: it runs; infinite: none of these states, in the order of their beginning, is of that epoch.
double away_us(std::span<const SeaStatePtr> by_start, sea::TimeUs now_us, std::uint32_t epoch);

/// The epochs that go, the furthest from now first, until no more than `points_max` are left with the
/// `points_beside` of the next and of those that stay. None where there is room; all where there is none without them.
std::vector<std::uint32_t> waves_to_let_go(std::vector<WavesHeld> held, std::size_t points_beside,
                                           std::size_t points_max = wave_points_max);

} // namespace seaway::client
