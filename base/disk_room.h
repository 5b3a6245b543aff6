// SPDX-License-Identifier: Apache-2.0
// Has a disk room for another file?
#pragma once

#include <string>

namespace seaway {

/// The disk of this path, or of the folder that it would be in, has no block or no name for a file left. False where that is not
/// known.
bool is_disk_full(const std::string& path);

} // namespace seaway
