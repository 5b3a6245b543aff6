// SPDX-License-Identifier: Apache-2.0
#include "client/tile_limits.h"

#include <fmt/format.h>

#include "protocol/limits.h"

namespace seaway::client {

namespace limits = protocol::limits;

void TileLimits::describe(CommandLine& line) {
    line.option("--rate-max", rate_hz_max,
                "Streamed keyframes of each cascade a second of sea time, at most; what that "
                "misses is stated")
        .takes("HZ");
    line.option("--size-max", size_max,
                "Streamed maps have so many points a side at most; what that misses is stated")
        .takes("POINTS");
}

Result<void> TileLimits::check() const {
    if (rate_hz_max != 0 &&
        !(rate_hz_max >= limits::rate_hz_min && rate_hz_max <= limits::rate_hz_max))
        return Error{fmt::format("--rate-max {}: {} to {}", rate_hz_max, limits::rate_hz_min,
                                 limits::rate_hz_max)};
    if (size_max != 0 && !(size_max >= limits::size_min && size_max <= limits::map_side_max))
        return Error{fmt::format("--size-max {}: {} to {}", size_max, limits::size_min,
                                 limits::map_side_max)};
    return {};
}

void TileLimits::put_into(protocol::TileWish& wish) const {
    wish.rate_hz_max = static_cast<float>(rate_hz_max);
    wish.size_max = size_max;
}

} // namespace seaway::client
