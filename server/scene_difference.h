// SPDX-License-Identifier: Apache-2.0
// What one scene says other than another, for people: by the path of each value, as `seaway-ctl set` takes it. Of texts that
// sea::to_toml() wrote, a value a line; rows of a table are values of its key. Pure; n log n in both.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace seaway::server {

struct SceneDifference {
    std::string path;                  ///< "sea.system.0.from_deg"
    std::optional<std::string> before; ///< none: it was not there
    std::optional<std::string> after;  ///< none: it is there no more
};

/// In the order of `after`, then what is there no more.
std::vector<SceneDifference> scene_differences(const std::string& before, const std::string& after);

} // namespace seaway::server
