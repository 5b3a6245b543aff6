// SPDX-License-Identifier: Apache-2.0
// A change of the sea that somebody asks for, and what he is promised. Values.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/toml_edit.h"
#include "sea/basics/time.h"

namespace seaway::server {

struct SeaWish {
    /// Values set in the scene that runs, or that the sea glides to (sea/scene/weather.h); empty where `scene` is given.
    std::vector<TomlAssignment> set = {};
    std::string scene = {}; ///< another scene, TOML; empty where values are set
    sea::TimeUs over_us = 0;
    /// Sea time at which it is to begin; earlier than can be: as soon as can be.
    sea::TimeUs at_us = 0;
    /// How fast the sea is to run; nothing else is changed then.
    std::optional<int> pace_permille = {};
};

/// The change is durable. One of pace has no epoch, and begins and ends at once.
struct SeaPromise {
    std::uint32_t epoch = 0; ///< of the glide; that of the sea which it leads to is the next
    sea::TimeUs start_us = 0;
    sea::TimeUs end_us = 0;
    std::uint32_t change = 0; ///< its number in the journal; 0: there is none
};

} // namespace seaway::server
