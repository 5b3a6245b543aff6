// SPDX-License-Identifier: Apache-2.0
// Values set in a TOML text by path: "accuracy.height_error_m", "sea.system.0.from_deg" (the first of an array).
// Pure; thread-safe. Errors name the assignment.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace seaway {

struct TomlAssignment {
    std::string path;
    std::string value; ///< as TOML writes it

    bool operator==(const TomlAssignment&) const = default;
};

/// "path=value". A value that is no TOML, such as a bare word, is taken as a text.
Result<TomlAssignment> parse_toml_assignment(std::string_view text);

/// The text with these values, in order; comments are lost. The tables on the way to a key must be there, the key need
/// not. Every number comes out as it went in, bit for bit. First the keys of `without` go, where there are such.
Result<std::string> with_toml_values(std::string_view text, const std::string& name,
                                     std::span<const TomlAssignment> values,
                                     std::span<const std::string> without = {});

/// Keys of the table at this path; none where there is no such table.
std::vector<std::string> toml_keys(std::string_view text, std::string_view path);

} // namespace seaway
