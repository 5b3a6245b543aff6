// SPDX-License-Identifier: Apache-2.0
// Options of a program from a file, TOML 1.0: `listen = "127.0.0.1:9430"`, `sessions-max = 17`, `log-all = true`,
// `allow-origin = ["https://a.example", "https://b.example"]`. No tables: an option has no parts.
#pragma once

#include <string>
#include <vector>

#include "base/result.h"

namespace seaway {

struct FileOption {
    std::string name;               ///< without "--"
    std::vector<std::string> words; ///< its values as on a command line; of a bool none
    bool is_bool = false;
    bool value = true; ///< of a bool
    unsigned line = 0;
};

/// In the order of their names. The error names file, line and what is wrong.
Result<std::vector<FileOption>> read_options_file(const std::string& path);

} // namespace seaway
