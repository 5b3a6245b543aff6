// SPDX-License-Identifier: Apache-2.0
// A gale on small tiles, with foam.
#pragma once

#include <string>

#include "tests/support/folder.h"

namespace seaway::tests {

/// `more` stands before the tiles: rows of the file.
inline std::string small_gale(const std::string& name = "small_gale.toml",
                              const std::string& more = "") {
    return folder().write(name, R"([sea]
seed = 7
depth_m = 60.0
choppiness = 1.0
[[sea.system]]
type = "wind"
spectrum = "jonswap"
wind_speed_10m_mps = 19.0
fetch_m = 100e3
from_deg = 300
)" + more + R"([[cascade]]
length_m = 811.0
size = 128
[[cascade]]
length_m = 97.0
size = 64
[effects]
displacement = "choppy"
foam = true
[accuracy]
height_error_m = 0.02
)");
}

/// A gale with foam on tiles of one size, whose keyframes fall due at different times.
inline std::string foaming_tiles() {
    return folder().write("foaming_tiles.toml", R"([[sea.system]]
type = "wind"
spectrum = "jonswap"
wind_speed_10m_mps = 19.0
fetch_m = 100e3
from_deg = 300
[[cascade]]
length_m = 811.0
size = 64
[[cascade]]
length_m = 97.0
size = 64
[effects]
displacement = "choppy"
foam = true
[accuracy]
height_error_m = 0.05
)");
}

/// Waves without foam, on tiles of one size.
inline std::string calm_tiles() {
    return folder().write("calm_tiles.toml", R"([[sea.system]]
type = "swell"
spectrum = "jonswap"
significant_height_m = 1
peak_period_s = 6
from_deg = 300
[[cascade]]
length_m = 211.0
size = 64
[[cascade]]
length_m = 31.0
size = 64
[effects]
displacement = "choppy"
foam = false
)");
}

} // namespace seaway::tests
