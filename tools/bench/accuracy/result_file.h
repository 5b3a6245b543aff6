// SPDX-License-Identifier: Apache-2.0
// Files of figures: whole or not at all, and found out before anything is measured if they cannot be written.
#pragma once

#include <string>
#include <string_view>

#include "base/result.h"

namespace seaway::bench {

/// Makes the folder of `path`, and sees whether the file could be written there. The error names it.
Result<void> check_result(const std::string& path);
Result<void> write_result(const std::string& path, std::string_view text);

} // namespace seaway::bench
