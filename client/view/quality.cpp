// SPDX-License-Identifier: Apache-2.0
#include "client/view/quality.h"

#include <string>

namespace seaway::client {

Result<Quality> parse_quality(std::string_view name) {
    std::string names;
    for (const Quality& row : quality_table) {
        if (row.name == name)
            return row;
        names += (names.empty() ? "" : ", ") + std::string(row.name);
    }
    return Error{"--quality " + std::string(name) + ": no such quality; there are " + names};
}

} // namespace seaway::client
