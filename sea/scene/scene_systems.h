// SPDX-License-Identifier: Apache-2.0
// The part of the scene reader that knows wave systems. Used by the scene reader only.
#pragma once

#include <string>

#include "base/toml_document.h"
#include "sea/waves/sea_state.h"

namespace seaway::sea {

/// Reads every [[sea.system]] into `sea`; errors go to the table's document.
void read_systems(TomlTable& sea_table, const std::string& base_dir, SeaState& sea);

/// `preset = "beaufort:7"` and the direction it comes from (towards east where it is not needed and
/// not given), as one more system.
void read_preset(TomlTable& table, SeaState& sea, bool needs_direction);

} // namespace seaway::sea
