// SPDX-License-Identifier: Apache-2.0
#include "client/wave_room.h"

#include <algorithm>
#include <functional>

namespace seaway::client {

std::vector<std::uint32_t> waves_to_let_go(std::vector<WavesHeld> held, std::size_t points_beside,
                                           std::size_t points_max) {
    std::ranges::stable_sort(held, std::greater<>{}, &WavesHeld::away_us);
    std::size_t points = points_beside;
    for (const WavesHeld& waves : held)
        points += waves.points;
    std::vector<std::uint32_t> go;
    for (const WavesHeld& waves : held) {
        if (points <= points_max)
            break;
        go.push_back(waves.epoch);
        points -= waves.points;
    }
    return go;
}

} // namespace seaway::client
