// SPDX-License-Identifier: Apache-2.0
// The options of seaway-view that are of the look.
#pragma once

#include <limits>
#include <optional>
#include <string>

#include "base/command_line.h"
#include "client/view/sky/look.h"

namespace seaway::client {

/// As they stand on the command line.
struct LookWords {
    static constexpr double nothing = std::numeric_limits<double>::quiet_NaN(); ///< not given

    std::string path, environment, exposure, water, place, date;
    double hour = nothing, visibility_km = nothing, clouds = nothing, density = nothing;
    bool list = false;

    void describe(CommandLine& line);
    /// The file, then what wins over it.
    Result<void> take(Look& look, std::optional<double>& cell_pixels) const;
};

/// For --list-look.
void list_look_keys();

} // namespace seaway::client
