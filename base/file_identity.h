// SPDX-License-Identifier: Apache-2.0
// Which file a path leads to: another one, or none, once it was removed or replaced.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace seaway {

struct FileIdentity {
    std::uint64_t device = 0;
    std::uint64_t number = 0; ///< on it

    bool operator==(const FileIdentity&) const = default;
};

/// Nothing: there is none, or it cannot be reached.
std::optional<FileIdentity> file_identity(const std::string& path);

} // namespace seaway
