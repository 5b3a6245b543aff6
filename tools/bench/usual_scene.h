// SPDX-License-Identifier: Apache-2.0
// What is measured where no scene is named.
#pragma once

#include <string>

namespace seaway::bench {

/// scenes/north_sea_gale.toml, as of a folder of the source; where that is not there, the copy that is installed with this
/// program, PREFIX/share/seaway/bench/north_sea_gale.toml.
std::string usual_scene();

} // namespace seaway::bench
