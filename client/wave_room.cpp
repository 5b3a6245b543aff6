// SPDX-License-Identifier: Apache-2.0
#include "client/wave_room.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <limits>

namespace seaway::client {

double away_us(std::span<const SeaStatePtr> by_start, sea::TimeUs now_us, std::uint32_t epoch) {
    const auto held = std::ranges::find(by_start, epoch, &SeaState::epoch);
    if (held == by_start.end())
        return std::numeric_limits<double>::infinity();
    const auto now = static_cast<double>(now_us);
    const auto next = std::next(held);
    const double over_us =
        next == by_start.end() ? 0 : now - static_cast<double>((*next)->start_time_us);
    return std::max({static_cast<double>((*held)->start_time_us) - now, over_us, 0.0});
}

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
